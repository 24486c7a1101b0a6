//! PD022: `ball` of something that is no constant of the horizon.

use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD022";

pub(crate) fn changes(span: Span, why: &str) -> Diagnostic {
    Diagnostic::error(
        CODE,
        "`ball` integrates functions of the reference bond length only",
    )
    .at(span, why)
    .help("the bonds that a node has are summed with `sum(..)` or, broken or not, `sum0(..)`")
}

pub(crate) fn only_in_laws(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "`ball` has a meaning in laws only")
        .at(span, "there is no horizon here")
}
