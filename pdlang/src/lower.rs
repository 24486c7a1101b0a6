//! Typed IR -> polynomials, at one dimension.
//!
//! Two readings of the same law. [`Reading::Whole`] keeps what the author named: a definition with several
//! terms stays one atom, a reduction keeps its body. Energies are evaluated so, because expanding a square
//! loses digits. [`Reading::Split`] inlines all but long definitions and splits reductions into sums of single monomials
//! with node factors pulled out; the force is derived from that, because there equal sums meet and cancel.

mod tensors;

use std::collections::HashMap;

use crate::ir::{
    BinaryOp, Builtin, CompareOp, ExprId, ExprKind, FamilyId, Flavour, Home, Law, Reduction, Shape,
};
use crate::linear::Linear;
use crate::poly::{Algebra, Atom, Collector, Func, Monomial, Poly, Rate, StateKind};
use crate::ratio::Ratio;

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Reading {
    Whole,
    Split,
}

/// Terms above which a definition stays whole even when sums are split: nothing in it is going to cancel, and
/// products of such would have thousands of terms.
const LONG: usize = 8;

/// Components in row-major order; a symmetric tensor is stored full.
pub type Value = Vec<Poly>;

pub struct Lowering<'a> {
    pub law: &'a Law,
    pub dim: usize,
    pub algebra: &'a mut Algebra,
    /// First state slot of each field and of each node history.
    pub field_slots: Vec<u32>,
    pub history_slots: Vec<u32>,
    /// Set where the law is linearised.
    pub linear: Option<Linear>,
    defs: HashMap<(u32, Reading), Value>,
}

/// Scalars that a shape has at a dimension when stored without repetition.
pub fn stored_components(shape: Shape, dim: usize) -> usize {
    match shape {
        Shape::Scalar | Shape::Boolean => 1,
        Shape::Vector => dim,
        Shape::Symmetric => dim * (dim + 1) / 2,
        Shape::Tensor => dim * dim,
    }
}

/// `_x`, `_xy`, or nothing.
pub fn component_name(shape: Shape, dim: usize, k: usize) -> String {
    let axis = |a: usize| ["x", "y", "z"][a];
    match shape {
        Shape::Scalar | Shape::Boolean => String::new(),
        Shape::Vector => format!("_{}", axis(k)),
        Shape::Symmetric | Shape::Tensor => format!("_{}{}", axis(k / dim), axis(k % dim)),
    }
}

/// What distinguishes the names of stored components.
pub fn stored_names(shape: Shape, dim: usize) -> Vec<String> {
    let all = match shape {
        Shape::Scalar | Shape::Boolean => 1,
        Shape::Vector => dim,
        Shape::Symmetric | Shape::Tensor => dim * dim,
    };
    (0..all)
        .filter(|k| shape != Shape::Symmetric || k / dim <= k % dim)
        .map(|k| component_name(shape, dim, k))
        .collect()
}

impl<'a> Lowering<'a> {
    pub fn new(law: &'a Law, dim: usize, algebra: &'a mut Algebra) -> Self {
        let mut next = 0;
        let mut take = |n: usize| {
            next += n as u32;
            next - n as u32
        };
        let field_slots = law
            .fields
            .iter()
            .map(|f| take(stored_components(f.shape, dim)))
            .collect();
        let history_slots = law
            .histories
            .iter()
            .map(|h| {
                if h.home == Home::Node {
                    take(stored_components(h.shape, dim))
                } else {
                    0
                }
            })
            .collect();
        Lowering {
            law,
            dim,
            algebra,
            field_slots,
            history_slots,
            linear: None,
            defs: HashMap::new(),
        }
    }

    fn full(&self, shape: Shape) -> usize {
        match shape {
            Shape::Scalar | Shape::Boolean => 1,
            Shape::Vector => self.dim,
            Shape::Symmetric | Shape::Tensor => self.dim * self.dim,
        }
    }

    /// Index of a full component among the stored ones.
    fn place(&self, shape: Shape, k: usize) -> u32 {
        if shape != Shape::Symmetric {
            return k as u32;
        }
        let (r, c) = (k / self.dim, k % self.dim);
        let (r, c) = (r.min(c), r.max(c));
        (r * self.dim - r * (r + 1) / 2 + c) as u32
    }

