//! A bond polynomial arranged for a kernel: which factor is known when.
//!
//! Contract. Every term is `coefficient * geo * own * nbr * step`: `geo` depends on the reference bond and
//! on constants only and is tabulated; `own` and `nbr` are node quantities, computed once per node by an
//! earlier sweep and read here at this node and at the other end; `step` is what the bond body computes.
//! Terms that share a step factor share their node quantities, so that a law that divides by the weighted
//! volume per bond on paper does so once per node here.

use std::collections::{BTreeMap, BTreeSet};

use crate::ir::Home;
use crate::poly::{Algebra, Atom, AtomId, Collector, Func, Monomial, Poly, Rate};
use crate::ratio::Ratio;

#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    pub coefficient: Ratio,
    pub geo: Option<Poly>,
    pub own: Option<Poly>,
    pub nbr: Option<Poly>,
    pub step: Monomial,
}

#[derive(Default)]
struct Parts {
    constant: Monomial,
    geometry: Monomial,
    own: Monomial,
    nbr: Monomial,
    step: Monomial,
}

enum Place {
    Constant,
    Geometry,
    Own,
    Nbr(AtomId),
    Step,
}

impl Algebra {
    fn place(&self, id: AtomId) -> Place {
        let nature = self.nature(id);
        match self.atom(id) {
            _ if self.is_truth(id) => Place::Step,
            _ if nature.home == Home::Constant => Place::Constant,
            Atom::Prime(a) if self.nature(*a).sums || self.is_dear(*a) => Place::Nbr(*a),
            _ if nature.home == Home::Node && nature.sums => Place::Own,
            Atom::Xi(_) => Place::Step,
            _ if self.is_geometry(id) => Place::Geometry,
            _ => Place::Step,
        }
    }

    /// The same bond polynomial with node quantities taken out of definitions on bonds: `a b + c (eta - H xi)` reads a, b,
    /// c and H at both ends, `(a b - c H) xi + c eta` two products that were formed at the node.
    /// A definition that would make it long stays whole.
    pub fn gathered(&mut self, p: &Poly) -> Poly {
        const LONG: usize = 64;
        let mut whole = p.clone();
        let mut closed = BTreeSet::new();
        loop {
            let atoms = whole.0.iter().flat_map(|(m, _)| &m.0);
            let open = atoms.filter(|(a, n)| *n == 1 && !closed.contains(a));
            let found = open.map(|(a, _)| *a).find_map(|a| match self.atom(a) {
                Atom::Named(_, inner) if self.mixes(inner) => Some((a, inner.clone())),
                _ => None,
            });
            let Some((a, inner)) = found else {
                return whole;
            };
            let holders = whole.0.iter().filter(|(m, _)| m.degree(a) == 1).count();
            if whole.0.len() + holders * (inner.0.len() - 1) > LONG {
                closed.insert(a);
                continue;
            }
            let mut sum = Collector::default();
            for (m, c) in whole.0 {
                let opened = match m.degree(a) {
                    1 => self.mul(&Poly(vec![(m.without(a), c)]), &inner),
                    _ => Poly(vec![(m, c)]),
                };
                opened.0.into_iter().for_each(|(m, c)| sum.term(m, c));
            }
            whole = sum.finish(self);
        }
    }

    /// Several terms, of which some have node quantities as factors.
    fn mixes(&self, p: &Poly) -> bool {
        let of_node = |(a, _): &(AtomId, i32)| matches!(self.place(*a), Place::Own | Place::Nbr(_));
        let mixed = self.nature_of(p).home == Home::Bond;
        mixed && p.0.len() > 1 && p.0.iter().any(|(m, _)| m.0.iter().any(of_node))
    }

    /// True for a function that costs a node more than to read its value at the other end of a bond.
    fn is_dear(&self, id: AtomId) -> bool {
        use Func::{Cos, Exp, Ln, Pow, Sin, Tan};
        matches!(
            self.atom(id),
            Atom::Func(Exp | Ln | Sin | Cos | Tan | Pow, _)
        )
    }

