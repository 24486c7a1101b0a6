//! PD015: a response in the wrong unit.

use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD015";

/// What the law answers, in words, with the unit found, the unit expected and what the one lacks to be the other.
pub(crate) fn wrong(
    what: &str,
    span: Span,
    found: &str,
    expected: &str,
    factor: &str,
) -> Diagnostic {
    Diagnostic::error(CODE, format!("{what} has the wrong unit"))
        .at(span, format!("found {found}, expected {expected}"))
        .help(format!("what is missing is a factor of unit {factor}"))
}

/// All is right but for the influence function, whose scale a scene may choose.
pub(crate) fn depends_on_influence(what: &str, span: Span, names: &str) -> Diagnostic {
    Diagnostic::error(CODE, format!("{what} depends on the scale of {names}"))
        .at(span, format!("the unit of {names} does not cancel"))
        .help("an influence function is known up to a factor only: divide by a sum of it, such as `sum(omega*x^2)` or `ball(omega*x)`")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, bare, refuse, refuse_text};

    #[test]
    fn responses_have_their_units() {
        refuse_text(
            &bare("param K : pressure \"K\" energy W = K*sum(s^2)"),
            "PD015",
            "K*sum(s^2)",
        );
        refuse("pair f = K*s", "PD015", "K*s");
        refuse(
            "state T = K*omega*s/ball(omega*x)*x",
            "PD015",
            "K*omega*s/ball(omega*x)*x",
        );
        refuse("field T : temperature \"T\" rate T = T", "PD015", "T");
        refuse(
            "history p : length on bond \"p\" update p = s",
            "PD015",
            "s",
        );
    }

    #[test]
    fn the_factor_is_what_is_missing() {
        let text = bare("param K : pressure \"K\" energy W = K*sum(s^2)");
        let help = crate::front::file(&text).diagnostics[0].help.clone();
        // A sum over volumes too much.
        assert_eq!(
            help.as_deref(),
            Some("what is missing is a factor of unit m^-3")
        );
    }

    #[test]
    fn influence_functions_cancel() {
        refuse("state T = K*omega*s/ball(x)", "PD015", "K*omega*s/ball(x)");
        accept("state T = K*omega*s/ball(omega*x)");
    }
}
