//! The normal form: Laurent polynomials with exact coefficients over interned atoms.
//!
//! Contract. A [`Poly`] is a sum of monomials, a [`Monomial`] a product of integer powers of atoms, both
//! sorted, so that equal polynomials are equal values and what cancels is gone. An [`Atom`] is a leaf (a
//! parameter, a component of xi), a reduction over bonds, the value of a node atom at the other end, a
//! named quantity that is not to be multiplied out, or a function of polynomials. Components are scalars:
//! dimension is fixed here.
//!
//! The length of the deformed bond is written as x + e, with e the extension as an atom of its own, so that
//! no difference of nearly equal lengths is ever formed; 1/|Y| is the atom `InverseY`.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::ir::{FamilyId, Home, Reduction};
use crate::ratio::Ratio;

/// Terms that a product may have before equal ones meet. The laws of papers stay below a hundred.
const MOST_TERMS: usize = 20_000;

#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct AtomId(pub u32);

#[derive(Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, Default)]
pub struct Monomial(pub Vec<(AtomId, i32)>);

#[derive(Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, Default)]
pub struct Poly(pub Vec<(Monomial, Ratio)>);

/// A scalar that the normal form does not look into.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Atom {
    /// A number that is not a short decimal, by its bits; infinity is one.
    Number(u64),
    Param(u32),
    Var(u32),
    Delta,
    /// One polynomial per flavour.
    Case(Vec<Poly>),
    /// Integral over the horizon.
    Ball(Poly),
    /// Node values that are state: (kind, index).
    State(StateKind, u32),
    /// Reduction of a bond polynomial.
    Sum(Reduction, FamilyId, Poly),
    /// A node atom at the other end of the bond.
    Prime(AtomId),
    Xi(u8),
    Eta(u8),
    /// xi + eta, kept whole.
    Y(u8),
    /// Component of the increment of eta along which the tangent acts.
    DEta(u8),
    /// |xi|.
    X,
    /// |xi + eta| - |xi|.
    Extension,
    /// 1/|xi + eta|.
    InverseY,
    /// 1/|xi| - 1/|xi + eta|; only kernels use it, where e = |xi| |Y| slack.
    Slack,
    /// |xi + eta| to any power; only kernels use it.
    Length,
    Omega(u32),
    /// Correction factor of this bond, and of the reverse one.
    Factor(u32),
    FactorBack(u32),
    /// Neighbour's volume times partial-volume factor.
    Weight,
    /// Bond history of this bond, and of the reverse one.
    History(u32),
    Reverse(u32),
    /// A definition kept whole.
    Named(String, Poly),
    Func(Func, Vec<Poly>),
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum StateKind {
    Velocity,
    Position,
    /// The time step: one number for all nodes.
    TimeStep,
    /// Component of a field or of a node history, by its slot among the state slots.
    Slot,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub enum Func {
    Recip,
    Sqrt,
    Abs,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Pow,
    Min,
    Max,
    Select,
    Lt,
    Le,
    And,
    Or,
    Not,
}

impl Func {
    /// A truth value, which no slot and no table holds: it is formed where it is used.
    pub fn is_truth(self) -> bool {
        matches!(self, Func::Lt | Func::Le | Func::And | Func::Or | Func::Not)
    }
}

/// How early a value can be known, leaving sums aside.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Rate {
    /// Reference geometry and constants.
    Reference,
    /// Reference geometry and which bonds are intact.
    Family,
    /// The state.
    Step,
    /// The increment of the tangent.
    Tangent,
}

/// What a polynomial depends on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Nature {
    pub home: Home,
    pub rate: Rate,
    /// Contains a reduction.
    pub sums: bool,
}

impl Nature {
    const CONSTANT: Nature = Nature {
        home: Home::Constant,
        rate: Rate::Reference,
        sums: false,
    };

    fn join(self, b: Nature) -> Nature {
        Nature {
            home: self.home.max(b.home),
            rate: self.rate.max(b.rate),
            sums: self.sums || b.sums,
        }
    }
}

/// Interner of atoms, and arithmetic on polynomials.
#[derive(Default)]
pub struct Algebra {
    atoms: Vec<Atom>,
    natures: Vec<Nature>,
    ids: HashMap<Atom, AtomId>,
    /// Correction factors that are the same seen from both ends.
    pub symmetric: BTreeSet<u32>,
    /// Set when a coefficient or a product did not fit; the law is then rejected.
    pub overflow: bool,
}

