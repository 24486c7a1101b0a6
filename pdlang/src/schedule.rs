//! When everything is computed: polynomials -> sweeps over bonds.
//!
//! Contract. Input: the responses of a law as polynomials. Output: node slots, and sweeps in the order in
//! which they run. A node quantity is stored once, by the first sweep after which all its reductions are
//! known. A reduction runs at the earliest stage that its body allows, but nothing is brought forward that
//! no force, rate or break asks for: what only the energy needs waits for the energy. Reductions of one
//! time, family and kind share a sweep.

use std::collections::{BTreeMap, BTreeSet};

use crate::damping::Rate;
use crate::ir::{FamilyId, Reduction};
use crate::poly::{self, Algebra, Atom, AtomId, Poly, StateKind};
use crate::spec::{SlotKind, SlotSpec, Stage, Stepped};

/// Stage, and position within it; level 0 is before its first sweep.
pub type Time = (Stage, u32);

/// What the law answers, ready to be scheduled.
#[derive(Default)]
pub struct Responses {
    /// Components of the force density.
    pub force: Vec<Poly>,
    pub rates: Vec<crate::damping::Rate>,
    /// Components of what replaces the velocity after the step.
    pub after_step: Vec<Poly>,
    /// Tested before the force, and once a step is accepted.
    pub breaks: Vec<(FamilyId, Poly)>,
    pub late_breaks: Vec<(FamilyId, Poly)>,
    pub energy: Option<Poly>,
    pub tangent: Vec<Poly>,
    /// Named node quantities, component by component.
    pub named: Vec<(String, Vec<Poly>)>,
    /// (family, scalar bond history, next value).
    pub bond_updates: Vec<(FamilyId, u32, Poly)>,
    /// (state slot, next value).
    pub node_updates: Vec<(u32, Poly)>,
    /// Correction factors of bonds, each after those that it reads.
    pub weights: Vec<Poly>,
    /// Parts of the body that fields live on: 1 where they do, 0 elsewhere.
    pub parts: Vec<Poly>,
}

/// A sum over bonds together with others of its time, or a pass over nodes (no family).
#[derive(Clone, Debug, Default)]
pub struct Draft {
    pub sums: Vec<AtomId>,
    /// Stored quantities that this sweep's epilogue writes.
    pub writes: Vec<Poly>,
    /// Conditions under which bonds break, tested first.
    pub kills: Vec<Poly>,
    pub updates: Vec<(u32, Poly)>,
}

/// Where a sweep stands in the order; no family: nodes only.
pub type Key = (Time, Option<(FamilyId, Reduction)>);

#[derive(Clone)]
pub struct Quantity {
    pub time: Time,
    pub slot: u32,
}

#[derive(Clone)]
pub struct Schedule {
    pub slots: Vec<SlotSpec>,
    pub drafts: BTreeMap<Key, Draft>,
    /// State slots of the fields at half steps, and when all of their rates are known: what reads them comes later.
    half: BTreeSet<u32>,
    half_known: Time,
    quantities: BTreeMap<(Poly, Stage), Quantity>,
    sums: BTreeMap<(AtomId, Stage), Time>,
    state: BTreeMap<AtomId, u32>,
    /// Values of the weights, and where and when each is there on the bonds of a family.
    weights: Vec<Poly>,
    weighed: BTreeMap<(u32, FamilyId), (u32, Time)>,
    /// Scalar histories: a weight is numbered behind them.
    histories: u32,
    dim: usize,
}

/// Values of a stage after the forces are not there for another such stage.
fn class(stage: Stage) -> Stage {
    stage.max(Stage::Step)
}

impl Schedule {
    /// `state_slots` are the names of field and node-history components, `histories` is the number of scalar
    /// histories.
    pub fn new(dim: usize, state_slots: Vec<String>, histories: u32) -> Schedule {
        let slots = state_slots
            .into_iter()
            .map(|name| SlotSpec {
                name,
                kind: SlotKind::State,
                part: None,
            })
            .collect();
        Schedule {
            slots,
            drafts: BTreeMap::new(),
            half: BTreeSet::new(),
            half_known: (Stage::Reference, 0),
            quantities: BTreeMap::new(),
            sums: BTreeMap::new(),
            state: BTreeMap::new(),
            weights: Vec::new(),
            weighed: BTreeMap::new(),
            histories,
            dim,
        }
    }

