//! PD027: a weight that is not determined by the reference body.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD027";

pub(crate) fn changes(weight: &Name, span: Span, why: &str) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!(
            "the weight `{}` is computed once, at the start",
            weight.text
        ),
    )
    .at(span, why)
    .help("it may depend on reference bonds and positions, `sum0(..)` of them, and `under(..)`")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn a_weight_depends_on_the_reference_body_alone() {
        refuse("weight w = e/x \"w\"", "PD027", "e");
        refuse("weight w = sum(x)/ball(x) \"w\"", "PD027", "sum(x)");
        refuse("weight w = min(x)/x \"w\"", "PD027", "min(x)");
        refuse("node q = sum(x) weight w = q'/ball(x) \"w\"", "PD027", "q");
        refuse(
            "weight w = norm(velocity)*dt/delta \"w\"",
            "PD027",
            "velocity",
        );
        accept(
            "node q = sum0(under(I, s)*x)/ball(x) weight w = (q + q')/2*norm(X)/delta \"w\" node r = sum(w*x)",
        );
    }

    #[test]
    fn a_weight_is_a_number_with_a_description() {
        refuse("weight w = x \"w\"", "PD013", "x");
        refuse("weight w = xi/x \"w\"", "PD007", "xi/x");
        refuse("weight w = x/delta", "PD032", "w");
        refuse("weight w = w' \"w\"", "PD005", "w");
    }
}
