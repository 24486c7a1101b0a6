//! One scheduled sweep -> its tapes.
//!
//! Contract. The prologue tape reads node slots and constants and hands values on; the bond tape starts
//! with the break test, then adds to accumulators; the epilogue forms the node quantities. A vector sum
//! along Y, xi or eta is recognised: the factor of each is formed once for all components. What clouds keep of the geometry is
//! chosen afterwards, for all sweeps of a law ([`crate::streams`]).

mod nodes;
mod sums;

use std::collections::BTreeMap;

use crate::constants::Constants;
use crate::ir::{FamilyId, Home, Reduction};
use crate::plan::Term;
use crate::poly::{Algebra, Atom, AtomId, Func, Monomial, Poly};
use crate::ratio::Ratio;
use crate::schedule::{Draft, Key, Schedule};
use crate::spec::{SlotKind, Stage, SweepSpec};
use crate::tape::{Builder, Op, Product, Tape, horner};

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Factor {
    Own(Poly),
    Nbr(Poly),
    InverseLength,
    Length,
    Atom(AtomId),
    Inverse(AtomId),
    Constant(Poly),
}

/// The components of Y, xi or eta.
type Direction = fn(u8) -> Atom;

pub struct SweepWriter<'a> {
    algebra: &'a mut Algebra,
    schedule: &'a mut Schedule,
    constants: &'a mut Constants,
    stage: Stage,
    family: FamilyId,
    own: Vec<u32>,
    nbr: Vec<u32>,
    history: Vec<u32>,
    geometry: Builder,
    /// What the outputs of the geometry tape are.
    values: Vec<Poly>,
    pre: Builder,
    bond: Builder,
    post: Builder,
    accumulators: BTreeMap<AtomId, u32>,
    /// Quantities that this sweep stores: their slots are old while it runs.
    writes: Vec<AtomId>,
}

fn position(list: &mut Vec<u32>, v: u32) -> u32 {
    if let Some(k) = list.iter().position(|o| *o == v) {
        return k as u32;
    }
    list.push(v);
    list.len() as u32 - 1
}

/// Writes the tapes of one draft, and what its values of geometry are. `vectors` lists sums that are the components of one
/// vector.
pub fn write(
    algebra: &mut Algebra,
    schedule: &mut Schedule,
    constants: &mut Constants,
    (key, draft): (&Key, &Draft),
    vectors: &[Vec<AtomId>],
) -> (SweepSpec, Vec<Poly>) {
    let ((stage, _), over) = *key;
    let mut w = SweepWriter {
        algebra,
        schedule,
        constants,
        stage,
        family: over.map_or(FamilyId(0), |(family, _)| family),
        own: Vec::new(),
        nbr: Vec::new(),
        history: Vec::new(),
        geometry: Builder::default(),
        values: Vec::new(),
        pre: Builder::default(),
        bond: Builder::default(),
        post: Builder::default(),
        accumulators: BTreeMap::new(),
        writes: draft.writes.iter().filter_map(Poly::as_atom).collect(),
    };
    for kill in &draft.kills {
        let r = w.condition(kill);
        w.bond.effect(Op::Kill(r));
    }
    w.sums(&draft.sums, vectors);
    for (history, next) in &draft.updates {
        let r = w.bond_value(next);
        let k = position(&mut w.history, *history);
        w.bond.effect(Op::PutHistory(k, r));
    }
    let mut out = Vec::new();
    for q in &draft.writes {
        let slot = w.schedule.find(q, stage).map_or(0, |q| q.slot);
        let r = w.epilogue_of(q);
        out.push(slot);
        w.post.tape.outs.push(r);
    }
    w.formed_first();
    let spec = SweepSpec {
        name: name(w.schedule, &out, draft),
        stage,
        family: w.family.0,
        reference: over.is_some_and(|(_, r)| r == Reduction::Sum0),
        kills: !draft.kills.is_empty(),
        single: false,
        own: w.own,
        nbr: w.nbr,
        out,
        history: w.history,
        geometry: w.geometry.tape,
        streams: Tape::default(),
        from_streams: Tape::default(),
        pre: w.pre.tape,
        bond: w.bond.tape,
        accumulators: w.accumulators.len() as u32,
        post: w.post.tape,
    };
    (spec, w.values)
}