    pub fn build(&mut self, algebra: &mut Algebra, r: &Responses) {
        let step = Stage::Step;
        self.weights.clone_from(&r.weights);
        let half = |r: &&Rate| r.stepped == Stepped::Half;
        for rate in r.rates.iter().filter(half) {
            let time = self.store_rate(algebra, rate);
            self.half_known = self.half_known.max(time);
        }
        self.half = r.rates.iter().filter(half).map(|r| r.slot).collect();
        for p in &r.force {
            self.store(algebra, p, step);
        }
        for rate in r.rates.iter().filter(|r| !half(r)) {
            self.store_rate(algebra, rate);
        }
        let breaks: Vec<Time> = r
            .breaks
            .iter()
            .map(|(family, p)| self.bond_time(algebra, p, *family, step))
            .collect();
        if let Some(p) = &r.energy {
            self.store(algebra, p, Stage::Energy);
        }
        for p in r.named.iter().flat_map(|(_, ps)| ps) {
            self.store(algebra, p, Stage::Energy);
        }
        for p in &r.tangent {
            self.store(algebra, p, Stage::Tangent);
        }
        let updates = Stage::Update;
        let mut bond_updates = Vec::new();
        for (family, history, p) in &r.bond_updates {
            let time = self.bond_time(algebra, p, *family, updates);
            bond_updates.push((next_level(time, updates), *family, *history, p));
        }
        for (_, p) in &r.node_updates {
            self.store(algebra, p, updates);
        }
        for p in &r.after_step {
            self.store(algebra, p, updates);
        }
        for (family, p) in &r.late_breaks {
            self.bond_time(algebra, p, *family, updates);
        }
        for (id, time) in self
            .sums
            .iter()
            .map(|((id, _), t)| (*id, *t))
            .collect::<Vec<_>>()
        {
            let Atom::Sum(reduction, family, _) = algebra.atom(id) else {
                continue;
            };
            self.drafts
                .entry((time, Some((*family, reduction.bonds()))))
                .or_default()
                .sums
                .push(id);
        }
        for ((family, p), time) in r.breaks.iter().zip(breaks) {
            self.place_break(*family, p, time);
        }
        for (time, family, history, p) in bond_updates {
            let key = (time, Some((family, Reduction::Sum)));
            self.drafts
                .entry(key)
                .or_default()
                .updates
                .push((history, p.clone()));
        }
        self.place_quantities(algebra);
        self.place_late_breaks(&r.late_breaks);
        for (p, level) in r.parts.iter().zip(1..) {
            self.place_part(algebra, p, level);
        }
    }

    /// A pass of its own, once the coefficients are there. Nobody reads what it writes but who lays out storage.
    fn place_part(&mut self, algebra: &Algebra, p: &Poly, level: u32) {
        let time = (Stage::Part, level);
        let slot = self.new_slot(algebra, p, time.0);
        let quantity = Quantity { time, slot };
        self.quantities.insert((p.clone(), Stage::Part), quantity);
        self.drafts
            .entry((time, None))
            .or_default()
            .writes
            .push(p.clone());
    }

    fn store_rate(&mut self, algebra: &mut Algebra, rate: &Rate) -> Time {
        let time = self.store(algebra, &rate.drive, Stage::Step);
        match rate.damping.is_zero() || rate.damping_field(algebra).is_some() {
            true => time,
            false => time.max(self.store(algebra, &rate.damping, Stage::Step)),
        }
    }

    /// When the value of a state atom is there.
    fn state_time(&self, atom: &Atom, context: Stage) -> Time {
        match atom {
            Atom::State(StateKind::Position, _) => (Stage::Reference, 0),
            _ => self.half_time(atom, context).max((class(context), 0)),
        }
    }

