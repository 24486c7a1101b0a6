//! PD028: a history of the bonds of one family, read on those of another.

use crate::diag::Diagnostic;
use crate::ir::{ExprId, ExprKind, FamilyId, HistoryId, Home, Law, Response};
use crate::resolve::walk::operands;
use crate::span::Span;
use std::collections::BTreeSet;

const CODE: &str = "PD028";

/// Where a law, which is right otherwise, reads what is kept for other bonds.
pub(crate) fn elsewhere(law: &Law) -> Vec<Diagnostic> {
    if law
        .histories
        .iter()
        .all(|history| history.home != Home::Bond)
    {
        return vec![];
    }
    let read = histories(law);
    let mut found: Vec<(Span, Diagnostic)> = places(law)
        .into_iter()
        .flat_map(|(expr, family)| {
            let others = read[expr.index()].iter().copied();
            let others = others.filter(move |h| law.histories[h.index()].family != family);
            others.map(move |h| (expr, family, h))
        })
        .map(|(expr, family, history)| finding(law, &read, (expr, family, history)))
        .collect();
    // A sum that several definitions share is one place.
    let mut seen = BTreeSet::new();
    found.retain(|(span, _)| seen.insert((span.start, span.end)));
    found.into_iter().map(|(_, finding)| finding).collect()
}

/// Of every expression, the histories of bonds that it reads on the bond at hand. What an expression is made of stands
/// before it.
fn histories(law: &Law) -> Vec<BTreeSet<HistoryId>> {
    let mut read: Vec<BTreeSet<HistoryId>> = Vec::with_capacity(law.exprs.len());
    for expr in &law.exprs {
        read.push(match &expr.kind {
            ExprKind::Reduce(..) => BTreeSet::new(),
            ExprKind::History(id) if law.histories[id.index()].home == Home::Bond => [*id].into(),
            kind => {
                let parts = through(law, kind).into_iter();
                parts
                    .flat_map(|part| read[part.index()].iter().copied())
                    .collect()
            }
        });
    }
    read
}

/// Operands, or what stands behind a definition.
fn through(law: &Law, kind: &ExprKind) -> Vec<ExprId> {
    match kind {
        ExprKind::Def(def) => vec![law.defs[def.index()].expr],
        kind => operands(kind),
    }
}

/// What is formed on the bonds of which family.
fn places(law: &Law) -> Vec<(ExprId, FamilyId)> {
    let sums = law.exprs.iter().filter_map(|expr| match expr.kind {
        ExprKind::Reduce(_, family, of) => Some((of, family)),
        _ => None,
    });
    let responses = law.responses.iter().filter_map(|response| match response {
        Response::Pair(family, force) | Response::State(family, force) => Some((*force, *family)),
        _ => None,
    });
    let breaks = law.breaks.iter().map(|b| (b.when, b.family));
    let kept = law.histories.iter().filter(|h| h.home == Home::Bond);
    let updates = kept.map(|h| (h.update, h.family));
    sums.chain(responses).chain(breaks).chain(updates).collect()
}

fn finding(
    law: &Law,
    read: &[BTreeSet<HistoryId>],
    (mut expr, family, history): (ExprId, FamilyId, HistoryId),
) -> (Span, Diagnostic) {
    let name = &law.histories[history.index()].name;
    let [own, here] = [law.histories[history.index()].family, family]
        .map(|family| law.families[family.index()].name.as_str());
    let mut says = format!("these are the bonds of `{here}`");
    loop {
        match &law.exprs[expr.index()].kind {
            ExprKind::History(_) => break,
            ExprKind::Def(def) => {
                let through = &law.defs[def.index()].name;
                says = format!("`{through}` reads `{name}`, and {says}");
                break;
            }
            kind => match operands(kind)
                .into_iter()
                .find(|part| read[part.index()].contains(&history))
            {
                Some(part) => expr = part,
                None => break,
            },
        }
    }
    let span = law.exprs[expr.index()].span;
    let message = format!("`{name}` is kept for the bonds of `{own}`");
    let help = match own {
        "horizon" => {
            format!("`history {name} : .. on bond[{here}]` keeps it for those of `{here}`")
        }
        _ => format!(
            "bonds of `{own}` are meant by `sum[{own}](..)`, `pair[{own}]`, `state[{own}]` and `break[{own}]`"
        ),
    };
    (
        span,
        Diagnostic::error(CODE, message).at(span, says).help(help),
    )
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    const KEPT: &str = "family near = horizon where x < delta/2 let c = K/(delta*ball(1)) \
        history w : number = 0 on bond[near] \"largest stretch\" update w = max(w, s)";

    #[test]
    fn a_history_is_read_on_its_own_bonds() {
        for (items, token) in [
            ("node n = sum(w*x)", "w"),
            ("bond b = 2*w node n = sum[near](b) + sum0(b*s)", "b"),
            ("bond b = 2*w bond d = b/x node n = max(d)", "d"),
            ("pair f = c*(s - w)", "w"),
            ("break when w > 1", "w"),
            (
                "history v : number = 0 on bond \"another\" update v = w + v",
                "w",
            ),
        ] {
            refuse(&format!("{KEPT} {items}"), "PD028", token);
        }
        refuse(
            "family near = horizon where x < delta/2 history w : number = 0 on bond \"largest stretch\" \
             update w = max(w, s) node n = sum[near](w)",
            "PD028",
            "w",
        );
        accept(&format!(
            "{KEPT} bond b = 2*w pair[near] f = c*(s - b) break[near] when w > 1 node n = sum(sum[near](b*w)'*s)"
        ));
    }
}
