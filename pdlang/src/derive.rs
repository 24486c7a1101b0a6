//! Derivatives of polynomials: the other end of a bond, the force from the energy, the tangent.
//!
//! Contract. Input: a node polynomial W in the split reading. Output: bond polynomials T_a, one list per
//! reduction and family, with dU/dY_a of bond i -> j equal to T_a times the weights of both ends, where
//! U is the sum of V W over the body. The gradient passes through reductions by their adjoints, last
//! reduction first, so that nested sums are as good as any. `sum` and `sum0` are never merged.

use std::collections::{BTreeMap, HashMap};

use crate::ir::{FamilyId, Reduction};
use crate::lower::{Lowering, Reading};
use crate::poly::{Algebra, Atom, AtomId, Collector, Func, Monomial, Poly, Rate, StateKind};
use crate::ratio::Ratio;

/// What an atom contributes to a derivative; `None` asks for the chain rule.
type Leaf<'a> = &'a mut dyn FnMut(&mut Algebra, AtomId) -> Option<Poly>;

impl Algebra {
    /// The same polynomial seen from the other end of the bond.
    pub fn prime(&mut self, p: &Poly) -> Poly {
        let mut sum = Poly::zero();
        for (m, c) in &p.0 {
            let mut term = Poly::constant(*c);
            for (a, n) in &m.0 {
                let primed = self.prime_atom(*a);
                let power = self.powi(&primed, *n);
                term = self.mul(&term, &power);
            }
            sum = self.add(&sum, &term);
        }
        sum
    }

    fn prime_atom(&mut self, id: AtomId) -> Poly {
        if self.is_uniform(id) {
            return Poly::atom(id);
        }
        match self.atom(id).clone() {
            Atom::State(..) | Atom::Sum(..) => self.poly(Atom::Prime(id)),
            Atom::Prime(a) => Poly::atom(a),
            Atom::Xi(_) | Atom::Eta(_) | Atom::Y(_) | Atom::DEta(_) => Poly::atom(id).neg(),
            Atom::Factor(k) if self.symmetric.contains(&k) => Poly::atom(id),
            Atom::Factor(k) => self.poly(Atom::FactorBack(k)),
            Atom::FactorBack(k) => self.poly(Atom::Factor(k)),
            Atom::History(k) => self.poly(Atom::Reverse(k)),
            Atom::Reverse(k) => self.poly(Atom::History(k)),
            Atom::Named(name, p) => self.prime_named(id, name, &p),
            // A function of sums is formed once at its own node, where a reciprocal of nothing is guarded.
            Atom::Func(..) if self.nature(id).home == crate::ir::Home::Node => {
                self.poly(Atom::Prime(id))
            }
            Atom::Func(f, args) => {
                let args = args.iter().map(|p| self.prime(p)).collect();
                self.func(f, args)
            }
            _ => Poly::atom(id),
        }
    }

    /// True for what is made of constants and the time step: the same at every node.
    fn is_uniform(&self, id: AtomId) -> bool {
        let all = |p: &Poly| {
            p.0.iter()
                .flat_map(|(m, _)| &m.0)
                .all(|(a, _)| self.is_uniform(*a))
        };
        match self.atom(id) {
            Atom::State(kind, _) => *kind == StateKind::TimeStep,
            Atom::Named(_, p) => all(p),
            Atom::Func(_, args) => args.iter().all(all),
            _ => self.nature(id).home == crate::ir::Home::Constant,
        }
    }

    fn prime_named(&mut self, id: AtomId, name: String, p: &Poly) -> Poly {
        match self.nature(id).home {
            crate::ir::Home::Constant => Poly::atom(id),
            crate::ir::Home::Node => self.poly(Atom::Prime(id)),
            crate::ir::Home::Bond => {
                let q = self.prime(p);
                if q == *p {
                    return Poly::atom(id);
                }
                if q == p.neg() {
                    return Poly::atom(id).neg();
                }
                if q.0.len() > 1 {
                    self.poly(Atom::Named(format!("{name}'"), q))
                } else {
                    q
                }
            }
        }
    }