impl Poly {
    pub fn zero() -> Poly {
        Poly(Vec::new())
    }

    pub fn constant(c: Ratio) -> Poly {
        if c.is_zero() {
            Poly::zero()
        } else {
            Poly(vec![(Monomial::default(), c)])
        }
    }

    pub fn int(n: i64) -> Poly {
        Poly::constant(Ratio::int(n))
    }

    pub fn atom(a: AtomId) -> Poly {
        Poly::power(a, 1)
    }

    pub fn power(a: AtomId, n: i32) -> Poly {
        Poly(vec![(Monomial(vec![(a, n)]), Ratio::ONE)])
    }

    pub fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    /// The coefficient, if nothing but a coefficient is left.
    pub fn as_ratio(&self) -> Option<Ratio> {
        match self.0.as_slice() {
            [] => Some(Ratio::ZERO),
            [(m, c)] if m.0.is_empty() => Some(*c),
            _ => None,
        }
    }

    /// The atom, if the polynomial is one atom to the first power.
    pub fn as_atom(&self) -> Option<AtomId> {
        match self.0.as_slice() {
            [(m, c)] if c.is_one() => match m.0.as_slice() {
                [(a, 1)] => Some(*a),
                _ => None,
            },
            _ => None,
        }
    }

    pub fn neg(&self) -> Poly {
        Poly(self.0.iter().map(|(m, c)| (m.clone(), c.neg())).collect())
    }
}

impl Monomial {
    pub fn mul(&self, b: &Monomial) -> Monomial {
        let mut out = Vec::with_capacity(self.0.len() + b.0.len());
        let (mut i, mut j) = (0, 0);
        while i < self.0.len() && j < b.0.len() {
            let ((p, m), (q, n)) = (self.0[i], b.0[j]);
            match p.cmp(&q) {
                std::cmp::Ordering::Less => out.push((p, m)),
                std::cmp::Ordering::Greater => out.push((q, n)),
                std::cmp::Ordering::Equal if m + n != 0 => out.push((p, m + n)),
                std::cmp::Ordering::Equal => {}
            }
            i += usize::from(p <= q);
            j += usize::from(q <= p);
        }
        out.extend_from_slice(&self.0[i..]);
        out.extend_from_slice(&b.0[j..]);
        Monomial(out)
    }

    pub fn powi(&self, n: i32) -> Monomial {
        if n == 0 {
            Monomial::default()
        } else {
            Monomial(self.0.iter().map(|&(a, k)| (a, k * n)).collect())
        }
    }

    /// The exponent of an atom.
    pub fn degree(&self, a: AtomId) -> i32 {
        self.0.iter().find(|(b, _)| *b == a).map_or(0, |(_, n)| *n)
    }

    /// The same product without one atom.
    pub fn without(&self, a: AtomId) -> Monomial {
        Monomial(self.0.iter().copied().filter(|(b, _)| *b != a).collect())
    }
}

/// Collects terms; equal monomials meet.
#[derive(Default)]
pub struct Collector {
    terms: BTreeMap<Monomial, Ratio>,
    overflow: bool,
}

impl Collector {
    pub fn term(&mut self, m: Monomial, c: Ratio) {
        let slot = self.terms.entry(m).or_insert(Ratio::ZERO);
        match slot.add(c) {
            Some(s) => *slot = s,
            None => self.overflow = true,
        }
    }

    pub fn finish(self, algebra: &mut Algebra) -> Poly {
        algebra.overflow |= self.overflow;
        Poly(
            self.terms
                .into_iter()
                .filter(|(_, c)| !c.is_zero())
                .collect(),
        )
    }
}

impl Algebra {
    pub fn intern(&mut self, atom: Atom) -> AtomId {
        if let Some(id) = self.ids.get(&atom) {
            return *id;
        }
        let id = AtomId(self.atoms.len() as u32);
        let nature = self.nature_of_atom(&atom);
        self.atoms.push(atom.clone());
        self.natures.push(nature);
        self.ids.insert(atom, id);
        id
    }

    pub fn is_truth(&self, id: AtomId) -> bool {
        match self.atom(id) {
            Atom::Func(f, _) => f.is_truth(),
            Atom::Prime(a) => self.is_truth(*a),
            _ => false,
        }
    }

