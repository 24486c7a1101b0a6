//! Whether the force of a bond is the same from both ends.
//!
//! Contract. A `pair` acts on both ends of its bond, so what it reads must not tell them apart. This is asked of the
//! numbers, not of the form: the lowered force is evaluated from both ends with values that stand for whatever a node
//! may have, so that `min(C, C')`, `abs(xi.x)` and `select(C > C', C, C')` are the same as `(C + C')/2` is. Bond
//! histories count as the same from both ends, vectors as reversed: they are where their updates are.

use crate::ir::{ExprId, Home, Law, Shape};
use crate::lower::{Lowering, Reading, stored_components};
use crate::poly::{Algebra, Atom, AtomId, Func, Poly, StateKind};

/// How often other values are tried.
const ROUNDS: u64 = 16;
/// Difference of the two ends, as part of the force, that is no rounding.
const DIFFERENT: f64 = 1e-6;

/// Whether a scalar bond expression has the same value from both ends, whatever the state.
pub fn alike(law: &Law, force: ExprId) -> bool {
    let dim = law.flavours.iter().map(|f| f.dim()).max().unwrap_or(3);
    let mut algebra = Algebra::default();
    let mut lowering = Lowering::new(law, dim, &mut algebra);
    let parts = lowering.value(force, Reading::Whole);
    let weights: Vec<Poly> = law
        .weights
        .iter()
        .map(|w| lowering.value(w.expr, Reading::Whole).remove(0))
        .collect();
    let reversed = reversed(law, dim);
    let seen = |p: &Poly, round, other| {
        let view = View {
            algebra: &algebra,
            weights: &weights,
            reversed: &reversed,
            round,
        };
        view.poly(p, other)
    };
    parts.iter().all(|p| {
        (0..ROUNDS).all(|round| {
            let (here, there) = (seen(p, round, false), seen(p, round, true));
            let known = here.is_finite() && there.is_finite();
            !known || (here - there).abs() <= DIFFERENT * here.abs().max(there.abs())
        })
    })
}

/// The scalars of bond histories, and whether each is a component of a vector.
fn reversed(law: &Law, dim: usize) -> Vec<bool> {
    let bonds = law.histories.iter().filter(|h| h.home == Home::Bond);
    bonds
        .flat_map(|h| vec![h.shape == Shape::Vector; stored_components(h.shape, dim)])
        .collect()
}

/// One choice of values. `other` is the end of the bond from which it is seen.
struct View<'a> {
    algebra: &'a Algebra,
    weights: &'a [Poly],
    reversed: &'a [bool],
    round: u64,
}

impl View<'_> {
    fn poly(&self, p: &Poly, other: bool) -> f64 {
        let factor = |(a, n): &(AtomId, i32)| self.atom(*a, other).powi(*n);
        p.0.iter()
            .map(|(m, c)| c.value() * m.0.iter().map(factor).product::<f64>())
            .sum()
    }

    fn atom(&self, id: AtomId, other: bool) -> f64 {
        let turned = |id| if other { -1.0 } else { 1.0 } * self.any(id, false);
        match self.algebra.atom(id) {
            Atom::Number(bits) => f64::from_bits(*bits),
            Atom::Prime(a) => self.atom(*a, !other),
            Atom::Named(_, p) => self.poly(p, other),
            Atom::Func(f, args) => {
                let values: Vec<f64> = args.iter().map(|p| self.poly(p, other)).collect();
                function(*f, &values)
            }
            Atom::Xi(_) | Atom::Eta(_) | Atom::Y(_) => turned(id),
            Atom::Factor(k) => self.poly(&self.weights[*k as usize], other),
            Atom::FactorBack(k) => self.poly(&self.weights[*k as usize], !other),
            Atom::History(k) => self.history(*k, other),
            Atom::Reverse(k) => self.history(*k, !other),
            Atom::X | Atom::InverseY => self.any(id, false).abs(),
            Atom::State(StateKind::TimeStep, _) => self.any(id, false).abs(),
            Atom::State(..) | Atom::Sum(..) | Atom::Weight => self.any(id, other),
            _ => self.any(id, false),
        }
    }

    fn history(&self, k: u32, other: bool) -> f64 {
        let value = self.any(AtomId(u32::MAX - k), false);
        match self.reversed.get(k as usize) {
            Some(true) if other => -value,
            _ => value,
        }
    }

    /// A value between -2 and 2; in every second round none is negative.
    fn any(&self, id: AtomId, other: bool) -> f64 {
        let seed = (u64::from(id.0) << 8 | self.round << 1 | u64::from(other)) + 1;
        let mut z = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let part = (z >> 11) as f64 / (1u64 << 53) as f64;
        match self.round % 2 {
            0 => 0.1 + 1.9 * part,
            _ => 4.0 * part - 2.0,
        }
    }
}

fn function(f: Func, v: &[f64]) -> f64 {
    let truth = |b: bool| f64::from(u8::from(b));
    match (f, v) {
        (Func::Recip, [a]) => a.recip(),
        (Func::Sqrt, [a]) => a.sqrt(),
        (Func::Abs, [a]) => a.abs(),
        (Func::Exp, [a]) => a.exp(),
        (Func::Ln, [a]) => a.ln(),
        (Func::Sin, [a]) => a.sin(),
        (Func::Cos, [a]) => a.cos(),
        (Func::Tan, [a]) => a.tan(),
        (Func::Pow, [a, b]) => a.powf(*b),
        (Func::Min, [a, b]) => a.min(*b),
        (Func::Max, [a, b]) => a.max(*b),
        (Func::Select, [c, a, b]) => {
            if *c != 0.0 {
                *a
            } else {
                *b
            }
        }
        (Func::Lt, [a, b]) => truth(a < b),
        (Func::Le, [a, b]) => truth(a <= b),
        (Func::And, [a, b]) => truth(*a != 0.0 && *b != 0.0),
        (Func::Or, [a, b]) => truth(*a != 0.0 || *b != 0.0),
        (Func::Not, [a]) => truth(*a == 0.0),
        _ => f64::NAN,
    }
}