    /// Fields at half steps follow their rates; what else a sweep reads at the ends of a bond is always there.
    fn half_time(&self, atom: &Atom, context: Stage) -> Time {
        match atom {
            Atom::State(StateKind::Slot, k) if self.half.contains(k) && context <= Stage::Step => {
                next_level(self.half_known, Stage::Step)
            }
            _ => (Stage::Reference, 0),
        }
    }

    /// Sweeps of their own when everything else of the step is done: all of it saw the bonds intact.
    fn place_late_breaks(&mut self, breaks: &[(FamilyId, Poly)]) {
        let last = self.drafts.keys().map(|(time, _)| *time).max();
        let time = next_level(last.unwrap_or((Stage::Update, 0)), Stage::Update);
        for (family, p) in breaks {
            let key = (time, Some((*family, Reduction::Sum)));
            self.drafts.entry(key).or_default().kills.push(p.clone());
        }
    }

    /// The first sweep of the step over the family's intact bonds, or one of its own before it.
    fn place_break(&mut self, family: FamilyId, p: &Poly, ready: Time) {
        let earliest = next_level(ready, Stage::Step);
        let over = Some((family, Reduction::Sum));
        let first = self
            .drafts
            .keys()
            .find(|((s, _), _)| *s == Stage::Step)
            .copied();
        let key = match first {
            Some((time, f)) if f == over && time >= earliest => (time, over),
            _ => (earliest, over),
        };
        self.drafts.entry(key).or_default().kills.push(p.clone());
    }

    /// Every stored quantity goes to the last sweep that it needs; sums of other sweeps are then stored too.
    fn place_quantities(&mut self, algebra: &mut Algebra) {
        let mut queue: Vec<(Poly, Stage)> = self.quantities.keys().cloned().collect();
        while let Some((p, class)) = queue.pop() {
            let time = self.quantities[&(p.clone(), class)].time;
            let mut needed = BTreeSet::new();
            closure(algebra, &p, &mut needed);
            let home = self.last_sweep(algebra, &needed, class, time);
            for sum in needed {
                let elsewhere = self.sweep_of(algebra, sum, class) != Some(home);
                let key = (Poly::atom(sum), class);
                if elsewhere && self.find(&key.0, class).is_none() {
                    let time = self.sum_time(algebra, sum, class);
                    let slot = self.new_slot(algebra, &key.0, time.0);
                    let key = (key.0, self.class_of(time, class));
                    self.quantities.insert(key.clone(), Quantity { time, slot });
                    queue.push(key);
                }
            }
            self.drafts.entry(home).or_default().writes.push(p);
        }
        for draft in self.drafts.values_mut() {
            draft.writes.sort();
            draft.writes.dedup();
        }
    }

    fn last_sweep(
        &self,
        algebra: &Algebra,
        sums: &BTreeSet<AtomId>,
        class: Stage,
        time: Time,
    ) -> Key {
        let keys = sums
            .iter()
            .filter_map(|s| self.sweep_of(algebra, *s, class));
        match keys.max() {
            Some(key) if key.0 == time => key,
            _ => (time, None),
        }
    }

    fn sweep_of(&self, algebra: &Algebra, sum: AtomId, class: Stage) -> Option<Key> {
        let Atom::Sum(reduction, family, _) = algebra.atom(sum) else {
            return None;
        };
        let time = self
            .sums
            .get(&(sum, Stage::Step))
            .or_else(|| self.sums.get(&(sum, class)))?;
        Some((*time, Some((*family, reduction.bonds()))))
    }

    fn class_of(&self, time: Time, context: Stage) -> Stage {
        if time.0 <= Stage::Step {
            Stage::Step
        } else {
            class(context)
        }
    }

    /// The stored quantity as a sweep of the given stage sees it.
    pub fn find(&self, p: &Poly, context: Stage) -> Option<&Quantity> {
        if context == Stage::Part {
            return self.quantities.get(&(p.clone(), context));
        }
        let main = self.quantities.get(&(p.clone(), Stage::Step));
        main.or_else(|| self.quantities.get(&(p.clone(), class(context))))
    }

