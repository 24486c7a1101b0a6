//! PD015: a response in the wrong unit.

use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD015";

/// What the law answers, in words, with the unit found and the unit expected.
pub(crate) fn wrong(
    what: &str,
    span: Span,
    found: &str,
    expected: &str,
    factor: &str,
) -> Diagnostic {
    Diagnostic::error(CODE, format!("{what} has the wrong unit"))
        .at(span, format!("found {found}, expected {expected}"))
        .help(format!("it is off by a factor of unit {factor}"))
}

/// All is right but for the influence function, whose scale a scene may choose.
pub(crate) fn depends_on_influence(what: &str, span: Span, names: &str) -> Diagnostic {
    Diagnostic::error(CODE, format!("{what} depends on the scale of {names}"))
        .at(span, format!("the unit of {names} does not cancel"))
        .help("an influence function is known up to a factor only: divide by a sum of it, such as `sum(omega*x^2)` or `ball(omega*x)`")
}