    pub fn value(&mut self, id: ExprId, reading: Reading) -> Value {
        let law = self.law;
        let expr = &law.exprs[id.index()];
        let n = self.full(expr.shape);
        match &expr.kind {
            ExprKind::Number(v) => vec![self.algebra.number(*v)],
            ExprKind::Pi => vec![
                self.algebra
                    .poly(Atom::Number(std::f64::consts::PI.to_bits())),
            ],
            ExprKind::Dim => vec![Poly::int(self.dim as i64)],
            ExprKind::Delta => vec![self.algebra.poly(Atom::Delta)],
            ExprKind::Identity => self.identity(),
            ExprKind::Var(k) => vec![self.algebra.poly(Atom::Var(*k))],
            ExprKind::Param(p) => vec![self.algebra.poly(Atom::Param(p.0))],
            ExprKind::Def(d) => self.definition(d.index(), reading),
            ExprKind::Field(f) => self.slots(self.field_slots[f.index()], expr.shape, n),
            ExprKind::History(h) => self.history(h.index(), expr.shape, n),
            ExprKind::Weight(w) => vec![self.algebra.poly(Atom::Factor(w.0))],
            ExprKind::Influence(k) => vec![self.algebra.poly(Atom::Omega(k.0))],
            ExprKind::Xi => self.axes(Atom::Xi),
            ExprKind::Eta => self.axes(Atom::Eta),
            ExprKind::Velocity => self.axes(|a| Atom::State(StateKind::Velocity, a as u32)),
            ExprKind::Position => self.axes(|a| Atom::State(StateKind::Position, a as u32)),
            ExprKind::TimeStep => vec![self.algebra.poly(Atom::State(StateKind::TimeStep, 0))],
            ExprKind::Neg(a) => self.value(*a, reading).iter().map(Poly::neg).collect(),
            ExprKind::Not(a) => {
                let a = self.value(*a, reading);
                vec![self.algebra.func(Func::Not, a)]
            }
            ExprKind::Binary(op, a, b) => self.binary(*op, *a, *b, reading),
            ExprKind::Compare(op, a, b) => self.compare(*op, *a, *b, reading),
            ExprKind::Call(f, args) => self.call(*f, args, reading),
            ExprKind::Vector(parts) => self.vector(parts, reading),
            ExprKind::Component(a, axes) => self.component(*a, axes, reading),
            ExprKind::Reduce(r, family, body) => {
                let body = self.value(*body, reading);
                body.iter()
                    .map(|b| self.reduction(*r, *family, b, reading))
                    .collect()
            }
            ExprKind::Ball(body) => {
                let body = self.value(*body, Reading::Split).remove(0);
                vec![self.ball(&body)]
            }
            ExprKind::Prime(a) => {
                let a = self.value(*a, reading);
                a.iter().map(|p| self.algebra.prime(p)).collect()
            }
            ExprKind::Case(arms) => self.case(arms, reading),
        }
    }

    /// The components, without repetition, of a value that is stored as `shape`.
    pub fn stored(&mut self, id: ExprId, shape: Shape, reading: Reading) -> Value {
        let full = self.value(id, reading);
        let dim = self.dim;
        let once = |k: &usize| shape != Shape::Symmetric || k / dim <= k % dim;
        (0..full.len())
            .filter(once)
            .map(|k| full[k].clone())
            .collect()
    }

    fn identity(&self) -> Value {
        (0..self.dim * self.dim)
            .map(|k| Poly::int(i64::from(k / self.dim == k % self.dim)))
            .collect()
    }

    fn axes(&mut self, atom: impl Fn(u8) -> Atom) -> Value {
        (0..self.dim as u8)
            .map(|a| self.algebra.poly(atom(a)))
            .collect()
    }

    fn slots(&mut self, first: u32, shape: Shape, n: usize) -> Value {
        (0..n)
            .map(|k| {
                let slot = first + self.place(shape, k);
                self.algebra.poly(Atom::State(StateKind::Slot, slot))
            })
            .collect()
    }

    fn history(&mut self, h: usize, shape: Shape, n: usize) -> Value {
        if self.law.histories[h].home == Home::Node {
            return self.slots(self.history_slots[h], shape, n);
        }
        let first = self.bond_history(h);
        (0..n)
            .map(|k| {
                let index = first + self.place(shape, k);
                self.algebra.poly(Atom::History(index))
            })
            .collect()
    }