    /// True for what a table over reference bonds can hold.
    pub fn is_geometry(&self, id: AtomId) -> bool {
        if self.nature(id).rate != Rate::Reference || self.nature(id).sums {
            return false;
        }
        let inside = |p: &Poly| {
            p.0.iter()
                .all(|(m, _)| m.0.iter().all(|(a, _)| self.is_geometry(*a)))
        };
        match self.atom(id) {
            Atom::X | Atom::Xi(_) | Atom::Omega(_) | Atom::Weight => true,
            Atom::Named(_, p) => inside(p),
            Atom::Func(_, args) => args.iter().all(inside),
            _ => self.nature(id).home == Home::Constant,
        }
    }

    fn parts(&mut self, m: &Monomial) -> Parts {
        let mut parts = Parts::default();
        let one = |id, n| Monomial(vec![(id, n)]);
        let m = self.with_slack(m);
        for (id, n) in &m.0 {
            let (target, factor) = match self.place(*id) {
                Place::Constant => (&mut parts.constant, one(*id, *n)),
                Place::Geometry => (&mut parts.geometry, one(*id, *n)),
                Place::Own => (&mut parts.own, one(*id, *n)),
                Place::Nbr(a) => (&mut parts.nbr, one(a, *n)),
                Place::Step => (&mut parts.step, one(*id, *n)),
            };
            *target = target.mul(&factor);
        }
        parts
    }

    /// e^a |Y|^-b = |xi|^a slack^a |Y|^(a-b): no root but the reciprocal one, and no cancellation.
    fn with_slack(&mut self, m: &Monomial) -> Monomial {
        let extension = self.intern(Atom::Extension);
        let inverse = self.intern(Atom::InverseY);
        let (a, b) = (m.degree(extension), m.degree(inverse));
        if a <= 0 && b == 0 {
            return m.clone();
        }
        let (x, slack, length) = (
            self.intern(Atom::X),
            self.intern(Atom::Slack),
            self.intern(Atom::Length),
        );
        let mut out = m.without(extension).without(inverse);
        for (atom, n) in [(x, a), (slack, a), (length, a - b)] {
            if n != 0 {
                out = out.mul(&Monomial(vec![(atom, n)]));
            }
        }
        out
    }

    /// Arranges a bond polynomial.
    pub fn plan(&mut self, p: &Poly) -> Vec<Term> {
        let mut plain: BTreeMap<Monomial, Collector> = BTreeMap::new();
        let mut nodes: BTreeMap<(Monomial, Monomial), [Collector; 2]> = BTreeMap::new();
        let mut mixed: BTreeMap<(Monomial, Monomial, Monomial), Collector> = BTreeMap::new();
        for (m, c) in &p.0 {
            let s = self.parts(m);
            match (s.own.0.is_empty(), s.nbr.0.is_empty()) {
                (true, true) => plain
                    .entry(s.step)
                    .or_default()
                    .term(s.constant.mul(&s.geometry), *c),
                (false, true) => {
                    nodes.entry((s.step, s.geometry)).or_default()[0]
                        .term(s.constant.mul(&s.own), *c);
                }
                (true, false) => {
                    nodes.entry((s.step, s.geometry)).or_default()[1]
                        .term(s.constant.mul(&s.nbr), *c);
                }
                (false, false) => mixed
                    .entry((s.step, s.geometry, s.nbr))
                    .or_default()
                    .term(s.constant.mul(&s.own), *c),
            }
        }
        let mut terms = Vec::new();
        for (step, geo) in plain {
            let geo = geo.finish(self);
            terms.push(self.term(Ratio::ONE, geo, None, None, step));
        }
        for ((step, geo), [own, nbr]) in nodes {
            let geo = Poly(vec![(geo, Ratio::ONE)]);
            let (own, nbr) = (own.finish(self), nbr.finish(self));
            if !own.is_zero() {
                let (c, own) = signed(&own);
                terms.push(self.term(c, geo.clone(), Some(own), None, step.clone()));
            }
            if !nbr.is_zero() {
                let (c, nbr) = signed(&nbr);
                terms.push(self.term(c, geo, None, Some(nbr), step));
            }
        }
        for ((step, geo, nbr), own) in mixed {
            let (c, own) = signed(&own.finish(self));
            let geo = Poly(vec![(geo, Ratio::ONE)]);
            let nbr = Poly(vec![(nbr, Ratio::ONE)]);
            terms.push(self.term(c, geo, Some(own), Some(nbr), step));
        }
        fold_coefficients(&mut terms);
        terms
    }

