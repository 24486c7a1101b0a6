//! PD033: an interval that is empty, a default outside of it.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::ir::Bound;
use crate::span::Span;

const CODE: &str = "PD033";

pub(crate) fn empty(name: &Name, span: Span) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("no value of `{}` is within its bounds", name.text),
    )
    .at(span, "this bound leaves nothing")
}

pub(crate) fn outside(name: &Name, span: Span, bound: Span) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("the default of `{}` is outside of its bounds", name.text),
    )
    .at(span, "default")
    .at(bound, "bound")
}

pub(crate) fn is_empty(lower: Option<Bound>, upper: Option<Bound>) -> bool {
    match (lower, upper) {
        (Some(lower), Some(upper)) => {
            lower.value > upper.value
                || lower.value == upper.value && !(lower.inclusive && upper.inclusive)
        }
        _ => false,
    }
}

pub(crate) fn contains(lower: Option<Bound>, upper: Option<Bound>, value: f64) -> bool {
    let above =
        lower.is_none_or(|bound| value > bound.value || bound.inclusive && value == bound.value);
    let below =
        upper.is_none_or(|bound| value < bound.value || bound.inclusive && value == bound.value);
    above && below
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn defaults_are_within_bounds() {
        refuse("param p : number > 0 = 0 \"p\"", "PD033", "0");
        refuse("param p : number in (-1, 0.5) = 0.5 \"p\"", "PD033", "0.5");
        refuse("param p : number > 1 < 0 \"p\"", "PD033", "0");
        refuse("param p : number in (1, 1] \"p\"", "PD033", "in (1, 1]");
        accept(
            "param p : number >= 0 < 1 = 0 \"p\" param q : pressure in [1 MPa, 2 GPa] = 1 MPa \"q\" param r : number in [1, 1] \"r\"",
        );
        accept("param p : number > 0 = inf \"p\"");
    }
}