fn name(schedule: &Schedule, out: &[u32], draft: &Draft) -> String {
    let mut names: Vec<&str> = Vec::new();
    for slot in out {
        let full = schedule.slots[*slot as usize].name.as_str();
        let stem = full
            .rsplit_once('_')
            .filter(|(_, c)| c.chars().all(|c| "xyz".contains(c)));
        let stem = stem.map_or(full, |(s, _)| s);
        let anonymous = stem.starts_with('q') && stem[1..].chars().all(|c| c.is_ascii_digit());
        if !anonymous && !names.contains(&stem) {
            names.push(stem);
        }
    }
    match (
        names.is_empty(),
        draft.kills.is_empty(),
        draft.updates.is_empty(),
    ) {
        (false, _, _) => names.join(" "),
        (true, false, _) => "break".into(),
        (true, _, false) => "update".into(),
        _ => "sums".into(),
    }
}

impl SweepWriter<'_> {
    /// Value of a bond polynomial.
    fn bond_value(&mut self, p: &Poly) -> u32 {
        let mut sum: Option<u32> = None;
        for (geo, terms) in by_geometry(self.algebra.plan(p)) {
            let inner = self.inner(&terms);
            sum = Some(match (geo, sum) {
                (None, None) => inner,
                (None, Some(s)) => self.bond.op(Op::Add(s, inner)),
                (Some(g), None) => {
                    let g = self.geometry_value(Some(&g));
                    self.bond.op(Op::Mul(g, inner))
                }
                (Some(g), Some(s)) => {
                    let g = self.geometry_value(Some(&g));
                    self.bond.op(Op::Fma(g, inner, s))
                }
            });
        }
        sum.unwrap_or_else(|| self.bond.lit(0.0))
    }

    /// A condition; `s > constant` becomes a comparison of squares, which needs no root.
    fn condition(&mut self, p: &Poly) -> u32 {
        if let Some(limit) = self.stretch_limit(p) {
            let stretched = self.algebra.add(&Poly::int(1), &limit);
            let longest = vec![stretched, Poly::zero()];
            let longest = self.algebra.func(Func::Max, longest);
            let longest = self.algebra.mul(&longest, &longest);
            let x = self.algebra.intern(Atom::X);
            let longest = self.algebra.mul(&longest, &Poly::power(x, 2));
            let geo = self.geometry_value(Some(&longest));
            let yy = self.squared_length();
            return self.bond.op(Op::Lt(geo, yy));
        }
        if let Some([left, right]) = self.without_lengths_below(p) {
            let left = self.geometry_value(Some(&left));
            let right = self.bond_value(&right);
            return self.bond.op(Op::Lt(left, right));
        }
        self.bond_value(p)
    }

    /// C x^n and p, if the condition is C < p x^-n with a constant C and no length of the deformed bond.
    fn without_lengths_below(&mut self, p: &Poly) -> Option<[Poly; 2]> {
        let Atom::Func(Func::Lt, args) = self.algebra.atom(p.as_atom()?).clone() else {
            return None;
        };
        let (x, e) = (
            self.algebra.intern(Atom::X),
            self.algebra.intern(Atom::Extension),
        );
        let terms = || args[1].0.iter().map(|(m, _)| m);
        let constant = self.algebra.nature_of(&args[0]).home == Home::Constant;
        let n = terms().map(|m| -m.degree(x)).max().filter(|n| *n > 0)?;
        if !constant || terms().any(|m| m.degree(e) != 0) {
            return None;
        }
        let lengths = Poly::power(x, n);
        Some([0, 1].map(|k| self.algebra.mul(&args[k], &lengths)))
    }

    /// C if the condition is C < e/x with a constant C.
    fn stretch_limit(&mut self, p: &Poly) -> Option<Poly> {
        let Atom::Func(Func::Lt, args) = self.algebra.atom(p.as_atom()?).clone() else {
            return None;
        };
        let (x, e) = (
            self.algebra.intern(Atom::X),
            self.algebra.intern(Atom::Extension),
        );
        let stretch = Poly(vec![(
            Monomial(vec![(e, 1)]).mul(&Monomial(vec![(x, -1)])),
            Ratio::ONE,
        )]);
        let constant = self.algebra.nature_of(&args[0]).home == Home::Constant;
        (constant && args[1] == stretch).then(|| args[0].clone())
    }

    fn inner(&mut self, terms: &[Term]) -> u32 {
        let products: Vec<Product<Factor>> = terms.iter().map(|t| self.product(t)).collect();
        let mut bond = std::mem::take(&mut self.bond);
        let r = horner(&mut bond, &products, &mut |b, f| {
            std::mem::swap(b, &mut self.bond);
            let r = self.bond_factor(f);
            std::mem::swap(b, &mut self.bond);
            r
        });
        self.bond = bond;
        r
    }

    fn product(&mut self, t: &Term) -> Product<Factor> {
        let length = self.algebra.intern(Atom::Length);
        let mut factors = BTreeMap::new();
        if let Some(q) = &t.own {
            factors.insert(Factor::Own(q.clone()), 1);
        }
        if let Some(q) = &t.nbr {
            factors.insert(Factor::Nbr(q.clone()), 1);
        }
        for (a, n) in &t.step.0 {
            let f = match (*a == length, *n > 0) {
                (true, true) => Factor::Length,
                (true, false) => Factor::InverseLength,
                (false, true) => Factor::Atom(*a),
                (false, false) => Factor::Inverse(*a),
            };
            factors.insert(f, n.unsigned_abs());
        }
        Product {
            coefficient: t.coefficient,
            factors,
        }
    }

    fn bond_factor(&mut self, f: &Factor) -> u32 {
        match f {
            Factor::Own(q) => match self.schedule.find(q, self.stage).map(|q| q.slot) {
                Some(slot) => self.read_own(slot),
                None => self.bond.lit(0.0),
            },
            Factor::Nbr(q) => match self.schedule.find(q, self.stage).map(|q| q.slot) {
                Some(slot) => self.read_nbr(slot),
                None => self.bond.lit(0.0),
            },
            Factor::InverseLength => self.inverse_length(),
            Factor::Length => {
                let (yy, iy) = (self.squared_length(), self.inverse_length());
                self.bond.op(Op::Mul(yy, iy))
            }
            Factor::Atom(a) => self.bond_atom(*a),
            Factor::Inverse(a) => {
                let r = self.bond_atom(*a);
                self.bond.recip(r, false)
            }
            Factor::Constant(p) => self.node_in_bond(p),
        }
    }

    fn read_own(&mut self, slot: u32) -> u32 {
        let k = position(&mut self.own, slot);
        let r = self.pre.op(Op::Own(k));
        let k = self.pre.out(r);
        self.bond.op(Op::Pre(k))
    }

    /// What sweeps form stands at the head of what is read at the other end: side by side, whoever stores it.
    fn formed_first(&mut self) {
        let state = |slot: &u32| {
            let kind = self.schedule.slots[*slot as usize].kind;
            !matches!(kind, SlotKind::Computed(_))
        };
        let mut sorted = self.nbr.clone();
        sorted.sort_by_key(state);
        for op in &mut self.bond.tape.ops {
            if let Op::Nbr(k) = op {
                *k = position(&mut sorted, self.nbr[*k as usize]);
            }
        }
        self.nbr = sorted;
    }

    fn read_nbr(&mut self, slot: u32) -> u32 {
        let k = position(&mut self.nbr, slot);
        self.bond.op(Op::Nbr(k))
    }

    /// A value that does not depend on the bond is formed in the prologue.
    fn node_in_bond(&mut self, p: &Poly) -> u32 {
        if let Some(c) = p.as_ratio() {
            return self.bond.lit(c.value());
        }
        let r = self.prologue_value(p);
        let k = self.pre.out(r);
        self.bond.op(Op::Pre(k))
    }

    fn y(&mut self, a: u8) -> u32 {
        let (xi, eta) = (self.bond.op(Op::Xi(a)), self.bond.op(Op::Eta(a)));
        self.bond.op(Op::Add(xi, eta))
    }

    /// The order of `norm_squared` in the runtime: an undeformed bond must give the tabulated length.
    fn squared_length(&mut self) -> u32 {
        let y = self.y(0);
        let mut sum = self.bond.op(Op::Mul(y, y));
        for a in 1..self.schedule.dim() {
            let y = self.y(a as u8);
            sum = self.bond.op(Op::Fma(y, y, sum));
        }
        sum
    }

    fn inverse_length(&mut self) -> u32 {
        let yy = self.squared_length();
        self.bond.op(Op::Rsqrt(yy))
    }

    fn bond_atom(&mut self, id: AtomId) -> u32 {
        let atom = self.algebra.atom(id).clone();
        if self.algebra.nature(id).home != Home::Bond && !self.algebra.is_truth(id) {
            return self.node_in_bond(&Poly::atom(id));
        }
        match atom {
            Atom::Xi(a) => self.bond.op(Op::Xi(a)),
            Atom::Eta(a) => self.bond.op(Op::Eta(a)),
            Atom::Y(a) => self.y(a),
            Atom::Slack => {
                let iy = self.inverse_length();
                let ix = self.bond.op(Op::Ix);
                self.bond.op(Op::Sub(ix, iy))
            }
            Atom::DEta(_) => {
                let slot = self.schedule.state_slot(self.algebra, id);
                let (far, near) = (self.read_nbr(slot), self.read_own(slot));
                self.bond.op(Op::Sub(far, near))
            }
            Atom::Factor(w) => match self.weight(w) {
                Some(k) => self.bond.op(Op::History(k)),
                None => self.bond.lit(1.0),
            },
            Atom::FactorBack(w) => match self.weight(w) {
                Some(k) => self.bond.op(Op::Reverse(k)),
                None => self.bond.lit(1.0),
            },
            Atom::History(h) => {
                let k = position(&mut self.history, h);
                self.bond.op(Op::History(k))
            }
            Atom::Reverse(h) => {
                let k = position(&mut self.history, h);
                self.bond.op(Op::Reverse(k))
            }
            Atom::Prime(a) => self.primed(a),
            Atom::Named(_, p) => self.bond_value(&p),
            Atom::Func(f, args) => {
                let args: Vec<u32> = args.iter().map(|p| self.bond_value(p)).collect();
                function(&mut self.bond, f, &args, false)
            }
            // What is left is geometry, which the plan has taken out, or one of the kernel's own atoms.
            _ => self.bond_value(&Poly::atom(id)),
        }
    }

    /// Position of a weight in this sweep's list.
    fn weight(&mut self, weight: u32) -> Option<u32> {
        let number = self.schedule.weight(weight, self.family)?;
        Some(position(&mut self.history, number))
    }

    fn primed(&mut self, a: AtomId) -> u32 {
        match self.algebra.atom(a).clone() {
            Atom::Named(_, p) => {
                let p = self.algebra.prime(&p);
                self.bond_value(&p)
            }
            Atom::Func(f, args) => {
                let args: Vec<Poly> = args.iter().map(|p| self.algebra.prime(p)).collect();
                let args: Vec<u32> = args.iter().map(|p| self.bond_value(p)).collect();
                function(&mut self.bond, f, &args, true)
            }
            _ => {
                let slot = self.schedule.state_slot(self.algebra, a);
                self.read_nbr(slot)
            }
        }
    }

    /// A tabulated value; without geometry, one.
    fn geometry_value(&mut self, p: Option<&Poly>) -> u32 {
        let Some(p) = p else {
            return self.bond.lit(1.0);
        };
        let mut geometry = std::mem::take(&mut self.geometry);
        let r = self.constants.geometry(self.algebra, &mut geometry, p);
        let k = geometry.out(r);
        self.geometry = geometry;
        if k as usize == self.values.len() {
            self.values.push(p.clone());
        }
        self.bond.op(Op::Geo(k))
    }
}

