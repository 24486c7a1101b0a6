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

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn integrates_functions_of_the_length() {
        refuse("let c = ball(e)", "PD022", "e");
        refuse("let c = ball(xi.x)", "PD022", "xi");
        refuse("let c = ball(x')", "PD022", "x'");
        refuse("let c = ball(sum(x)*x)", "PD022", "sum(x)");
        refuse("let c = ball(norm(x*xi))", "PD022", "xi");
        refuse("influence a = ball(x)", "PD022", "ball(x)");
        accept("let c = ball(omega*x^2/norm(xi) + x*omega) bond r = 2*x let d = ball(r)");
    }
}
