//! PD021: a prime on what has no other end.

use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD021";

pub(crate) fn constant(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "a constant is the same at both ends of a bond")
        .at(span, "a prime on a constant")
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
