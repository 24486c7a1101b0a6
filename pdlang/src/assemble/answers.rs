//! What a law answers, as polynomials: forces from energies, pair forces and force states, tangents, conditions of breaking,
//! histories, and what it names.

use std::collections::HashMap;

use crate::damping;
use crate::derive::{ForceState, force_state, tangent};
use crate::ir::{ExprId, FamilyId, Home, Reduction, Response, Shape};
use crate::linear::Keep;
use crate::lower::{Lowering, Reading};
use crate::poly::{Algebra, Atom, AtomId, Func, Poly, StateKind};
use crate::schedule::Responses;

pub(super) struct Answers {
    pub responses: Responses,
    pub vectors: Vec<Vec<AtomId>>,
    pub pairwise: bool,
}

pub(super) fn answers(lowering: &mut Lowering) -> Answers {
    let law = lowering.law;
    let mut split = Poly::zero();
    let mut r = Responses::default();
    let mut state = ForceState::new();
    let mut pairs = ForceState::new();
    let mut of_node = None;
    for response in &law.responses {
        match response {
            Response::Energy(e) => {
                let part = answer(lowering, *e, Reading::Split, Keep::Second).remove(0);
                split = lowering.algebra.add(&split, &part);
                let whole = answer(lowering, *e, Reading::Whole, Keep::Second).remove(0);
                let sum = lowering
                    .algebra
                    .add(&r.energy.take().unwrap_or_default(), &whole);
                r.energy = Some(sum);
            }
            Response::Pair(family, e) => {
                let parts = along_bond(lowering, *e);
                add_state(lowering.algebra, &mut pairs, *family, parts);
            }
            Response::State(family, e) => {
                let parts = along_bond(lowering, *e);
                add_state(lowering.algebra, &mut state, *family, parts);
            }
            Response::Force(e) => {
                of_node = Some(answer(lowering, *e, Reading::Whole, Keep::First));
            }
            Response::Rate(..) => {}
        }
    }
    if let Some(energy) = r.energy.take() {
        r.energy = Some(lowering.algebra.constants_on_bonds(&energy));
    }
    r.rates = damping::rates(lowering);
    for (key, parts) in force_state(lowering, &split) {
        let total = state
            .entry(key)
            .or_insert_with(|| vec![Poly::zero(); lowering.dim]);
        for (t, p) in total.iter_mut().zip(&parts) {
            *t = lowering.algebra.add(t, p);
        }
    }
    for parts in state.values_mut() {
        for t in parts.iter_mut() {
            let other = lowering.algebra.prime(t);
            *t = lowering.algebra.sub(t, &other);
        }
    }
    for (key, parts) in pairs {
        let total = state
            .entry(key)
            .or_insert_with(|| vec![Poly::zero(); lowering.dim]);
        for (t, p) in total.iter_mut().zip(&parts) {
            *t = lowering.algebra.add(t, p);
        }
    }
    let pairwise = !state.is_empty() && of_node.is_none() && pairwise(lowering.algebra, &state);
    let vectors = force(lowering, state, of_node, &mut r);
    other_answers(lowering, &mut r);
    Answers {
        responses: r,
        vectors,
        pairwise,
    }
}

fn answer(lowering: &mut Lowering, e: ExprId, reading: Reading, keep: Keep) -> Vec<Poly> {
    let parts = lowering.value(e, reading);
    lowering.small(e, parts, reading, keep)
}

/// A scalar state points along M.
fn along_bond(lowering: &mut Lowering, e: ExprId) -> Vec<Poly> {
    let mut value = lowering.value(e, Reading::Whole);
    if lowering.law.exprs[e.index()].shape != Shape::Vector {
        let inverse = lowering.algebra.poly(Atom::InverseY);
        let along = lowering.algebra.mul(&value[0], &inverse);
        let axes = 0..lowering.dim as u8;
        let part = |a| {
            let y = lowering.algebra.poly(Atom::Y(a));
            lowering.algebra.mul(&along, &y)
        };
        value = axes.map(part).collect();
    }
    let value = lowering.small(e, value, Reading::Whole, Keep::First);
    let gathered = value.iter().map(|p| lowering.algebra.gathered(p));
    gathered.collect()
}