    /// Derivative along a direction given by what it does to leaves.
    fn along(&mut self, p: &Poly, memo: &mut HashMap<AtomId, Poly>, leaf: Leaf) -> Poly {
        // Terms meet once: added one after the other, thousands of them would each be copied thousands of times.
        let mut out = Collector::default();
        for (m, c) in &p.0 {
            for (a, n) in &m.0 {
                let d = self.along_atom(*a, memo, leaf);
                if d.is_zero() {
                    continue;
                }
                let rest = m.mul(&Monomial(vec![(*a, -1)]));
                let Some(k) = c.mul(Ratio::int(*n as i64)) else {
                    self.overflow = true;
                    continue;
                };
                for (m, c) in self.mul(&Poly(vec![(rest, k)]), &d).0 {
                    out.term(m, c);
                }
            }
        }
        out.finish(self)
    }

    fn along_atom(&mut self, id: AtomId, memo: &mut HashMap<AtomId, Poly>, leaf: Leaf) -> Poly {
        if let Some(d) = memo.get(&id) {
            return d.clone();
        }
        if self.nature(id).rate < Rate::Step {
            return Poly::zero();
        }
        let d = match leaf(self, id) {
            Some(d) => d,
            None => match self.atom(id).clone() {
                Atom::Named(name, p) => {
                    let d = self.along(&p, memo, leaf);
                    let keep = d.0.len() > 1;
                    if keep {
                        self.poly(Atom::Named(format!("d{name}"), d))
                    } else {
                        d
                    }
                }
                Atom::Func(f, args) => self.along_func(f, &args, memo, leaf),
                _ => Poly::zero(),
            },
        };
        memo.insert(id, d.clone());
        d
    }

    fn along_func(
        &mut self,
        f: Func,
        args: &[Poly],
        memo: &mut HashMap<AtomId, Poly>,
        leaf: Leaf,
    ) -> Poly {
        let d: Vec<Poly> = args.iter().map(|p| self.along(p, memo, leaf)).collect();
        if d.iter().all(Poly::is_zero) {
            return Poly::zero();
        }
        let this = self.func(f, args.to_vec());
        let a = &args[0];
        match f {
            Func::Recip => {
                let square = self.mul(&this, &this);
                self.mul(&square, &d[0]).neg()
            }
            Func::Sqrt => {
                let half = self.number(0.5);
                let r = self.recip(&this);
                let slope = self.mul(&half, &r);
                self.mul(&slope, &d[0])
            }
            Func::Exp => self.mul(&this, &d[0]),
            Func::Ln => {
                let r = self.recip(a);
                self.mul(&r, &d[0])
            }
            Func::Sin => {
                let c = self.func(Func::Cos, vec![a.clone()]);
                self.mul(&c, &d[0])
            }
            Func::Cos => {
                let s = self.func(Func::Sin, vec![a.clone()]);
                self.mul(&s, &d[0]).neg()
            }
            Func::Tan => {
                let square = self.mul(&this, &this);
                let slope = self.add(&Poly::int(1), &square);
                self.mul(&slope, &d[0])
            }
            Func::Abs => {
                let negative = self.func(Func::Lt, vec![a.clone(), Poly::zero()]);
                self.func(Func::Select, vec![negative, d[0].neg(), d[0].clone()])
            }
            Func::Min | Func::Max => {
                let (p, q) = if f == Func::Min { (0, 1) } else { (1, 0) };
                let first = self.func(Func::Lt, vec![args[p].clone(), args[q].clone()]);
                self.func(Func::Select, vec![first, d[0].clone(), d[1].clone()])
            }
            Func::Pow => self.along_pow(&this, args, &d),
            Func::Select => self.func(Func::Select, vec![a.clone(), d[1].clone(), d[2].clone()]),
            Func::Lt | Func::Le | Func::And | Func::Or | Func::Not => Poly::zero(),
        }
    }