    /// Registers a node polynomial that must be in a slot, and says when it is there.
    pub fn store(&mut self, algebra: &mut Algebra, p: &Poly, context: Stage) -> Time {
        if let Some(q) = self.find(p, context) {
            return q.time;
        }
        let content = match p.as_atom().map(|a| algebra.atom(a).clone()) {
            Some(Atom::Named(_, inner)) => inner,
            _ => p.clone(),
        };
        let mut time = self.node_time(algebra, &content, context);
        if context == Stage::Update && time.0 < Stage::Update {
            // A next value must not be written before the step is accepted.
            let context = Stage::Update;
            let slot = self.new_slot(algebra, p, context);
            time = (context, 0);
            self.quantities
                .insert((p.clone(), context), Quantity { time, slot });
            return time;
        }
        let slot = self.new_slot(algebra, p, time.0);
        let key = (p.clone(), self.class_of(time, context));
        self.quantities.insert(key, Quantity { time, slot });
        time
    }

    fn new_slot(&mut self, algebra: &Algebra, p: &Poly, stage: Stage) -> u32 {
        let name = match p.as_atom().map(|a| algebra.atom(a)) {
            Some(Atom::Named(name, _)) => name.clone(),
            _ => format!("q{}", self.slots.len()),
        };
        self.slots.push(SlotSpec {
            name,
            kind: SlotKind::Computed(stage),
            part: None,
        });
        self.slots.len() as u32 - 1
    }

    pub fn rename(&mut self, slot: u32, name: String) {
        self.slots[slot as usize].name = name;
    }

    fn node_time(&mut self, algebra: &mut Algebra, p: &Poly, context: Stage) -> Time {
        let mut time = (Stage::Reference, 0);
        for id in atoms(p) {
            let t = match algebra.atom(id).clone() {
                Atom::Sum(..) => self.sum_time(algebra, id, context),
                state @ Atom::State(..) => self.state_time(&state, context),
                Atom::Named(_, inner) if algebra.nature(id).sums => self
                    .store(algebra, &Poly::atom(id), context)
                    .max(self.node_time(algebra, &inner, context)),
                Atom::Named(_, inner) => self.node_time(algebra, &inner, context),
                Atom::Func(_, args) => self.latest(algebra, &args, context),
                _ => (Stage::Reference, 0),
            };
            time = time.max(t);
        }
        time
    }

    fn latest(&mut self, algebra: &mut Algebra, ps: &[Poly], context: Stage) -> Time {
        let times: Vec<Time> = ps
            .iter()
            .map(|p| self.node_time(algebra, p, context))
            .collect();
        times.into_iter().max().unwrap_or((Stage::Reference, 0))
    }

    fn sum_time(&mut self, algebra: &mut Algebra, id: AtomId, context: Stage) -> Time {
        for c in [Stage::Step, class(context)] {
            if let Some(t) = self.sums.get(&(id, c)) {
                return *t;
            }
        }
        let Atom::Sum(reduction, family, body) = algebra.atom(id).clone() else {
            return (Stage::Reference, 0);
        };
        let stage = match algebra.nature(id).rate {
            poly::Rate::Reference => Stage::Reference,
            poly::Rate::Family => Stage::Family,
            poly::Rate::Step => class(context),
            poly::Rate::Tangent => Stage::Tangent,
        };
        let weighted = algebra.weighted(reduction, &body);
        let ready = self.bond_time(algebra, &weighted, family, context);
        let time = next_level(ready, stage.max(ready.0));
        self.sums.insert((id, self.class_of(time, context)), time);
        time
    }