    /// First scalar of a bond history among all bond histories.
    pub fn bond_history(&self, h: usize) -> u32 {
        let before = &self.law.histories[..h];
        let bonds = before.iter().filter(|p| p.home == Home::Bond);
        bonds
            .map(|p| stored_components(p.shape, self.dim) as u32)
            .sum()
    }

    fn definition(&mut self, d: usize, reading: Reading) -> Value {
        if let Some(v) = self.defs.get(&(d as u32, reading)) {
            return v.clone();
        }
        let law = self.law;
        let def = &law.defs[d];
        let value = self.value(def.expr, reading);
        let longest = |algebra: &Algebra, p: &Poly| match (def.home, reading) {
            (Home::Constant, _) => 1,
            // An inverse shape tensor, an extension under a given gradient: nothing to derive in it,
            // and long or inexact when multiplied out.
            _ if algebra.nature_of(p).rate < Rate::Step => 1,
            (_, Reading::Whole) if def.span.prelude => usize::MAX,
            (_, Reading::Whole) => 1,
            (_, Reading::Split) => LONG,
        };
        let value = self.name_parts(d, value, longest);
        self.defs.insert((d as u32, reading), value.clone());
        value
    }

    /// The components of a definition, with names of their own where they have more terms than `longest`. Those that are
    /// the same share one, so that a symmetric tensor is stored by halves.
    pub fn name_parts(
        &mut self,
        def: usize,
        parts: Vec<Poly>,
        longest: impl Fn(&Algebra, &Poly) -> usize,
    ) -> Value {
        let def = &self.law.defs[def];
        let mut known: HashMap<Poly, Poly> = HashMap::new();
        let mut named = Vec::new();
        for (k, p) in parts.into_iter().enumerate() {
            let keep = p.0.len() > longest(self.algebra, &p);
            named.push(match known.get(&p) {
                Some(same) => same.clone(),
                None if keep => {
                    let name = format!("{}{}", def.name, component_name(def.shape, self.dim, k));
                    let named = self.algebra.poly(Atom::Named(name, p.clone()));
                    known.insert(p, named.clone());
                    named
                }
                None => p,
            });
        }
        named
    }

    /// Component by component, of the arms for flavours of this dimension.
    fn case(&mut self, arms: &[ExprId; 5], reading: Reading) -> Value {
        let mut values = Vec::new();
        for (k, flavour) in Flavour::ALL.iter().enumerate() {
            if flavour.dim() == self.dim {
                values.push((k, self.value(arms[k], reading)));
            }
        }
        let n = values.first().map_or(0, |(_, v)| v.len());
        (0..n).map(|c| self.alternatives(&values, c)).collect()
    }

    /// One polynomial where all arms agree; one for each flavour, which are constants; or a sum of the arms, each
    /// times 1 in its flavour and 0 in the others.
    fn alternatives(&mut self, values: &[(usize, Value)], c: usize) -> Poly {
        let first = &values[0].1[c];
        if values.iter().all(|(_, v)| v[c] == *first) {
            return first.clone();
        }
        let mut constants = vec![Poly::zero(); Flavour::ALL.len()];
        let constant = |p: &Poly| self.algebra.nature_of(p).home == Home::Constant;
        if values.iter().all(|(_, v)| constant(&v[c])) {
            for (k, v) in values {
                constants[*k] = v[c].clone();
            }
            return self.algebra.poly(Atom::Case(constants));
        }
        let mut sum = Poly::zero();
        for (k, v) in values {
            let mut chosen = constants.clone();
            chosen[*k] = Poly::int(1);
            let chosen = self.algebra.poly(Atom::Case(chosen));
            let term = self.algebra.mul(&chosen, &v[c]);
            sum = self.algebra.add(&sum, &term);
        }
        sum
    }

