//! The plan of sweeps: what is needed is there earlier, sums keep their bonds, everything is written once.

use std::collections::{BTreeMap, BTreeSet};

use super::Report;
use crate::ir::Reduction;
use crate::poly::{Algebra, Atom, AtomId, Poly};
use crate::schedule::{Key, Schedule};
use crate::spec::{SlotKind, Stage};

pub(super) fn check(algebra: &mut Algebra, plan: &Schedule) -> Vec<String> {
    let mut report = Report::default();
    let mut sums: BTreeMap<AtomId, Vec<Key>> = BTreeMap::new();
    let weights: BTreeSet<u32> = plan
        .weights()
        .filter_map(|(w, f)| plan.weight(w, f))
        .collect();
    let mut weighed: BTreeMap<u32, Key> = BTreeMap::new();
    for (key, draft) in &plan.drafts {
        report.at(format!("sweep {key:?}"));
        for sum in &draft.sums {
            match (algebra.atom(*sum), key.1) {
                (Atom::Sum(r, f, _), Some((family, over))) if *f == family && r.bonds() == over => {
                }
                (atom, _) => report.add(format!("sums over other bonds: {atom:?}")),
            }
            let before = sums.entry(*sum).or_default();
            if before.iter().any(|k| shared(k.0.0, key.0.0)) {
                report.add("a sum is formed twice".into());
            }
            before.push(*key);
        }
        let intact = matches!(key.1, Some((_, Reduction::Sum)));
        let may_break = intact && matches!(key.0.0, Stage::Step | Stage::Update);
        if !may_break && !draft.kills.is_empty() {
            report.add("breaks bonds that it may not break".into());
        }
        // Memory changes on intact bonds in an update; weights are written once, on all bonds, before anything moves.
        for (number, _) in &draft.updates {
            let may_change = match weights.contains(number) {
                false => intact && key.0.0 == Stage::Update,
                true => !intact && key.0.0 == Stage::Reference,
            };
            if !may_change {
                report.add("changes memory".into());
            }
            if weights.contains(number) && weighed.insert(*number, *key).is_some() {
                report.add(format!("weight {number} is written twice"));
            }
        }
    }
    let mut written: BTreeMap<u32, Key> = BTreeMap::new();
    for (key, draft) in &plan.drafts {
        report.at(format!("sweep {key:?}"));
        for p in &draft.writes {
            let Some(q) = plan.find(p, key.0.0) else {
                report.add("writes what nobody asked for".into());
                continue;
            };
            if q.time != key.0 {
                report.add(format!("writes what is due at {:?}", q.time));
            }
            let kind = plan.slots.get(q.slot as usize).map(|s| s.kind);
            if kind != Some(SlotKind::Computed(key.0.0)) {
                report.add(format!("slot {} is {kind:?}", q.slot));
            }
            if written.insert(q.slot, *key).is_some() {
                report.add(format!("slot {} is written twice", q.slot));
            }
        }
    }
    let known = Known {
        plan,
        sums: &sums,
        written: &written,
        weighed: &weighed,
    };
    for (key, draft) in &plan.drafts {
        report.at(format!("sweep {key:?}"));
        let mut read = draft.kills.clone();
        read.extend(draft.updates.iter().map(|(_, p)| p.clone()));
        for sum in &draft.sums {
            if let Atom::Sum(r, _, body) = algebra.atom(*sum).clone() {
                read.push(algebra.weighted(r, &body));
            }
        }
        for p in &read {
            known.reads(&mut report, algebra, p, key);
        }
        for p in &draft.writes {
            known.needs(&mut report, algebra, p, key);
        }
    }
    report.found
}

/// Whether what is known at one stage is known at the other.
fn shared(a: Stage, b: Stage) -> bool {
    a == b || a.min(b) <= Stage::Step
}

/// What is formed and written where.
struct Known<'a> {
    plan: &'a Schedule,
    sums: &'a BTreeMap<AtomId, Vec<Key>>,
    written: &'a BTreeMap<u32, Key>,
    weighed: &'a BTreeMap<u32, Key>,
}

impl Known<'_> {
    /// In a slot that an earlier sweep wrote.
    fn stored(&self, p: &Poly, key: &Key) -> bool {
        let Some(q) = self.plan.find(p, key.0.0) else {
            return false;
        };
        let before = |k: &Key| k < key && shared(k.0.0, key.0.0);
        self.written.get(&q.slot).is_some_and(before)
    }

    /// Node quantities that a bond reads are stored.
    fn reads(&self, report: &mut Report, algebra: &mut Algebra, p: &Poly, key: &Key) {
        for term in algebra.plan(p) {
            for q in [&term.own, &term.nbr].into_iter().flatten() {
                if !self.stored(q, key) {
                    report.add(format!("reads what is not there: {q:?}"));
                }
            }
            for (id, _) in &term.step.0 {
                let inner = match algebra.atom(*id).clone() {
                    Atom::Factor(k) | Atom::FactorBack(k) => {
                        let number = key.1.and_then(|(family, _)| self.plan.weight(k, family));
                        let at = number.and_then(|n| self.weighed.get(&n));
                        if at.is_none_or(|at| at >= key) {
                            report.add(format!("reads weight {k} before it is written"));
                        }
                        continue;
                    }
                    Atom::Named(_, p) => vec![p],
                    Atom::Func(_, args) => args,
                    _ => continue,
                };
                for p in &inner {
                    self.reads(report, algebra, p, key);
                }
            }
        }
    }

    /// The sums of an epilogue are those of its own sweep, or they, or what is made of them, are stored.
    fn needs(&self, report: &mut Report, algebra: &Algebra, p: &Poly, key: &Key) {
        for (id, _) in p.0.iter().flat_map(|(m, _)| &m.0) {
            if self.stored(&Poly::atom(*id), key) {
                continue;
            }
            match algebra.atom(*id) {
                Atom::Sum(..) if self.sums.get(id).is_some_and(|keys| keys.contains(key)) => {}
                Atom::Sum(..) => {
                    report.add(format!(
                        "needs a sum that is not there: {:?}",
                        algebra.atom(*id)
                    ));
                }
                Atom::Named(_, inner) => self.needs(report, algebra, inner, key),
                Atom::Func(_, args) => {
                    for p in args {
                        self.needs(report, algebra, p, key);
                    }
                }
                _ => {}
            }
        }
    }
}
