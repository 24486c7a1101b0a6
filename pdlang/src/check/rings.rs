//! PD024: an energy whose force cannot be derived: it needs the neighbours of neighbours, or jumps.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD024";

pub(crate) fn second(energy: &Name, span: Span) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("the energy `{}` needs a second ring", energy.text),
    )
    .at(
        span,
        "a sum over the bonds of the other end, which changes with the displacement",
    )
    .at(
        energy.span,
        "its force would reach the neighbours of neighbours",
    )
    .help("write the force state itself with `state`, which may read sums of both ends")
}

pub(crate) fn extreme(energy: &Name, span: Span) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("the energy `{}` has no derivative", energy.text),
    )
    .at(
        span,
        "the smallest or largest of many bonds jumps from one to another",
    )
    .at(energy.span, "its force is its derivative")
    .help("use `sum` or `mean`, or write the force with `state` or `pair`")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, bare, found, refuse_text};

    #[test]
    fn energies_see_one_ring() {
        let energy = |items: &str| bare(&format!("param K : pressure \"K\" {items}"));
        refuse_text(
            &energy("node t = sum(s)/ball(1) energy W = K*sum(t' - t)/ball(1)"),
            "PD024",
            "t'",
        );
        refuse_text(
            &energy("node t = sum(s)/ball(1) bond d = t' energy W = K*sum(d)/ball(1)"),
            "PD024",
            "d",
        );
        refuse_text(
            &energy("node t = sum(s)/ball(1) bond d = s - t energy W = K*sum(d')/ball(1)"),
            "PD024",
            "d'",
        );
    }

    #[test]
    fn extremes_have_no_derivative() {
        let items = |w: &str| bare(&format!("param K : pressure \"K\" energy W = {w}"));
        refuse_text(&items("K*min(s)^2"), "PD024", "min(s)");
        refuse_text(
            &items("K*sum(s^2)*max(x)/max(e)/ball(1)"),
            "PD024",
            "max(e)",
        );
        let text = items("K*mean(s^2)*max(x)/delta*count(s > 0)");
        assert_eq!(found(&text), [] as [(&str, String); 0]);
    }

    #[test]
    fn what_does_not_move_may_be_read_at_the_other_end() {
        accept("node m = sum(omega*x) state f = (m' + m)/m*K*s'/(delta*ball(1))");
        let items = "param K : pressure \"K\" node m = sum(x) node t = sum(s) energy W = K*sum((m'/m + 1)*s' + t*0/ball(1))/ball(1)";
        assert_eq!(found(&bare(items)), [] as [(&str, String); 0]);
    }
}
