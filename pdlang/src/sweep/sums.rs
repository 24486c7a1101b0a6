//! What a bond adds to the sums of its node.
//!
//! Contract. One addition per bond and sum, so that blocks of bonds add in the order of the bonds. Components of a vector along Y,
//! xi or eta share their factor; geometry times a factor that several sums have is formed once.

use std::collections::{BTreeMap, BTreeSet};

use super::{Direction, Factor, SweepWriter, by_geometry};
use crate::plan::Term;
use crate::poly::{Atom, AtomId, Monomial, Poly};
use crate::ratio::Ratio;
use crate::tape::Op;

impl SweepWriter<'_> {
    pub(super) fn sums(&mut self, sums: &[AtomId], vectors: &[Vec<AtomId>]) {
        let mut left: BTreeSet<AtomId> = sums.iter().copied().collect();
        for v in vectors {
            if v.iter().all(|s| left.contains(s)) {
                let bodies: Vec<Poly> = v.iter().map(|s| self.weighted(*s)).collect();
                if let Some(along) = self.directed(&bodies) {
                    left.retain(|s| !v.contains(s));
                    self.add_along(v, &along);
                }
            }
        }
        let mut pairs = Vec::new();
        for sum in left {
            let body = self.weighted(sum);
            let k = self.accumulator(sum);
            if self.is_extreme(sum) {
                let r = self.bond_value(&body);
                self.bond.effect(Op::MaxTo(k, r));
                continue;
            }
            let groups = by_geometry(self.algebra.plan(&body));
            if let Some((geo, a, b)) = self.pair(&groups) {
                pairs.push((k, geo, a, b));
                continue;
            }
            // One addition per bond, so that blocks of bonds add in the order of the bonds.
            let (a, b) = match groups.first_key_value() {
                Some((geo, terms)) if groups.len() == 1 => {
                    let inner = self.inner(terms);
                    (self.geometry_value(geo.as_ref()), inner)
                }
                _ => (self.bond_value(&body), self.bond.lit(1.0)),
            };
            self.bond.effect(Op::AddTo(k, a, b));
        }
        self.add_pairs(pairs);
    }

    /// A value of geometry times two factors.
    fn pair(
        &mut self,
        groups: &BTreeMap<Option<Poly>, Vec<Term>>,
    ) -> Option<(Poly, Factor, Factor)> {
        let (Some(geo), terms) = groups.first_key_value()? else {
            return None;
        };
        let [term] = terms.as_slice() else {
            return None;
        };
        let product = self.product(term);
        let mut factors = product.factors.into_iter();
        match (factors.next()?, factors.next()?, factors.next()) {
            ((a, 1), (b, 1), None) if groups.len() == 1 && product.coefficient.is_one() => {
                Some((geo.clone(), a, b))
            }
            _ => None,
        }
    }

    /// Adds geometry times two factors to sums: geometry times the factor that most of them share is formed once.
    fn add_pairs(&mut self, mut pairs: Vec<(u32, Poly, Factor, Factor)>) {
        loop {
            let mut shared: BTreeMap<(Poly, Factor), u32> = BTreeMap::new();
            for (_, geo, a, b) in &pairs {
                *shared.entry((geo.clone(), a.clone())).or_default() += 1;
                *shared.entry((geo.clone(), b.clone())).or_default() += 1;
            }
            let most = shared.values().copied().max().unwrap_or(0);
            let Some(((geo, factor), _)) = shared.into_iter().find(|(_, n)| *n == most && most > 1)
            else {
                break;
            };
            let (value, r) = (self.geometry_value(Some(&geo)), self.bond_factor(&factor));
            let product = self.bond.op(Op::Mul(value, r));
            let of =
                |p: &(u32, Poly, Factor, Factor)| p.1 == geo && (p.2 == factor || p.3 == factor);
            let (with, without) = pairs.into_iter().partition(of);
            pairs = without;
            for (k, _, a, b) in with {
                let other = self.bond_factor(if a == factor { &b } else { &a });
                self.bond.effect(Op::AddTo(k, product, other));
            }
        }
        for (k, geo, a, b) in pairs {
            let (a, b) = (self.bond_factor(&a), self.bond_factor(&b));
            let product = self.bond.op(Op::Mul(a, b));
            let value = self.geometry_value(Some(&geo));
            self.bond.effect(Op::AddTo(k, value, product));
        }
    }

    pub(super) fn is_extreme(&self, sum: AtomId) -> bool {
        matches!(self.algebra.atom(sum), Atom::Sum(r, _, _) if r.is_extreme())
    }

    fn accumulator(&mut self, sum: AtomId) -> u32 {
        let next = self.accumulators.len() as u32;
        *self.accumulators.entry(sum).or_insert(next)
    }

    fn weighted(&mut self, sum: AtomId) -> Poly {
        let Atom::Sum(reduction, _, body) = self.algebra.atom(sum).clone() else {
            return Poly::zero();
        };
        self.algebra.weighted(reduction, &body)
    }

    /// What components have in common: their factor of every direction, if each term is along one.
    fn directed(&mut self, bodies: &[Poly]) -> Option<Vec<(Direction, Poly)>> {
        let mut left = bodies.to_vec();
        let mut along = Vec::new();
        for direction in [Atom::Y, Atom::Xi, Atom::Eta] as [Direction; 3] {
            let mut common: Option<Poly> = None;
            for (a, body) in left.iter_mut().enumerate() {
                let axis = self.algebra.intern(direction(a as u8));
                let (with, without) = body.0.drain(..).partition(|(m, _)| m.degree(axis) == 1);
                body.0 = without;
                let factor = |(m, c): &(Monomial, Ratio)| (m.without(axis), *c);
                let with: &Vec<(Monomial, Ratio)> = &with;
                let mut phi = Poly(with.iter().map(factor).collect());
                phi.0.sort();
                if common.get_or_insert_with(|| phi.clone()) != &phi {
                    return None;
                }
            }
            along.extend(common.filter(|p| !p.is_zero()).map(|p| (direction, p)));
        }
        let all = left.iter().all(Poly::is_zero);
        (all && !along.is_empty()).then_some(along)
    }

    fn add_along(&mut self, sums: &[AtomId], along: &[(Direction, Poly)]) {
        let phis: Vec<u32> = along.iter().map(|(_, phi)| self.bond_value(phi)).collect();
        for (a, sum) in sums.iter().enumerate() {
            let k = self.accumulator(*sum);
            let axis = |w: &mut Self, direction: Direction| {
                let axis = w.algebra.intern(direction(a as u8));
                w.bond_atom(axis)
            };
            let first = axis(self, along[0].0);
            if phis.len() == 1 {
                self.bond.effect(Op::AddTo(k, phis[0], first));
                continue;
            }
            let mut value = self.bond.op(Op::Mul(phis[0], first));
            for (phi, (direction, _)) in phis.iter().zip(along).skip(1) {
                let axis = axis(self, *direction);
                value = self.bond.op(Op::Fma(*phi, axis, value));
            }
            let one = self.bond.lit(1.0);
            self.bond.effect(Op::AddTo(k, value, one));
        }
    }
}