    fn binary(&mut self, op: BinaryOp, a: ExprId, b: ExprId, reading: Reading) -> Value {
        let (sa, sb) = (
            self.law.exprs[a.index()].shape,
            self.law.exprs[b.index()].shape,
        );
        let (u, v) = (self.value(a, reading), self.value(b, reading));
        match op {
            BinaryOp::Add => u.iter().zip(&v).map(|(p, q)| self.add(p, q)).collect(),
            BinaryOp::Sub => u
                .iter()
                .zip(&v)
                .map(|(p, q)| self.algebra.sub(p, q))
                .collect(),
            BinaryOp::Mul => self.product(sa, &u, sb, &v),
            BinaryOp::Div => {
                let r = self.algebra.recip(&v[0]);
                u.iter().map(|p| self.algebra.mul(p, &r)).collect()
            }
            BinaryOp::Pow => vec![self.algebra.pow(&u[0], &v[0])],
            BinaryOp::And => vec![
                self.algebra
                    .func(Func::And, vec![u[0].clone(), v[0].clone()]),
            ],
            BinaryOp::Or => vec![
                self.algebra
                    .func(Func::Or, vec![u[0].clone(), v[0].clone()]),
            ],
        }
    }

    /// xi + eta is kept as the one atom Y.
    fn add(&mut self, p: &Poly, q: &Poly) -> Poly {
        let sum = self.algebra.add(p, q);
        for a in 0..self.dim as u8 {
            let xi = self.algebra.poly(Atom::Xi(a));
            let eta = self.algebra.poly(Atom::Eta(a));
            if sum == self.algebra.add(&xi, &eta) {
                return self.algebra.poly(Atom::Y(a));
            }
        }
        sum
    }

    fn product(&mut self, sa: Shape, u: &[Poly], sb: Shape, v: &[Poly]) -> Value {
        let tensor = |s| matches!(s, Shape::Tensor | Shape::Symmetric);
        match (sa, sb) {
            (Shape::Scalar, _) => v.iter().map(|q| self.algebra.mul(&u[0], q)).collect(),
            (_, Shape::Scalar) => u.iter().map(|p| self.algebra.mul(p, &v[0])).collect(),
            (_, Shape::Vector) => (0..self.dim).map(|r| self.row(u, r, v, 1, 0)).collect(),
            _ if tensor(sa) && tensor(sb) => (0..self.dim * self.dim)
                .map(|k| self.row(u, k / self.dim, v, self.dim, k % self.dim))
                .collect(),
            _ => Vec::new(),
        }
    }

    /// Row r of u times column c of v, v having `width` columns.
    fn row(&mut self, u: &[Poly], r: usize, v: &[Poly], width: usize, c: usize) -> Poly {
        let mut sum = Poly::zero();
        for k in 0..self.dim {
            let t = self.algebra.mul(&u[r * self.dim + k], &v[k * width + c]);
            sum = self.algebra.add(&sum, &t);
        }
        sum
    }

    fn compare(&mut self, op: CompareOp, a: ExprId, b: ExprId, reading: Reading) -> Value {
        let (a, b) = (
            self.value(a, reading).remove(0),
            self.value(b, reading).remove(0),
        );
        let (f, args) = match op {
            CompareOp::Lt => (Func::Lt, vec![a, b]),
            CompareOp::Le => (Func::Le, vec![a, b]),
            CompareOp::Gt => (Func::Lt, vec![b, a]),
            CompareOp::Ge => (Func::Le, vec![b, a]),
        };
        vec![self.algebra.func(f, args)]
    }

    fn vector(&mut self, parts: &[ExprId], reading: Reading) -> Value {
        let given = parts.iter().take(self.dim);
        let mut v: Value = given
            .map(|part| self.value(*part, reading).remove(0))
            .collect();
        v.resize(self.dim, Poly::zero());
        v
    }

    fn component(&mut self, a: ExprId, axes: &[u8], reading: Reading) -> Value {
        let v = self.value(a, reading);
        let k = axes.iter().fold(0, |k, a| k * self.dim + *a as usize);
        let inside = axes.iter().all(|a| (*a as usize) < self.dim);
        // A component that the scene's dimension does not have is 0: no displacement, no strain there.
        vec![if inside { v[k].clone() } else { Poly::zero() }]
    }