fn add_state(algebra: &mut Algebra, state: &mut ForceState, family: FamilyId, parts: Vec<Poly>) {
    let total = state
        .entry((Reduction::Sum, family))
        .or_insert_with(|| vec![Poly::zero(); parts.len()]);
    for (t, p) in total.iter_mut().zip(&parts) {
        *t = algebra.add(t, p);
    }
}

fn force(
    lowering: &mut Lowering,
    state: ForceState,
    of_node: Option<Vec<Poly>>,
    r: &mut Responses,
) -> Vec<Vec<AtomId>> {
    let mut vectors = Vec::new();
    r.force = of_node.unwrap_or_default();
    for ((reduction, family), parts) in state {
        let sums: Vec<AtomId> = parts
            .into_iter()
            .map(|p| lowering.algebra.intern(Atom::Sum(reduction, family, p)))
            .collect();
        r.force.resize(lowering.dim, Poly::zero());
        for (f, s) in r.force.iter_mut().zip(&sums) {
            *f = lowering.algebra.add(f, &Poly::atom(*s));
        }
        vectors.push(sums);
    }
    for f in r.force.clone() {
        let df = tangent(lowering.algebra, lowering.dim, &f, &mut HashMap::new());
        r.tangent.push(df);
    }
    vectors
}

/// Force on i from j is along Y, or along xi, and knows nothing of either node but the bond.
fn pairwise(algebra: &mut Algebra, state: &ForceState) -> bool {
    let along_a_line = state.values().all(|parts| parts.len() == 1);
    let directions: [fn(u8) -> Atom; 3] = [Atom::Y, Atom::Xi, Atom::Eta];
    let count = if along_a_line { 3 } else { 2 };
    directions[..count].iter().any(|direction| {
        state.values().all(|parts| {
            parts.iter().enumerate().all(|(a, p)| {
                let along = algebra.intern(direction(a as u8));
                let plan = algebra.plan(p);
                let of_node = |a: &AtomId| algebra.nature(*a).sums;
                plan.iter().all(|t| {
                    let bond = t.own.is_none() && t.nbr.is_none();
                    bond && t.step.degree(along) == 1 && !t.step.0.iter().any(|(a, _)| of_node(a))
                })
            })
        })
    })
}

fn other_answers(lowering: &mut Lowering, r: &mut Responses) {
    let law = lowering.law;
    for b in &law.breaks {
        let when = answer(lowering, b.when, Reading::Whole, Keep::Sides).remove(0);
        match b.after {
            true => r.late_breaks.push((b.family, when)),
            false => r.breaks.push((b.family, when)),
        }
    }
    for (h, history) in law.histories.iter().enumerate() {
        let parts = lowering.stored(history.update, history.shape, Reading::Whole);
        let first = if history.home == Home::Bond {
            lowering.bond_history(h)
        } else {
            lowering.history_slots[h]
        };
        for (k, p) in parts.into_iter().enumerate() {
            let index = first + k as u32;
            match history.home {
                Home::Bond => r.bond_updates.push((history.family, index, p)),
                _ => r.node_updates.push((index, p)),
            }
        }
    }
    if let Some(e) = law.after_step {
        r.after_step = after_step(lowering, e);
    }
    for (d, def) in law.defs.iter().enumerate() {
        if def.home == Home::Node && !def.span.prelude {
            let parts = answer(lowering, def.expr, Reading::Whole, Keep::Shown);
            let named = lowering.name_parts(d, parts, |_, _| 1);
            r.named.push((def.name.clone(), named));
        }
    }
}

/// A node without intact bonds keeps its velocity.
fn after_step(lowering: &mut Lowering, e: ExprId) -> Vec<Poly> {
    let replaced = lowering.value(e, Reading::Whole);
    let (one, all) = (Poly::int(1), FamilyId(0));
    let bonded = lowering.reduce(Reduction::Sum, all, &one, Reading::Whole);
    let algebra = &mut *lowering.algebra;
    let some = algebra.func(Func::Lt, vec![Poly::zero(), bonded]);
    let velocity = |a: usize| Atom::State(StateKind::Velocity, a as u32);
    let parts = replaced.into_iter().enumerate();
    parts
        .map(|(a, p)| {
            let kept = algebra.poly(velocity(a));
            algebra.func(Func::Select, vec![some.clone(), p, kept])
        })
        .collect()
}
