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
