//! PD021: a prime on what has no other end.

use crate::diag::Diagnostic;
use crate::ir::Expr;
use crate::span::Span;

const CODE: &str = "PD021";

pub(crate) fn constant(inner: &Expr, span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "a constant is the same at both ends of a bond")
        .at(span, "primed")
        .at(inner.span, "a constant")
        .help("leave out the prime")
}

pub(crate) fn twice(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "the other end of the other end is this end")
        .at(span, "primed twice")
        .help("leave out both primes")
}

pub(crate) fn outside_of_law(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "a prime has a meaning in laws only")
        .at(span, "there are no bonds here")
}
