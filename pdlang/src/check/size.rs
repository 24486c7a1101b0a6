//! PD009: a law without end.

use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD009";

pub(crate) fn too_deep(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "this expression is nested too deeply")
        .at(span, "")
        .help("give parts of it a name with `let`, `node` or `bond`")
}

pub(crate) fn too_large(span: Span) -> Diagnostic {
    Diagnostic::error(
        CODE,
        "this law grows without end as its functions are inlined",
    )
    .at(span, "the limit is reached here")
    .help("give parts of it a name with `let`, `node` or `bond`")
}
