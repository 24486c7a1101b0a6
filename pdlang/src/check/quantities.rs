//! PD034: a default, bound or argument that does not have the right unit, or is no number.

use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD034";

pub(crate) fn wrong_unit(
    what: &str,
    span: Span,
    found: Option<&str>,
    expected: &str,
) -> Diagnostic {
    let label = match found {
        Some(unit) => format!("found {unit}, expected {expected}"),
        None => format!("a number without a unit, expected {expected}"),
    };
    Diagnostic::error(CODE, format!("{what} has the wrong unit")).at(span, label)
}

pub(crate) fn not_a_number(what: &str, span: Span) -> Diagnostic {
    Diagnostic::error(CODE, format!("{what} must be a number")).at(span, "not a number")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::refuse;

    #[test]
    fn numbers_have_units() {
        refuse("param p : pressure > 5 \"p\"", "PD034", "5");
        refuse("param p : pressure = 5 mm \"p\"", "PD034", "5 mm");
        refuse(
            "history p : length = 1 on bond \"p\" update p = x",
            "PD034",
            "1",
        );
        refuse("influence a = gaussian(l = 1)", "PD034", "1");
        refuse("influence a = gaussian(l = 1 kg)", "PD034", "1 kg");
        refuse("influence a = power(p = exp(1))", "PD034", "exp(1)");
    }
}