    fn term(
        &mut self,
        c: Ratio,
        geo: Poly,
        own: Option<Poly>,
        nbr: Option<Poly>,
        step: Monomial,
    ) -> Term {
        if let Some(r) = geo.as_ratio() {
            let coefficient = r.mul(c).unwrap_or_else(|| self.overflowed());
            return Term {
                coefficient,
                geo: None,
                own,
                nbr,
                step,
            };
        }
        let lead = geo.0[0].1;
        let unit = Ratio::ONE.div(lead).unwrap_or_else(|| self.overflowed());
        let geo = self.scale(&geo, unit);
        let coefficient = lead.mul(c).unwrap_or_else(|| self.overflowed());
        Term {
            coefficient,
            geo: Some(geo),
            own,
            nbr,
            step,
        }
    }

    fn overflowed(&mut self) -> Ratio {
        self.overflow = true;
        Ratio::ONE
    }
}

/// Takes out the sign, or the whole coefficient of a bare atom.
fn signed(p: &Poly) -> (Ratio, Poly) {
    let lead = p.0[0].1;
    if let [(m, c)] = p.0.as_slice()
        && matches!(m.0.as_slice(), [(_, 1)])
    {
        return (*c, Poly(vec![(m.clone(), Ratio::ONE)]));
    }
    if lead.is_negative() {
        (Ratio::int(-1), p.neg())
    } else {
        (Ratio::ONE, p.clone())
    }
}

/// The first term with a given table entry moves its coefficient into the table.
fn fold_coefficients(terms: &mut [Term]) {
    let mut first: BTreeMap<Poly, Ratio> = BTreeMap::new();
    for t in terms.iter_mut() {
        let Some(geo) = &t.geo else { continue };
        let lead = *first.entry(geo.clone()).or_insert(t.coefficient);
        let scaled = geo
            .0
            .iter()
            .map(|(m, c)| Some((m.clone(), c.mul(lead)?)))
            .collect::<Option<_>>();
        if let (Some(rest), Some(scaled)) = (t.coefficient.div(lead), scaled) {
            t.coefficient = rest;
            t.geo = Some(Poly(scaled));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::assemble::{self, Kinematics};
    use crate::front;
    use crate::spec::{Spec, Stage};
    use crate::tape::Op;

    /// Of the force of stabilised correspondence a bond needs B = sigma K^-1 - c H and c of both ends, ten numbers instead
    /// of the nineteen that it names; of its gradient, three products of a weight and a component instead of nine.
    #[test]
    fn node_quantities_are_gathered_and_products_shared() {
        let text = include_str!("../../models/laws/correspondence_stabilised.pd");
        let spec: Spec =
            assemble::spec(&front::file(text).laws[0], 3, Kinematics::General).unwrap();
        let of_step = |s: &&crate::spec::SweepSpec| s.stage == Stage::Step;
        let [gradient, force] = spec.sweeps.iter().filter(of_step).collect::<Vec<_>>()[..] else {
            panic!("two sweeps");
        };
        assert_eq!((force.own.len(), force.nbr.len()), (10, 10));
        let products = |op: &&Op| matches!(op, Op::Mul(a, b) if a != b);
        assert_eq!(gradient.bond.ops.iter().filter(products).count(), 3);
    }

    #[test]
    fn what_would_be_long_stays_whole() {
        let definition = |k: usize| {
            let terms: Vec<String> = (0..9).map(|n| format!("{n}.5*a*x^{n}/delta^{n}")).collect();
            format!("bond b{k} = {}*s + {k}*s", terms.join("*s + "))
        };
        let definitions: Vec<String> = (1..7).map(definition).collect();
        let text = format!(
            "model m \"M\" cite \"N, eq. 1\" {{ param K : pressure > 0 \"k\" node a = mean(s) {} \
             state t = K/ball(x)*b1*b2*b3*b4*b5*b6 }}",
            definitions.join(" ")
        );
        let checked = front::file(&text);
        assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
        let spec = assemble::spec(&checked.laws[0], 3, Kinematics::General).unwrap();
        let longest = spec.sweeps.iter().map(|s| s.bond.ops.len()).max();
        assert!(longest < Some(2000), "{longest:?}");
    }
}