fn by_geometry(terms: Vec<Term>) -> BTreeMap<Option<Poly>, Vec<Term>> {
    let mut groups: BTreeMap<Option<Poly>, Vec<Term>> = BTreeMap::new();
    for t in terms {
        groups.entry(t.geo.clone()).or_default().push(t);
    }
    groups
}

/// The operation of a function; on nodes a reciprocal of 0 is 0.
pub fn function(b: &mut Builder, f: Func, r: &[u32], guarded: bool) -> u32 {
    match f {
        Func::Recip => b.recip(r[0], guarded),
        Func::Sqrt => b.op(Op::Sqrt(r[0])),
        Func::Abs => b.op(Op::Abs(r[0])),
        Func::Exp => b.op(Op::Exp(r[0])),
        Func::Ln => b.op(Op::Ln(r[0])),
        Func::Sin => b.op(Op::Sin(r[0])),
        Func::Cos => b.op(Op::Cos(r[0])),
        Func::Tan => b.op(Op::Tan(r[0])),
        Func::Pow => b.op(Op::Pow(r[0], r[1])),
        Func::Min => b.op(Op::Min(r[0], r[1])),
        Func::Max => b.op(Op::Max(r[0], r[1])),
        Func::Select => b.op(Op::Select(r[0], r[1], r[2])),
        Func::Lt => b.op(Op::Lt(r[0], r[1])),
        Func::Le => b.op(Op::Le(r[0], r[1])),
        Func::And => b.op(Op::And(r[0], r[1])),
        Func::Or => b.op(Op::Or(r[0], r[1])),
        Func::Not => b.op(Op::Not(r[0])),
    }
}