    fn along_pow(&mut self, this: &Poly, args: &[Poly], d: &[Poly]) -> Poly {
        let less = self.sub(&args[1], &Poly::int(1));
        let lower = self.func(Func::Pow, vec![args[0].clone(), less]);
        let slope = self.mul(&args[1], &lower);
        let base = self.mul(&slope, &d[0]);
        if d[1].is_zero() {
            return base;
        }
        let log = self.func(Func::Ln, vec![args[0].clone()]);
        let t = self.mul(this, &log);
        let exponent = self.mul(&t, &d[1]);
        self.add(&base, &exponent)
    }

    /// d e = Y.dY/|Y| and d(1/|Y|) = -Y.dY/|Y|^3, where `along` is Y.dY.
    fn length_derivative(&mut self, atom: &Atom, along: &Poly) -> Option<Poly> {
        let inverse = self.poly(Atom::InverseY);
        match atom {
            Atom::Extension => Some(self.mul(&inverse, along)),
            Atom::InverseY => {
                let cube = self.powi(&inverse, 3);
                Some(self.mul(&cube, along).neg())
            }
            _ => None,
        }
    }

    /// Partial derivative of a bond polynomial with respect to Y_a, node values held.
    fn partial_y(&mut self, p: &Poly, a: u8) -> Poly {
        let y = self.poly(Atom::Y(a));
        self.along(p, &mut HashMap::new(), &mut |algebra, id| {
            let atom = algebra.atom(id).clone();
            if let Some(d) = algebra.length_derivative(&atom, &y) {
                return Some(d);
            }
            match atom {
                Atom::Y(b) | Atom::Eta(b) => Some(Poly::int(i64::from(a == b))),
                Atom::Named(..) | Atom::Func(..) => None,
                _ => Some(Poly::zero()),
            }
        })
    }

    /// Partial derivative with respect to one atom, other reductions held.
    fn partial(&mut self, p: &Poly, target: AtomId) -> Poly {
        self.along(p, &mut HashMap::new(), &mut |algebra, id| {
            if id == target {
                return Some(Poly::int(1));
            }
            match (algebra.atom(id).clone(), algebra.atom(target).clone()) {
                (Atom::Named(..) | Atom::Func(..), _) => None,
                (Atom::Prime(far), Atom::Prime(inner)) => {
                    let slope = algebra.partial(&Poly::atom(far), inner);
                    Some(algebra.prime(&slope))
                }
                _ => Some(Poly::zero()),
            }
        })
    }

    /// Reductions that a polynomial contains: (atom, whether its value at the other end is meant).
    fn reductions(&self, p: &Poly, found: &mut BTreeMap<(AtomId, bool), ()>) {
        for (m, _) in &p.0 {
            for (id, _) in &m.0 {
                match self.atom(*id) {
                    // What displacements do not change exerts no force.
                    Atom::Sum(..) if self.nature(*id).rate < Rate::Step => {}
                    Atom::Sum(reduction, ..) if reduction.is_extreme() => {}
                    Atom::Sum(..) => {
                        found.insert((*id, false), ());
                    }
                    Atom::Prime(a) => {
                        let mut far = BTreeMap::new();
                        self.reductions(&Poly::atom(*a), &mut far);
                        found.extend(far.into_keys().map(|(sum, _)| ((sum, true), ())));
                    }
                    Atom::Named(_, p) => self.reductions(p, found),
                    Atom::Func(_, args) => args.iter().for_each(|p| self.reductions(p, found)),
                    _ => {}
                }
            }
        }
    }
}

/// The force state, per reduction and family: components T_a.
pub type ForceState = BTreeMap<(Reduction, FamilyId), Vec<Poly>>;