    pub fn poly(&mut self, atom: Atom) -> Poly {
        Poly::atom(self.intern(atom))
    }

    pub fn atom(&self, id: AtomId) -> &Atom {
        &self.atoms[id.0 as usize]
    }

    /// All atoms so far, by id.
    pub fn atoms(&self) -> &[Atom] {
        &self.atoms
    }

    pub fn nature(&self, id: AtomId) -> Nature {
        self.natures[id.0 as usize]
    }

    pub fn number(&mut self, v: f64) -> Poly {
        match Ratio::from_f64(v) {
            Some(c) => Poly::constant(c),
            None => self.poly(Atom::Number(v.to_bits())),
        }
    }

    pub fn nature_of(&self, p: &Poly) -> Nature {
        let mut n = Nature::CONSTANT;
        for (m, _) in &p.0 {
            for (a, _) in &m.0 {
                n = n.join(self.nature(*a));
            }
        }
        n
    }

    fn nature_of_all(&self, ps: &[Poly]) -> Nature {
        ps.iter()
            .fold(Nature::CONSTANT, |n, p| n.join(self.nature_of(p)))
    }

    fn nature_of_atom(&self, atom: &Atom) -> Nature {
        let bond = |rate| Nature {
            home: Home::Bond,
            rate,
            sums: false,
        };
        match atom {
            Atom::Number(_) | Atom::Param(_) | Atom::Var(_) | Atom::Delta => Nature::CONSTANT,
            Atom::Case(_) | Atom::Ball(_) => Nature::CONSTANT,
            Atom::State(kind, _) => {
                let rate = if *kind == StateKind::Position {
                    Rate::Reference
                } else {
                    Rate::Step
                };
                Nature {
                    home: Home::Node,
                    rate,
                    sums: false,
                }
            }
            Atom::Sum(reduction, _, body) => {
                let floor = if *reduction == Reduction::Sum0 {
                    Rate::Reference
                } else {
                    Rate::Family
                };
                Nature {
                    home: Home::Node,
                    rate: self.nature_of(body).rate.max(floor),
                    sums: true,
                }
            }
            Atom::Prime(a) => Nature {
                home: Home::Bond,
                ..self.nature(*a)
            },
            Atom::Xi(_) | Atom::X | Atom::Omega(_) | Atom::Weight => bond(Rate::Reference),
            Atom::Factor(_) | Atom::FactorBack(_) => bond(Rate::Reference),
            Atom::Eta(_) | Atom::Y(_) | Atom::Extension | Atom::InverseY => bond(Rate::Step),
            Atom::Slack | Atom::Length => bond(Rate::Step),
            Atom::History(_) | Atom::Reverse(_) => bond(Rate::Step),
            Atom::DEta(_) => bond(Rate::Tangent),
            Atom::Named(_, p) => self.nature_of(p),
            Atom::Func(_, args) => self.nature_of_all(args),
        }
    }

    pub fn add(&mut self, a: &Poly, b: &Poly) -> Poly {
        self.sum([a, b])
    }

    pub fn sub(&mut self, a: &Poly, b: &Poly) -> Poly {
        self.sum([a, &b.neg()])
    }

