//! Whether a sweep can break a bond at all, with the parameters at hand: a critical stretch may be infinite.
//!
//! Every value of the tapes gets an interval: constants are known, lengths and weights are positive, all else may be
//! anything. A condition that holds nowhere in its intervals breaks nothing, and the sweep then runs as one that cannot
//! break: without masks where families are whole. Comparisons with what is not a number do not hold.
use super::constants::Materials;
use crate::spec::{Op, SweepSpec, Tape};

/// Smallest and largest value; of a condition 0 (never) or 1.
type Interval = (f64, f64);
const ANY: Interval = (f64::NEG_INFINITY, f64::INFINITY);
/// A length or a weight: positive, as its square is.
const POSITIVE: Interval = (1e-100, 1e100);
const MAYBE: Interval = (0.0, 1.0);
const NEVER: Interval = (0.0, 0.0);

/// Whether a bond between some pair of materials may break in this sweep.
pub(super) fn breaks(sweep: &SweepSpec, materials: &Materials) -> bool {
    let known = !materials.by_lengths();
    (0..materials.pairs.len()).any(|pair| {
        let constants = |k: &[f64]| -> Vec<Interval> {
            let one = |&v: &f64| if known { (v, v) } else { ANY };
            k.iter().map(one).collect()
        };
        let own = pair / materials.count;
        let at_node = constants(&materials.pairs[own * materials.count + own].constants);
        let at_bond = constants(&materials.pairs[pair].constants);
        let geometry = outs(&sweep.geometry, &Leaves::of(&at_bond));
        let pre = outs(&sweep.pre, &Leaves::of(&at_node));
        let leaves = Leaves {
            geometry: &geometry,
            pre: &pre,
            ..Leaves::of(&at_bond)
        };
        let registers = registers(&sweep.bond, &leaves);
        let kills = |op: &Op| matches!(op, Op::Kill(c) if registers[*c as usize] != NEVER);
        sweep.bond.ops.iter().any(kills)
    })
}

struct Leaves<'a> {
    constants: &'a [Interval],
    geometry: &'a [Interval],
    pre: &'a [Interval],
}

impl<'a> Leaves<'a> {
    fn of(constants: &'a [Interval]) -> Leaves<'a> {
        Leaves {
            constants,
            geometry: &[],
            pre: &[],
        }
    }
}

fn outs(tape: &Tape, leaves: &Leaves) -> Vec<Interval> {
    let registers = registers(tape, leaves);
    let outs = tape.outs.iter();
    outs.map(|r| registers[*r as usize]).collect()
}

fn registers(tape: &Tape, leaves: &Leaves) -> Vec<Interval> {
    let mut r: Vec<Interval> = Vec::with_capacity(tape.ops.len());
    for op in &tape.ops {
        r.push(interval(op, &r, leaves));
    }
    r
}

fn interval(op: &Op, r: &[Interval], leaves: &Leaves) -> Interval {
    let at = |k: &u32| r[*k as usize];
    let known = |list: &[Interval], k: &u32| list.get(*k as usize).copied().unwrap_or(ANY);
    let value = match op {
        Op::Lit(v) => (*v, *v),
        Op::Inf => (f64::INFINITY, f64::INFINITY),
        Op::Const(k) => known(leaves.constants, k),
        Op::Geo(k) => known(leaves.geometry, k),
        Op::Pre(k) => known(leaves.pre, k),
        Op::Ix | Op::X | Op::Weight => POSITIVE,
        Op::Add(a, b) => sum(at(a), at(b)),
        Op::Sub(a, b) => sum(at(a), negative(at(b))),
        Op::Mul(a, b) => product(at(a), at(b)),
        Op::Fma(a, b, c) => sum(product(at(a), at(b)), at(c)),
        Op::Div(a, b) if at(b).0 > 0.0 => product(at(a), (1.0 / at(b).1, 1.0 / at(b).0)),
        Op::Neg(a) => negative(at(a)),
        Op::Abs(_) | Op::Sqrt(_) | Op::Rsqrt(_) | Op::Exp(_) => (0.0, f64::INFINITY),
        Op::Min(a, b) => (at(a).0.min(at(b).0), at(a).1.min(at(b).1)),
        Op::Max(a, b) => (at(a).0.max(at(b).0), at(a).1.max(at(b).1)),
        Op::Select(_, a, b) => (at(a).0.min(at(b).0), at(a).1.max(at(b).1)),
        Op::Lt(a, b) if at(a).0 >= at(b).1 => NEVER,
        Op::Le(a, b) if at(a).0 > at(b).1 => NEVER,
        Op::And(a, b) if at(a) == NEVER || at(b) == NEVER => NEVER,
        Op::Or(a, b) if at(a) == NEVER && at(b) == NEVER => NEVER,
        Op::Lt(..) | Op::Le(..) | Op::And(..) | Op::Or(..) | Op::Not(_) => MAYBE,
        _ => ANY,
    };
    match value.0.is_nan() || value.1.is_nan() {
        true => ANY,
        false => value,
    }
}

fn negative((low, high): Interval) -> Interval {
    (-high, -low)
}

/// What is added to infinity leaves it so, or is no number.
fn sum(a: Interval, b: Interval) -> Interval {
    const INFINITE: Interval = (f64::INFINITY, f64::INFINITY);
    if a == INFINITE || b == INFINITE {
        return INFINITE;
    }
    (a.0 + b.0, a.1 + b.1)
}

/// Not a number where one of the four products is none.
fn product(a: Interval, b: Interval) -> Interval {
    let all = [a.0 * b.0, a.0 * b.1, a.1 * b.0, a.1 * b.1];
    if all.iter().any(|v| v.is_nan()) {
        return ANY;
    }
    let low = all.iter().copied().fold(f64::INFINITY, f64::min);
    (low, all.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}
