//! How a rate is stepped: what depends on the field itself, taken apart.
//!
//! Contract. The rate of a field component q is written as `drive - damping*q`. Where neither `drive` nor `damping`
//! reads anything that is unknown during a step from one q to the next, the trapezoidal rule needs no iteration:
//! `q' = ((1 - damping dt/2) q + dt drive)/(1 + damping dt/2)`, stable for any damping that is not negative. Unknown
//! are, to a field at full steps, the fields at full steps that have a rate, and to a field at half steps those at half
//! steps, and the velocity. A damping is found symbolically, in the rate with its definitions opened. Where a field does
//! not live, drive and damping are zero.

use std::collections::HashMap;

use crate::ir::{FieldId, Law, Response};
use crate::linear::Keep;
use crate::lower::{Lowering, Reading, stored_components};
use crate::poly::{Algebra, Atom, AtomId, Collector, Func, Poly, StateKind};
use crate::spec::Stepped;

/// The rate of one field component.
pub struct Rate {
    /// State slot of the component.
    pub slot: u32,
    /// The rate, without the damping where it is stepped alone.
    pub drive: Poly,
    pub damping: Poly,
    pub stepped: Stepped,
}

impl Rate {
    /// The state slot of the damping, where it is a field as it stands: there is nothing to compute.
    pub fn damping_field(&self, algebra: &Algebra) -> Option<u32> {
        match algebra.atom(self.damping.as_atom()?) {
            Atom::State(StateKind::Slot, k) => Some(*k),
            _ => None,
        }
    }
}

/// The rates of a law, in the order of its text. What must be stepped alone and cannot be is stepped with the others.
pub fn rates(lowering: &mut Lowering) -> Vec<Rate> {
    let law = lowering.law;
    let mut rates = Vec::new();
    for response in &law.responses {
        let Response::Rate(field, e) = response else {
            continue;
        };
        let shape = law.fields[field.index()].shape;
        let parts = lowering.stored(*e, shape, Reading::Whole);
        let parts = lowering.small(*e, parts, Reading::Whole, Keep::First);
        let first = lowering.field_slots[field.index()];
        let unknown = unknown(lowering, law.fields[field.index()].half);
        let split: Option<Vec<(Poly, Poly)>> = parts
            .iter()
            .zip(first..)
            .map(|(p, slot)| separate(lowering.algebra, p, slot, &unknown))
            .collect();
        let stepped = match (&split, law.fields[field.index()].half) {
            (None, _) => Stepped::Together,
            (_, true) => Stepped::Half,
            (_, false) => Stepped::Alone,
        };
        let split = split.unwrap_or_else(|| {
            let whole = parts.into_iter();
            whole.map(|p| (p, Poly::zero())).collect()
        });
        let lives = law.fields[field.index()].lives.as_ref();
        let lives = lives.map(|lives| lowering.value(lives.when, Reading::Whole).remove(0));
        for ((drive, damping), slot) in split.into_iter().zip(first..) {
            rates.push(Rate {
                slot,
                drive: where_it_lives(lowering.algebra, lives.as_ref(), drive),
                damping: where_it_lives(lowering.algebra, lives.as_ref(), damping),
                stepped,
            });
        }
    }
    rates
}

/// Zero where the condition does not hold. A field as it stands is left alone: as the damping of what is zero it does
/// nothing.
fn where_it_lives(algebra: &mut Algebra, lives: Option<&Poly>, p: Poly) -> Poly {
    let is_state = |a: AtomId| matches!(algebra.atom(a), Atom::State(..));
    match lives {
        Some(lives) if !p.is_zero() && !p.as_atom().is_some_and(is_state) => {
            algebra.func(Func::Select, vec![lives.clone(), p, Poly::zero()])
        }
        _ => p,
    }
}

/// Fields at half steps whose rate reads what sits at half steps too, other than its own damping.
pub fn unstaggered(law: &Law) -> Vec<FieldId> {
    let half = |f: &FieldId| law.fields[f.index()].half;
    let fields = (0..law.fields.len() as u32).map(FieldId).filter(half);
    let mut found: Vec<FieldId> = fields.collect();
    if found.is_empty() {
        return found;
    }
    let mut bad = Vec::new();
    for dim in (1..=3).filter(|dim| law.flavours.iter().any(|f| f.dim() == *dim)) {
        let mut algebra = Algebra::default();
        let mut lowering = Lowering::new(law, dim, &mut algebra);
        let rates = rates(&mut lowering);
        let whole = rates.iter().filter(|r| r.stepped == Stepped::Together);
        bad.extend(whole.map(|r| r.slot).map(|slot| (dim, slot)));
    }
    let first = |dim: usize, k: usize| -> u32 {
        let before = law.fields[..k].iter();
        before.map(|f| stored_components(f.shape, dim) as u32).sum()
    };
    found.retain(|f| {
        let own = |(dim, slot): &(usize, u32)| {
            (first(*dim, f.index())..first(*dim, f.index() + 1)).contains(slot)
        };
        bad.iter().any(own)
    });
    found
}

