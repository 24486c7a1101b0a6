//! PD025: a family that is not part of the reference horizon.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD025";

pub(crate) fn changes(name: &Name, span: Span, why: &str) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("the family `{}` would change during the run", name.text),
    )
    .at(span, why)
    .help("families are chosen once, by the reference bond: `xi`, `x` and constants")
}

pub(crate) fn base(name: &Name) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("a family is a part of `horizon`, not of `{}`", name.text),
    )
    .at(name.span, "expected `horizon`")
}
