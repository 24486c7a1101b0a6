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

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn only_what_has_another_end_is_primed() {
        refuse("bond b = K'", "PD021", "K'");
        refuse("bond b = s''", "PD021", "s''");
        refuse("bond b = (other(s))'", "PD021", "(other(s))'");
        refuse("influence a = x'", "PD021", "x'");
        accept("node m = sum(x) bond b = m' - m + other(x)*ball(1) bond c = b' - (b*s)'");
    }
}