    /// Registers the node quantities and weights that a bond polynomial reads on the bonds of a family, and says
    /// when they are all there.
    fn bond_time(
        &mut self,
        algebra: &mut Algebra,
        p: &Poly,
        family: FamilyId,
        context: Stage,
    ) -> Time {
        let mut time = (Stage::Reference, 0);
        for term in algebra.plan(p) {
            for q in [&term.own, &term.nbr].into_iter().flatten() {
                time = time.max(self.store(algebra, q, context));
            }
            for (id, _) in &term.step.0 {
                let inner = match algebra.atom(*id).clone() {
                    Atom::Factor(k) | Atom::FactorBack(k) => {
                        time = time.max(self.weigh(algebra, k, family));
                        continue;
                    }
                    Atom::Named(_, p) => vec![p],
                    Atom::Func(_, args) => args,
                    state @ Atom::State(..) => {
                        time = time.max(self.half_time(&state, context));
                        continue;
                    }
                    Atom::Prime(a) => match algebra.atom(a).clone() {
                        state @ Atom::State(..) => {
                            time = time.max(self.half_time(&state, context));
                            continue;
                        }
                        Atom::Named(_, p) => vec![algebra.prime(&p)],
                        Atom::Func(_, args) => args.iter().map(|p| algebra.prime(p)).collect(),
                        _ => continue,
                    },
                    _ => continue,
                };
                for p in &inner {
                    time = time.max(self.bond_time(algebra, p, family, context));
                }
            }
        }
        time
    }

    /// Registers a weight on the bonds of a family, and says which sweep writes it.
    fn weigh(&mut self, algebra: &mut Algebra, weight: u32, family: FamilyId) -> Time {
        if let Some((_, time)) = self.weighed.get(&(weight, family)) {
            return *time;
        }
        let value = self.weights[weight as usize].clone();
        let ready = self.bond_time(algebra, &value, family, Stage::Reference);
        let time = next_level(ready, Stage::Reference);
        let number = self.histories + self.weighed.len() as u32;
        self.weighed.insert((weight, family), (number, time));
        let draft = self.drafts.entry((time, Some((family, Reduction::Sum0))));
        draft.or_default().updates.push((number, value));
        time
    }

    /// Number of a weight among the histories and weights of bonds, on the bonds of a family.
    pub fn weight(&self, weight: u32, family: FamilyId) -> Option<u32> {
        Some(self.weighed.get(&(weight, family))?.0)
    }

    /// Weight and family in the order of their numbers.
    pub fn weights(&self) -> impl Iterator<Item = (u32, FamilyId)> {
        let mut list: Vec<_> = self
            .weighed
            .iter()
            .map(|(key, (n, _))| (*n, *key))
            .collect();
        list.sort();
        list.into_iter().map(|(_, key)| key)
    }

    /// Slot of a state atom (field, history, velocity, position) or of an increment component.
    pub fn state_slot(&mut self, algebra: &mut Algebra, id: AtomId) -> u32 {
        let (name, kind) = match algebra.atom(id) {
            Atom::State(StateKind::Slot, k) => return *k,
            Atom::State(StateKind::Velocity, a) => ("v", SlotKind::Velocity(*a as u8)),
            Atom::State(StateKind::Position, a) => ("X", SlotKind::Position(*a as u8)),
            Atom::State(StateKind::TimeStep, _) => ("dt", SlotKind::TimeStep),
            Atom::DEta(a) => ("du", SlotKind::Increment(*a)),
            _ => return 0,
        };
        if let Some(slot) = self.state.get(&id) {
            return *slot;
        }
        self.slots.push(SlotSpec {
            name: name.into(),
            kind,
            part: None,
        });
        let slot = self.slots.len() as u32 - 1;
        self.state.insert(id, slot);
        slot
    }

    pub fn dim(&self) -> usize {
        self.dim
    }
}

fn next_level(ready: Time, stage: Stage) -> Time {
    if ready.0 == stage {
        (stage, ready.1 + 1)
    } else {
        (stage, 1)
    }
}

fn atoms(p: &Poly) -> BTreeSet<AtomId> {
    p.0.iter()
        .flat_map(|(m, _)| m.0.iter().map(|(a, _)| *a))
        .collect()
}

/// Reductions that must be known before a node polynomial can be formed.
pub fn closure(algebra: &Algebra, p: &Poly, out: &mut BTreeSet<AtomId>) {
    for id in atoms(p) {
        match algebra.atom(id) {
            Atom::Sum(..) => {
                out.insert(id);
            }
            Atom::Named(_, inner) => closure(algebra, inner, out),
            Atom::Func(_, args) => args.iter().for_each(|p| closure(algebra, p, out)),
            _ => {}
        }
    }
}