/// What must not be read by a rate that is stepped alone.
fn unknown(lowering: &Lowering, half: bool) -> impl Fn(&Atom) -> bool + use<> {
    let law = lowering.law;
    let evolves = |k: usize| {
        let rate = |r: &Response| matches!(r, Response::Rate(f, _) if f.index() == k);
        law.fields[k].half == half && law.responses.iter().any(rate)
    };
    let slots: Vec<u32> = (0..law.fields.len())
        .filter(|k| evolves(*k))
        .flat_map(|k| {
            let count = stored_components(law.fields[k].shape, lowering.dim) as u32;
            let first = lowering.field_slots[k];
            first..first + count
        })
        .collect();
    move |atom| match atom {
        Atom::State(StateKind::Slot, k) => slots.contains(k),
        Atom::State(StateKind::Velocity, _) => half,
        _ => false,
    }
}

/// `p` as drive and damping of the state in `slot`, if neither reads what is unknown.
fn separate(
    algebra: &mut Algebra,
    p: &Poly,
    slot: u32,
    unknown: &dyn Fn(&Atom) -> bool,
) -> Option<(Poly, Poly)> {
    let own = algebra.intern(Atom::State(StateKind::Slot, slot));
    let open = opened(algebra, p, own);
    let (mut drive, mut damping) = (Collector::default(), Collector::default());
    for (m, c) in &open.0 {
        match m.degree(own) {
            1 => damping.term(m.without(own), c.neg()),
            _ => drive.term(m.clone(), *c),
        }
    }
    let (drive, damping) = (drive.finish(algebra), damping.finish(algebra));
    let mut memo = HashMap::new();
    let known = [&drive, &damping]
        .into_iter()
        .all(|p| !reads(algebra, p, unknown, &mut memo));
    known.then_some((drive, damping))
}

/// The polynomial with every definition that reads `target` multiplied out.
fn opened(algebra: &mut Algebra, p: &Poly, target: AtomId) -> Poly {
    let mut sum = Poly::zero();
    for (m, c) in &p.0 {
        let mut term = Poly::constant(*c);
        for (a, n) in &m.0 {
            let factor = match algebra.atom(*a).clone() {
                Atom::Named(_, inner) if reads_atom(algebra, &inner, target) => {
                    opened(algebra, &inner, target)
                }
                _ => Poly::atom(*a),
            };
            let power = algebra.powi(&factor, *n);
            term = algebra.mul(&term, &power);
        }
        sum = algebra.add(&sum, &term);
    }
    sum
}

fn reads_atom(algebra: &Algebra, p: &Poly, target: AtomId) -> bool {
    let target = algebra.atom(target).clone();
    reads(algebra, p, &|atom| *atom == target, &mut HashMap::new())
}

/// Whether an atom that `test` accepts is anywhere in a polynomial, inside of sums and at other ends too.
pub fn reads(
    algebra: &Algebra,
    p: &Poly,
    test: &dyn Fn(&Atom) -> bool,
    memo: &mut HashMap<AtomId, bool>,
) -> bool {
    p.0.iter()
        .flat_map(|(m, _)| &m.0)
        .any(|(a, _)| reads_in(algebra, *a, test, memo))
}

