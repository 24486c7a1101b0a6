//! What is known before anything moves: constants of the law, and tables over reference bonds.

use std::collections::BTreeMap;

use crate::ir::Home;
use crate::poly::{Algebra, Atom, AtomId, Monomial, Poly};
use crate::ratio::Ratio;
use crate::sweep::function;
use crate::tape::{Builder, Op, Product, horner};

#[derive(Default)]
pub struct Constants {
    pub builder: Builder,
    known: BTreeMap<Poly, u32>,
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Factor {
    Atom(AtomId),
    Inverse(AtomId),
    Constant(Poly),
}

impl Constants {
    /// Position of a constant polynomial among the law's constants.
    pub fn index(&mut self, algebra: &mut Algebra, p: &Poly) -> u32 {
        if let Some(k) = self.known.get(p) {
            return *k;
        }
        let mut b = std::mem::take(&mut self.builder);
        let r = value(algebra, &mut b, p);
        let k = b.out(r);
        self.builder = b;
        self.known.insert(p.clone(), k);
        k
    }

    /// Value of a reference-bond polynomial in a geometry tape.
    pub fn geometry(&mut self, algebra: &mut Algebra, b: &mut Builder, p: &Poly) -> u32 {
        let mut groups: BTreeMap<Monomial, Poly> = BTreeMap::new();
        for (m, c) in &p.0 {
            let constant = |a: &AtomId| algebra.nature(*a).home == Home::Constant;
            let (k, bond): (Vec<_>, Vec<_>) = m.0.iter().partition(|(a, _)| constant(a));
            let group = groups.entry(Monomial(bond)).or_default();
            *group = algebra.add(group, &Poly(vec![(Monomial(k), *c)]));
        }
        let mut products = Vec::new();
        for (m, constant) in groups {
            let mut factors = powers(&m);
            let coefficient = constant.as_ratio().unwrap_or_else(|| {
                factors.insert(Factor::Constant(constant), 1);
                Ratio::ONE
            });
            products.push(Product {
                coefficient,
                factors,
            });
        }
        horner(b, &products, &mut |b, f| match f {
            Factor::Constant(p) => {
                let k = self.index(algebra, p);
                b.op(Op::Const(k))
            }
            Factor::Atom(a) => self.geometry_atom(algebra, b, *a),
            Factor::Inverse(a) => {
                let r = self.geometry_atom(algebra, b, *a);
                b.recip(r, false)
            }
        })
    }

    fn geometry_atom(&mut self, algebra: &mut Algebra, b: &mut Builder, id: AtomId) -> u32 {
        match algebra.atom(id).clone() {
            Atom::X => b.op(Op::X),
            Atom::Xi(a) => b.op(Op::Xi(a)),
            Atom::Omega(k) => b.op(Op::Omega(k)),
            Atom::Weight => b.op(Op::Weight),
            Atom::Named(_, p) => self.geometry(algebra, b, &p),
            Atom::Func(f, args) => {
                let r: Vec<u32> = args.iter().map(|p| self.geometry(algebra, b, p)).collect();
                function(b, f, &r, false)
            }
            _ => b.lit(0.0),
        }
    }
}

fn powers(m: &Monomial) -> BTreeMap<Factor, u32> {
    let factor = |a: AtomId, n: i32| {
        if n > 0 {
            Factor::Atom(a)
        } else {
            Factor::Inverse(a)
        }
    };
    m.0.iter()
        .map(|(a, n)| (factor(*a, *n), n.unsigned_abs()))
        .collect()
}

/// Value of a polynomial in constants; in an integrand also of the reference bond length.
pub fn value(algebra: &Algebra, b: &mut Builder, p: &Poly) -> u32 {
    let products: Vec<Product<Factor>> =
        p.0.iter()
            .map(|(m, c)| Product {
                coefficient: *c,
                factors: powers(m),
            })
            .collect();
    horner(b, &products, &mut |b, f| match f {
        Factor::Inverse(a) => {
            let r = atom(algebra, b, *a);
            b.recip(r, false)
        }
        Factor::Atom(a) => atom(algebra, b, *a),
        Factor::Constant(p) => value(algebra, b, p),
    })
}

fn atom(algebra: &Algebra, b: &mut Builder, id: AtomId) -> u32 {
    match algebra.atom(id) {
        Atom::Number(bits) => b.lit(f64::from_bits(*bits)),
        Atom::Param(k) => b.op(Op::Param(*k)),
        Atom::Var(k) => b.op(Op::Var(*k)),
        Atom::Delta => b.op(Op::Delta),
        Atom::X => b.op(Op::X),
        Atom::Omega(k) => b.op(Op::Omega(*k)),
        Atom::Xi(a) => b.op(Op::Xi(*a)),
        Atom::Case(arms) => {
            let mut r = [0; 5];
            for (r, arm) in r.iter_mut().zip(arms) {
                *r = value(algebra, b, arm);
            }
            b.op(Op::Case(r))
        }
        Atom::Ball(body) => {
            let mut inner = Builder::default();
            let r = value(algebra, &mut inner, body);
            inner.out(r);
            b.op(Op::Ball(Box::new(inner.tape)))
        }
        Atom::Named(_, p) => value(algebra, b, p),
        Atom::Func(f, args) => {
            let r: Vec<u32> = args.iter().map(|p| value(algebra, b, p)).collect();
            function(b, *f, &r, false)
        }
        _ => b.lit(0.0),
    }
}
