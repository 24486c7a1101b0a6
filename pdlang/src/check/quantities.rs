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