    fn call(&mut self, f: Builtin, args: &[ExprId], reading: Reading) -> Value {
        let v: Vec<Value> = args.iter().map(|a| self.value(*a, reading)).collect();
        let scalars = || v.iter().map(|v| v[0].clone()).collect::<Vec<_>>();
        let simple = |s: &mut Self, f| vec![s.algebra.func(f, scalars())];
        match f {
            Builtin::Norm => vec![self.norm(&v[0])],
            Builtin::Dot => vec![self.dot(&v[0], &v[1])],
            Builtin::Outer => self.outer(&v[0], &v[1]),
            Builtin::Trace => vec![self.trace(&v[0])],
            Builtin::Transpose => self.transpose(&v[0]),
            Builtin::Diag => self.diagonal(&v[0], self.law.exprs[args[0].index()].shape),
            Builtin::Sym => self.sym(&v[0]),
            Builtin::Dev => self.dev(&v[0]),
            Builtin::Det => vec![self.det(&v[0])],
            Builtin::Inverse => self.inverse(&v[0]),
            Builtin::Sqrt => vec![self.algebra.sqrt(&v[0][0])],
            Builtin::Abs => simple(self, Func::Abs),
            Builtin::Exp => simple(self, Func::Exp),
            Builtin::Ln => simple(self, Func::Ln),
            Builtin::Sin => simple(self, Func::Sin),
            Builtin::Cos => simple(self, Func::Cos),
            Builtin::Tan => simple(self, Func::Tan),
            Builtin::Min => simple(self, Func::Min),
            Builtin::Max => simple(self, Func::Max),
            Builtin::Select => simple(self, Func::Select),
        }
    }

    /// Means and counts are sums; the least value is minus the largest of the opposite.
    fn reduction(&mut self, r: Reduction, family: FamilyId, body: &Poly, reading: Reading) -> Poly {
        match r {
            Reduction::Sum | Reduction::Sum0 => self.reduce(r, family, body, reading),
            Reduction::Mean => {
                let total = self.reduce(Reduction::Sum, family, body, reading);
                let volume = self.reduce(Reduction::Sum, family, &Poly::int(1), reading);
                let inverse = self.algebra.recip(&volume);
                self.algebra.mul(&total, &inverse)
            }
            Reduction::Count => {
                let (one, zero) = (Poly::int(1), Poly::zero());
                let counts = self
                    .algebra
                    .func(Func::Select, vec![body.clone(), one, zero]);
                let weight = self.algebra.intern(Atom::Weight);
                let each = self.algebra.mul(&counts, &Poly::power(weight, -1));
                self.reduce(Reduction::Sum, family, &each, reading)
            }
            Reduction::Max => self.algebra.poly(Atom::Sum(r, family, body.clone())),
            Reduction::Min => {
                let opposite = Atom::Sum(Reduction::Max, family, body.neg());
                self.algebra.poly(opposite).neg()
            }
        }
    }

    /// A reduction of a bond polynomial; node factors come out of single terms, and of every term when split.
    pub fn reduce(
        &mut self,
        r: Reduction,
        family: FamilyId,
        body: &Poly,
        reading: Reading,
    ) -> Poly {
        if body.is_zero() {
            return Poly::zero();
        }
        if reading == Reading::Whole && body.0.len() > 1 {
            return self.algebra.poly(Atom::Sum(r, family, body.clone()));
        }
        let mut out = Collector::default();
        for (m, c) in &body.0 {
            let (mut node, mut bond) = self.algebra.split_homes(m);
            if reading == Reading::Whole {
                // Inside of a sum a constant is that of the bond, and stays there.
                let (constants, others) = self.algebra.split_constants(&node);
                (node, bond) = (others, bond.mul(&constants));
            }
            let sum = self
                .algebra
                .intern(Atom::Sum(r, family, Poly(vec![(bond, Ratio::ONE)])));
            out.term(node.mul(&Monomial(vec![(sum, 1)])), *c);
        }
        out.finish(self.algebra)
    }

    fn ball(&mut self, body: &Poly) -> Poly {
        let mut out = Collector::default();
        for (m, c) in &body.0 {
            let (constant, bond) = self.algebra.split_homes(m);
            let ball = self
                .algebra
                .intern(Atom::Ball(Poly(vec![(bond, Ratio::ONE)])));
            out.term(constant.mul(&Monomial(vec![(ball, 1)])), *c);
        }
        out.finish(self.algebra)
    }
}

impl Algebra {
    /// Splits a monomial into what does not depend on the bond and what does.
    pub fn split_homes(&self, m: &Monomial) -> (Monomial, Monomial) {
        let (bond, node) =
            m.0.iter()
                .partition(|(a, _)| self.nature(*a).home == Home::Bond);
        (Monomial(node), Monomial(bond))
    }
}
