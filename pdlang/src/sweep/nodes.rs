//! Values of a node, in the prologue or in the epilogue: from slots, constants and what was summed.

use std::collections::{BTreeMap, BTreeSet};

use super::{Factor, SweepWriter, function, position};
use crate::ir::Home;
use crate::poly::{Atom, AtomId, Monomial, Poly};
use crate::ratio::Ratio;
use crate::schedule::closure;
use crate::tape::{Builder, Op, Product, horner};

impl SweepWriter<'_> {
    /// Value of a node polynomial from slots alone.
    pub(super) fn prologue_value(&mut self, p: &Poly) -> u32 {
        self.node_value(p, false)
    }

    pub(super) fn epilogue_of(&mut self, q: &Poly) -> u32 {
        // A stored quantity is its own content here, not a slot.
        match q.as_atom() {
            Some(id) if !self.accumulators.contains_key(&id) => self.formed(id, true),
            _ => self.node_value(q, true),
        }
    }

    fn node_value(&mut self, p: &Poly, post: bool) -> u32 {
        let products = self.node_products(p);
        let mut b = std::mem::take(if post { &mut self.post } else { &mut self.pre });
        let r = horner(&mut b, &products, &mut |b, f| {
            std::mem::swap(b, if post { &mut self.post } else { &mut self.pre });
            let r = self.node_factor(f, post);
            std::mem::swap(b, if post { &mut self.post } else { &mut self.pre });
            r
        });
        *(if post { &mut self.post } else { &mut self.pre }) = b;
        r
    }

    /// Terms with equal node factors share one constant coefficient.
    fn node_products(&mut self, p: &Poly) -> Vec<Product<Factor>> {
        let mut groups: BTreeMap<Monomial, Poly> = BTreeMap::new();
        for (m, c) in &p.0 {
            let constant = |a: &AtomId| {
                self.algebra.nature(*a).home == Home::Constant && !self.algebra.is_truth(*a)
            };
            let (k, node): (Vec<_>, Vec<_>) = m.0.iter().partition(|(a, _)| constant(a));
            let group = groups.entry(Monomial(node)).or_default();
            *group = self.algebra.add(group, &Poly(vec![(Monomial(k), *c)]));
        }
        let mut products = Vec::new();
        for (m, constant) in groups {
            let mut factors: BTreeMap<Factor, u32> = BTreeMap::new();
            for (a, n) in m.0 {
                let f = if n > 0 {
                    Factor::Atom(a)
                } else {
                    Factor::Inverse(a)
                };
                factors.insert(f, n.unsigned_abs());
            }
            let coefficient = constant.as_ratio().unwrap_or_else(|| {
                factors.insert(Factor::Constant(constant), 1);
                Ratio::ONE
            });
            products.push(Product {
                coefficient,
                factors,
            });
        }
        products
    }

    fn node_factor(&mut self, f: &Factor, post: bool) -> u32 {
        match f {
            Factor::Constant(p) => {
                let k = self.constants.index(self.algebra, p);
                self.hand_on(Op::Const(k), post)
            }
            Factor::Atom(a) => self.node_atom(*a, post),
            Factor::Inverse(a) => {
                let r = self.node_atom(*a, post);
                self.site(post).recip(r, true)
            }
            _ => self.site(post).lit(0.0),
        }
    }

    fn site(&mut self, post: bool) -> &mut Builder {
        if post { &mut self.post } else { &mut self.pre }
    }

    /// A prologue operation, seen from the prologue or from the epilogue.
    fn hand_on(&mut self, op: Op, post: bool) -> u32 {
        let r = self.pre.op(op);
        if !post {
            return r;
        }
        let k = self.pre.out(r);
        self.post.op(Op::Pre(k))
    }

    fn node_atom(&mut self, id: AtomId, post: bool) -> u32 {
        if let Some(k) = self.accumulators.get(&id).filter(|_| post) {
            let r = self.post.op(Op::Acc(*k));
            if !self.is_extreme(id) {
                return r;
            }
            // It starts at -inf and stays there without bonds.
            let (top, zero) = (self.post.lit(f64::INFINITY), self.post.lit(0.0));
            let bottom = self.post.op(Op::Neg(top));
            let found = self.post.op(Op::Lt(bottom, r));
            return self.post.op(Op::Select(found, r, zero));
        }
        let mut needed = BTreeSet::new();
        closure(self.algebra, &Poly::atom(id), &mut needed);
        let fresh = needed.iter().any(|s| self.accumulators.contains_key(s));
        let formed_here = post && (fresh || self.writes.contains(&id));
        // State is read where it is, also by what stores a copy of it.
        let state = matches!(self.algebra.atom(id), Atom::State(..));
        if !formed_here
            && !state
            && let Some(slot) = self
                .schedule
                .find(&Poly::atom(id), self.stage)
                .map(|q| q.slot)
        {
            let k = position(&mut self.own, slot);
            return self.hand_on(Op::Own(k), post);
        }
        self.formed(id, post)
    }

    /// A node atom from what it is made of.
    fn formed(&mut self, id: AtomId, post: bool) -> u32 {
        match self.algebra.atom(id).clone() {
            Atom::State(..) => {
                let slot = self.schedule.state_slot(self.algebra, id);
                let k = position(&mut self.own, slot);
                self.hand_on(Op::Own(k), post)
            }
            Atom::Named(_, p) => self.node_value(&p, post),
            Atom::Func(f, args) => {
                let args: Vec<u32> = args.iter().map(|p| self.node_value(p, post)).collect();
                function(self.site(post), f, &args, true)
            }
            _ => self.site(post).lit(0.0),
        }
    }
}
