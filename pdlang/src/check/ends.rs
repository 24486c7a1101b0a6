//! PD042: a pair force, or a family whose bonds carry forces, that is not the same from both ends.

use crate::ast::{Item, Model};
use crate::diag::Diagnostic;
use crate::ends;
use crate::ir::{ExprId, ExprKind, FamilyId, Law, Response};
use std::collections::BTreeSet;

const CODE: &str = "PD042";

/// The pair forces of a law, which is right otherwise, that tell the ends of a bond apart.
pub(crate) fn unlike(model: &Model, law: &Law) -> Vec<Diagnostic> {
    let written = model.items.iter().filter_map(|item| match item {
        Item::Response(response) => Some(response.expr.span),
        _ => None,
    });
    let one = |(response, span)| {
        match response {
        &Response::Pair(_, force) if !ends::alike(law, force) => Some(
            Diagnostic::error(CODE, "the pair force is not the same from both ends")
                .at(span, "seen from the other end this has another value")
                .help("use both ends alike, as in `(C + C')/2`; a force that belongs to one end is a `state`"),
        ),
        _ => None,
    }
    };
    law.responses.iter().zip(written).filter_map(one).collect()
}

/// Families whose bonds carry forces, of a law that is right otherwise, that hold a bond in one direction alone.
pub(crate) fn one_way(law: &Law) -> Vec<Diagnostic> {
    let mut carry: BTreeSet<FamilyId> = BTreeSet::new();
    for response in &law.responses {
        match response {
            Response::Pair(family, _) | Response::State(family, _) => {
                carry.insert(*family);
            }
            Response::Energy(energy) => {
                let sums = law.all_behind(vec![*energy]).into_iter();
                carry.extend(sums.filter_map(|expr| match law.exprs[expr.index()].kind {
                    ExprKind::Reduce(_, family, of) if moves(law, of) => Some(family),
                    _ => None,
                }));
            }
            _ => {}
        }
    }
    let families = carry.iter().map(|family| &law.families[family.index()]);
    let filters = families.filter_map(|family| Some((&family.name, family.filter?)));
    let one_way = filters.filter(|(_, filter)| !ends::alike(law, *filter));
    let finding = |(name, filter): (&String, ExprId)| {
        let message = format!("the family `{name}` is not the same from both ends");
        Diagnostic::error(CODE, message)
            .at(law.exprs[filter.index()].span, "seen from the other end a bond of it is none")
            .help("a bond carries its force at both ends, so both have it: `abs(xi.x)` has no direction")
    };
    one_way.map(finding).collect()
}

/// Whether a value changes with the displacement.
fn moves(law: &Law, expr: ExprId) -> bool {
    let parts = law.all_behind(vec![expr]).into_iter();
    parts
        .map(|part| &law.exprs[part.index()].kind)
        .any(|kind| matches!(kind, ExprKind::Eta))
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, bare, refuse, refuse_text};

    const NODE: &str = "field C : number \"C\" node theta = mean(s) let c = K/(delta*ball(1)) ";

    #[test]
    fn node_values_are_used_from_both_ends_alike() {
        for force in [
            "c*(s - C)",
            "c*theta",
            "c*(s - C')",
            "c*(C - C')",
            "c*min(C, s)",
            "c*C*theta'",
            "c*select(C > C', C, s)",
            "c*xi.x/x",
            "c*s*velocity.x/(1 m/(1 s))",
            "c*s*X.x/delta",
        ] {
            refuse(&format!("{NODE} pair f = {force}"), "PD042", force);
        }
    }

    #[test]
    fn bonds_that_carry_forces_have_both_directions() {
        const UP: &str = "family up = horizon where xi.x > 0.3*x let c = K/(delta*ball(1))";
        for carries in [
            "pair[up] f = c*s",
            "state[up] T = c*s*M",
            "node q = sum[up](s)/ball(1) energy U = K*q^2",
        ] {
            let law = bare(&format!(
                "param K : pressure > 0 \"modulus\" {UP} {carries}"
            ));
            refuse_text(&law, "PD042", "xi.x > 0.3*x");
        }
        accept(&format!(
            "{UP} node q = sum[up](1)/ball(1) pair f = c*s*(q + q')"
        ));
        accept(&format!(
            "{} pair[up] f = c*s",
            UP.replace("xi.x", "abs(xi.x)")
        ));
        accept(&format!(
            "{} pair[up] f = c*s",
            UP.replace("xi.x", "norm(xi)*xi.x^2/x^2")
        ));
    }

    #[test]
    fn what_both_ends_agree_on_passes() {
        for force in [
            "c*(s - (C + C')/2)",
            "c*theta*theta'",
            "c*abs(C - C')",
            "c*min(C, C')",
            "c*select(C > C', C, C')*s",
            "c*sqrt(C*C' + (C^1.5 + C'^1.5))",
            "c*s*abs(xi.x)/x",
            "c*s*(xi.x/x)^2",
            "c*cos(Y.x/y)",
            "c*(theta' - theta)*xi.x/x",
            "c*s*omega/ball(omega)*delta^3*ball(1)/ball(1)/delta^3*ball(1)",
            "c*s*dt/(1 s)",
            "c*s*exp(-(C + C')*x/delta)",
        ] {
            accept(&format!("{NODE} pair f = {force}"));
        }
    }

    #[test]
    fn weights_are_opened() {
        let weighted = |mean: &str, force: &str| {
            format!("{NODE} node q = sum0(x)/ball(x) weight w = {mean} \"w\" pair f = {force}")
        };
        accept(&weighted("2/(q + q')", "c*w*s"));
        accept(&weighted("1/q", "c*(w + w')*s"));
        refuse(&weighted("1/q", "c*w*s"), "PD042", "c*w*s");
    }

    #[test]
    fn histories_of_bonds_are_the_same_from_both_ends() {
        accept(&format!(
            "{NODE} history worst : number = 0 on bond \"worst\" history d : vector length = 0 on bond \"d\"
             update worst = max(worst, s) update d = eta pair f = c*(s - worst/2 + dot(d, M)/delta)"
        ));
        let node = "history heat : number = 0 on node \"heat\" update heat = heat + 1";
        refuse(&format!("{NODE} {node} pair f = c*heat"), "PD042", "c*heat");
    }
}