fn reads_in(
    algebra: &Algebra,
    id: AtomId,
    test: &dyn Fn(&Atom) -> bool,
    memo: &mut HashMap<AtomId, bool>,
) -> bool {
    if let Some(known) = memo.get(&id) {
        return *known;
    }
    let atom = algebra.atom(id);
    let found = test(atom)
        || match atom {
            Atom::Named(_, p) | Atom::Sum(_, _, p) => reads(algebra, p, test, memo),
            Atom::Func(_, args) => args.iter().any(|p| reads(algebra, p, test, memo)),
            Atom::Prime(a) => reads_in(algebra, *a, test, memo),
            _ => false,
        };
    memo.insert(id, found);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::tests::bare;
    use crate::front;

    /// How the rates of a law are stepped in 2D, one letter per component, and its dampings.
    fn stepped(items: &str) -> (String, Vec<String>) {
        let checked = front::file(&bare(items));
        assert!(!checked.has_errors(), "{items}\n{:#?}", checked.diagnostics);
        let mut algebra = Algebra::default();
        let mut lowering = Lowering::new(&checked.laws[0], 2, &mut algebra);
        let rates = rates(&mut lowering);
        let letter = |r: &Rate| match r.stepped {
            Stepped::Together => 'T',
            Stepped::Alone => 'A',
            Stepped::Half => 'H',
        };
        let law = &checked.laws[0];
        let name = |(a, n): &(AtomId, i32)| {
            let name = match algebra.atom(*a) {
                Atom::Param(k) => law.params[*k as usize].name.clone(),
                Atom::State(_, k) => format!("state{k}"),
                Atom::Delta => "delta".into(),
                other => format!("{other:?}"),
            };
            if *n == 1 { name } else { format!("{name}^{n}") }
        };
        let product = |(m, c): &(crate::poly::Monomial, crate::ratio::Ratio)| {
            let factors: Vec<String> = m.0.iter().map(name).collect();
            format!("{} {}", c.value(), factors.join(" "))
        };
        let text = |r: &Rate| {
            let terms: Vec<String> = r.damping.0.iter().map(product).collect();
            terms.join(" + ")
        };
        (
            rates.iter().map(letter).collect(),
            rates.iter().map(text).collect(),
        )
    }

    #[test]
    fn a_linear_damping_is_taken_apart() {
        let tau = "param tau : time > 0 \"tau\" field q : number \"q\"";
        let (how, damping) = stepped(&format!("{tau} rate q = sum(s)/(ball(1)*tau) - 2*q/tau"));
        assert_eq!(how, "A");
        assert_eq!(damping, ["2 tau^-1"]);
        // Through definitions, and where nothing is damped at all.
        let (how, damping) = stepped(&format!(
            "{tau} node r = s0 - q node s0 = mean(s) rate q = r/tau"
        ));
        assert_eq!((how.as_str(), damping[0].as_str()), ("A", "1 tau^-1"));
        let (how, damping) = stepped(&format!("{tau} rate q = mean(s)/tau"));
        assert_eq!((how.as_str(), damping[0].as_str()), ("A", ""));
    }

    #[test]
    fn every_component_has_its_own_damping() {
        let fields = "field phi : vector frequency \"phi\" field q : tensor \"q\"";
        let (how, damping) = stepped(&format!(
            "{fields} rate q = outer(X, phi)/delta - q*diag(phi)"
        ));
        assert_eq!(how, "AAAA");
        assert_eq!(damping, ["1 state0", "1 state1", "1 state0", "1 state1"]);
        // One component in the rate of another.
        let (how, _) = stepped(&format!(
            "{fields} rate q = outer(X, phi)/delta - transpose(q)*diag(phi)"
        ));
        assert_eq!(how, "TTTT");
    }

    #[test]
    fn what_is_not_linear_or_reads_fields_is_stepped_with_the_others() {
        let fields = "param tau : time > 0 \"tau\" field q : number \"q\" field p : number \"p\"";
        for rate in ["-q^2/tau", "-sin(q)/tau", "(mean(q') - q)/tau", "-p*q/tau"] {
            let (how, _) = stepped(&format!("{fields} rate p = -p/tau rate q = {rate}"));
            assert_eq!(how, "AT", "{rate}");
        }
        // A coefficient does not evolve.
        let (how, damping) = stepped(&format!("{fields} rate q = -p*q/tau"));
        assert_eq!(
            (how.as_str(), damping[0].as_str()),
            ("A", "1 state1 tau^-1")
        );
    }

    #[test]
    fn a_staggered_pair_is_stepped_without_stages() {
        let wave = "param c : velocity > 0 \"c\" field p : number \"p\" field w : vector number at half \"w\"
            rate p = c*mean(dot(w' - w, xi)/x^2) rate w = c*mean((p' - p)*xi/x^2) - c*w/delta";
        let (how, damping) = stepped(wave);
        assert_eq!(how, "AHH");
        assert_eq!(damping, ["", "1 c delta^-1", "1 c delta^-1"]);
    }
}