/// Gradient of the energy of the whole body.
pub fn force_state(lowering: &mut Lowering, energy: &Poly) -> ForceState {
    let dim = lowering.dim;
    let mut adjoints: BTreeMap<AtomId, Poly> = BTreeMap::new();
    let mut state = ForceState::new();
    seed(lowering.algebra, energy, &mut adjoints);
    for sum in last_first(lowering.algebra, energy) {
        let Atom::Sum(reduction, family, body) = lowering.algebra.atom(sum).clone() else {
            continue;
        };
        let Some(adjoint) = adjoints.get(&sum).cloned() else {
            continue;
        };
        let parts = state
            .entry((reduction, family))
            .or_insert_with(|| vec![Poly::zero(); dim]);
        for (a, part) in parts.iter_mut().enumerate() {
            let slope = lowering.algebra.partial_y(&body, a as u8);
            let t = lowering.algebra.mul(&adjoint, &slope);
            *part = lowering.algebra.add(part, &t);
        }
        let mut inner = BTreeMap::new();
        lowering.algebra.reductions(&body, &mut inner);
        for (target, primed) in inner.into_keys() {
            let atom = if primed {
                lowering.algebra.intern(Atom::Prime(target))
            } else {
                target
            };
            let slope = lowering.algebra.partial(&body, atom);
            let mut flow = lowering.algebra.mul(&adjoint, &slope);
            if primed {
                flow = lowering.algebra.prime(&flow);
            }
            let share = lowering.reduce(reduction, family, &flow, Reading::Split);
            let total = adjoints.entry(target).or_default();
            *total = lowering.algebra.add(total, &share);
        }
    }
    state.retain(|_, parts| parts.iter().any(|p| !p.is_zero()));
    state
}

fn seed(algebra: &mut Algebra, energy: &Poly, adjoints: &mut BTreeMap<AtomId, Poly>) {
    let mut found = BTreeMap::new();
    algebra.reductions(energy, &mut found);
    for (sum, _) in found.into_keys() {
        let slope = algebra.partial(energy, sum);
        adjoints.insert(sum, slope);
    }
}

/// Every reduction below `p`, users before what they use.
fn last_first(algebra: &Algebra, p: &Poly) -> Vec<AtomId> {
    fn visit(algebra: &Algebra, p: &Poly, order: &mut Vec<AtomId>) {
        let mut found = BTreeMap::new();
        algebra.reductions(p, &mut found);
        for (sum, _) in found.into_keys() {
            if order.contains(&sum) {
                continue;
            }
            if let Atom::Sum(_, _, body) = algebra.atom(sum) {
                visit(algebra, body, order);
            }
            order.push(sum);
        }
    }
    let mut order = Vec::new();
    visit(algebra, p, &mut order);
    order.reverse();
    order
}

/// Derivative along the increment of the displacement, through all reductions.
pub fn tangent(
    algebra: &mut Algebra,
    dim: usize,
    p: &Poly,
    memo: &mut HashMap<AtomId, Poly>,
) -> Poly {
    let mut products = Collector::default();
    for a in 0..dim as u8 {
        let y = algebra.intern(Atom::Y(a));
        let d = algebra.intern(Atom::DEta(a));
        products.term(
            Monomial(vec![(y, 1)]).mul(&Monomial(vec![(d, 1)])),
            Ratio::ONE,
        );
    }
    let stretch = products.finish(algebra);
    let stretch = if dim > 1 {
        algebra.poly(Atom::Named("Y.dY".into(), stretch))
    } else {
        stretch
    };
    increment(algebra, &stretch, p, memo)
}

fn increment(
    algebra: &mut Algebra,
    stretch: &Poly,
    p: &Poly,
    memo: &mut HashMap<AtomId, Poly>,
) -> Poly {
    algebra.along(p, memo, &mut |algebra, id| {
        let atom = algebra.atom(id).clone();
        if let Some(d) = algebra.length_derivative(&atom, stretch) {
            return Some(d);
        }
        match atom {
            Atom::Y(a) | Atom::Eta(a) => Some(algebra.poly(Atom::DEta(a))),
            // Which bond is the extreme one is held.
            Atom::Sum(reduction, ..) if reduction.is_extreme() => Some(Poly::zero()),
            Atom::Sum(reduction, family, body) => {
                let d = increment(algebra, stretch, &body, &mut HashMap::new());
                Some(if d.is_zero() {
                    d
                } else {
                    algebra.poly(Atom::Sum(reduction, family, d))
                })
            }
            Atom::Prime(a) => {
                let d = increment(algebra, stretch, &Poly::atom(a), &mut HashMap::new());
                Some(algebra.prime(&d))
            }
            Atom::Named(..) | Atom::Func(..) => None,
            _ => Some(Poly::zero()),
        }
    })
}