    pub fn sum<'a>(&mut self, parts: impl IntoIterator<Item = &'a Poly>) -> Poly {
        let mut c = Collector::default();
        for p in parts {
            for (m, k) in &p.0 {
                c.term(m.clone(), *k);
            }
        }
        c.finish(self)
    }

    pub fn mul(&mut self, a: &Poly, b: &Poly) -> Poly {
        if a.0.len() * b.0.len() > MOST_TERMS {
            self.overflow = true;
            return Poly::zero();
        }
        let mut c = Collector::default();
        for (m, p) in &a.0 {
            for (n, q) in &b.0 {
                match p.mul(*q) {
                    Some(k) => c.term(m.mul(n), k),
                    None => self.overflow = true,
                }
            }
        }
        c.finish(self)
    }

    /// What a reduction takes of every bond: sums count the other end's volume, extremes do not.
    pub fn weighted(&mut self, reduction: Reduction, body: &Poly) -> Poly {
        if reduction.is_extreme() {
            return body.clone();
        }
        let weight = self.poly(Atom::Weight);
        self.mul(&weight, body)
    }

    /// The same with constants inside of a sum where no other sum stands beside it: there they are those of the bond.
    /// The force of such an energy takes them so, and its energy must too.
    pub fn constants_on_bonds(&mut self, p: &Poly) -> Poly {
        let mut bodies: BTreeMap<(Monomial, Reduction, FamilyId), Poly> = BTreeMap::new();
        let mut total = Poly::zero();
        for (m, k) in &p.0 {
            let term = Poly(vec![(m.clone(), *k)]);
            let summed: Vec<(AtomId, i32)> =
                m.0.iter()
                    .copied()
                    .filter(|(a, _)| self.nature(*a).sums)
                    .collect();
            let [(sum, 1)] = summed[..] else {
                total = self.add(&total, &term);
                continue;
            };
            let beside = m.without(sum);
            let (constants, others) = self.split_constants(&beside);
            let part = Poly(vec![(constants, *k)]);
            match self.atom(sum).clone() {
                Atom::Named(_, inner) => {
                    let inner = self.mul(&part, &inner);
                    let inner = self.constants_on_bonds(&inner);
                    let inner = self.mul(&Poly(vec![(others, Ratio::ONE)]), &inner);
                    total = self.add(&total, &inner);
                }
                Atom::Sum(r, f, body) if !r.is_extreme() => {
                    let body = self.mul(&part, &body);
                    let key = (others, r, f);
                    let whole = self.add(&bodies.remove(&key).unwrap_or_default(), &body);
                    bodies.insert(key, whole);
                }
                _ => total = self.add(&total, &term),
            }
        }
        for ((others, reduction, family), body) in bodies {
            let sum = self.poly(Atom::Sum(reduction, family, body));
            let term = self.mul(&Poly(vec![(others, Ratio::ONE)]), &sum);
            total = self.add(&total, &term);
        }
        total
    }

    /// The constants of a monomial, and its other factors.
    pub fn split_constants(&self, m: &Monomial) -> (Monomial, Monomial) {
        let constant = |(a, _): &(AtomId, i32)| self.nature(*a).home == Home::Constant;
        let (constants, others) = m.0.iter().copied().partition(constant);
        (Monomial(constants), Monomial(others))
    }

    pub fn scale(&mut self, a: &Poly, k: Ratio) -> Poly {
        self.mul(a, &Poly::constant(k))
    }

    pub fn func(&mut self, f: Func, args: Vec<Poly>) -> Poly {
        self.poly(Atom::Func(f, args))
    }

    /// 1/p. A single term is inverted in place; x + e is |Y|; anything else is a function.
    pub fn recip(&mut self, p: &Poly) -> Poly {
        if let [(m, c)] = p.0.as_slice()
            && let Some(k) = Ratio::ONE.div(*c)
        {
            return Poly(vec![(m.powi(-1), k)]);
        }
        if *p == self.deformed_length() {
            return self.poly(Atom::InverseY);
        }
        self.func(Func::Recip, vec![p.clone()])
    }

    /// |Y| = x + e.
    pub fn deformed_length(&mut self) -> Poly {
        let x = self.poly(Atom::X);
        let e = self.poly(Atom::Extension);
        self.add(&x, &e)
    }

    pub fn powi(&mut self, p: &Poly, n: i32) -> Poly {
        if n < 0 {
            let r = self.recip(p);
            return self.powi(&r, -n);
        }
        let mut out = Poly::int(1);
        for _ in 0..n {
            out = self.mul(&out, p);
        }
        out
    }

    pub fn pow(&mut self, base: &Poly, exponent: &Poly) -> Poly {
        match exponent.as_ratio() {
            Some(k) if k.as_int().is_some_and(|n| n.abs() <= 64) => {
                let n = k.as_int().unwrap_or_default();
                self.powi(base, n)
            }
            Some(k) if k.twice_int().is_some_and(|n| n.abs() <= 64) => {
                let root = self.sqrt(base);
                self.powi(&root, k.twice_int().unwrap_or_default())
            }
            _ => self.func(Func::Pow, vec![base.clone(), exponent.clone()]),
        }
    }

    /// Square root; even powers of lengths come out.
    pub fn sqrt(&mut self, p: &Poly) -> Poly {
        let x = self.intern(Atom::X);
        if *p == Poly::power(x, 2) {
            return Poly::atom(x);
        }
        let y = self.deformed_length();
        if *p == self.mul(&y, &y) {
            return y;
        }
        self.func(Func::Sqrt, vec![p.clone()])
    }
}
