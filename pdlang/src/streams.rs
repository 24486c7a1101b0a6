//! What a cloud keeps of its bonds.
//!
//! Contract. A lattice has a table of all values of geometry, where they cost nothing. A cloud would keep a number per
//! bond for each of them. Here a value is taken apart into `number * constant * rest * x^n`, and a cloud keeps streams
//! `constant * rest * x^m`, each once for all sweeps of a family, from which a short tape per sweep forms the values:
//!
//! - The power m belongs to the rest; what lacks from it to n is formed from xi. It is the largest one that a sweep of the
//!   stage `Step` needs, so that such sweeps multiply by 1/x only, which most of them form anyway. Where none does, and all
//!   powers are even steps apart, it is the smallest: x^2 needs no root.
//! - Where all values with a rest have one constant, it is a part of the stream. Otherwise the constants are streams of
//!   their own: with one material, one number each.
//! - What runs once, in the stage `Reference`, decides nothing: its streams are dropped behind it.

use std::collections::{BTreeMap, BTreeSet};

use crate::constants::Constants;
use crate::ir::Home;
use crate::poly::{Algebra, Atom, AtomId, Monomial, Poly};
use crate::ratio::Ratio;
use crate::spec::{Stage, SweepSpec};
use crate::tape::{Builder, Op};

/// A constant and a rest, either may be 1.
type Stream = (Poly, Poly);

/// A value of geometry, taken apart.
struct Value {
    sweep: usize,
    number: Ratio,
    constant: Poly,
    rest: Poly,
    power: i32,
}

/// What the values with one rest have in common.
#[derive(Default)]
struct Shared {
    power: i32,
    constants: BTreeSet<Poly>,
}

struct Chooser<'a> {
    algebra: &'a mut Algebra,
    constants: &'a mut Constants,
    sweeps: Vec<SweepSpec>,
    values: Vec<Value>,
    /// By family and rest.
    shared: BTreeMap<(u32, Poly), Shared>,
    /// By family and stream: the number that is a part of it, so that its first user needs none.
    numbers: BTreeMap<(u32, Stream), Ratio>,
}

/// Completes sweeps, given what their values of geometry are, in the order of the outputs.
pub fn choose(
    algebra: &mut Algebra,
    constants: &mut Constants,
    dim: usize,
    written: Vec<(SweepSpec, Vec<Poly>)>,
) -> Vec<SweepSpec> {
    let mut values = Vec::new();
    let mut sweeps = Vec::new();
    for (sweep, (spec, polys)) in written.into_iter().enumerate() {
        values.extend(polys.iter().map(|p| taken_apart(algebra, sweep, p)));
        sweeps.push(spec);
    }
    let mut c = Chooser {
        algebra,
        constants,
        sweeps,
        values,
        shared: BTreeMap::new(),
        numbers: BTreeMap::new(),
    };
    c.share();
    c.number();
    for sweep in 0..c.sweeps.len() {
        c.write(sweep, dim);
    }
    c.sweeps
}

fn taken_apart(algebra: &mut Algebra, sweep: usize, p: &Poly) -> Value {
    let x = algebra.intern(Atom::X);
    let mut by_bond: BTreeMap<Monomial, Poly> = BTreeMap::new();
    for (m, c) in &p.0 {
        let constant = |a: &AtomId| algebra.nature(*a).home == Home::Constant;
        let (k, bond): (Vec<_>, Vec<_>) = m.0.iter().partition(|(a, _)| constant(a));
        let group = by_bond.entry(Monomial(bond)).or_default();
        *group = algebra.add(group, &Poly(vec![(Monomial(k), *c)]));
    }
    if by_bond.len() == 1
        && let Some((bond, constant)) = by_bond.pop_first()
        && let Some(number) = constant.0.first().map(|(_, c)| *c)
        && let Some(unit) = Ratio::ONE.div(number)
    {
        return Value {
            sweep,
            number,
            constant: algebra.scale(&constant, unit),
            rest: Poly(vec![(bond.without(x), Ratio::ONE)]),
            power: bond.degree(x),
        };
    }
    Value {
        sweep,
        number: Ratio::ONE,
        constant: Poly::int(1),
        rest: p.clone(),
        power: 0,
    }
}

impl Chooser<'_> {
    fn stage(&self, v: &Value) -> Stage {
        self.sweeps[v.sweep].stage
    }

    fn family(&self, v: &Value) -> u32 {
        self.sweeps[v.sweep].family
    }

    fn share(&mut self) {
        let mut shared: BTreeMap<(u32, Poly), Shared> = BTreeMap::new();
        let mut powers: BTreeMap<(u32, Poly), BTreeSet<(bool, i32)>> = BTreeMap::new();
        for v in &self.values {
            let key = (self.family(v), v.rest.clone());
            let power = (self.stage(v) == Stage::Step, v.power);
            powers.entry(key.clone()).or_default().insert(power);
            let entry = shared.entry(key).or_default();
            if self.stage(v) != Stage::Reference {
                entry.constants.insert(v.constant.clone());
            }
        }
        for (key, entry) in &mut shared {
            let bare = key.1 == Poly::int(1);
            let root = self.forms_inverse_lengths(key.0);
            entry.power = if bare { 0 } else { best(&powers[key], root) };
        }
        self.shared = shared;
    }

    /// Whether a sweep over the family forms 1/x at every step for itself.
    fn forms_inverse_lengths(&self, family: u32) -> bool {
        let sweeps = self.sweeps.iter();
        sweeps
            .filter(|s| s.family == family && s.stage == Stage::Step)
            .any(|s| s.bond.ops.iter().any(|op| matches!(op, Op::Ix)))
    }

    /// One stream, or a constant and a rest.
    fn streams(&self, v: &Value) -> Vec<Stream> {
        let one = Poly::int(1);
        let shared = &self.shared[&(self.family(v), v.rest.clone())];
        let whole = (v.constant.clone(), v.rest.clone());
        let streams = if shared.constants.len() < 2 || self.stage(v) == Stage::Reference {
            vec![whole]
        } else {
            vec![(whole.0, one.clone()), (one.clone(), whole.1)]
        };
        let kept = |(constant, rest): &Stream| *constant != one || *rest != one;
        streams.into_iter().filter(kept).collect()
    }

    fn number(&mut self) {
        let mut numbers = BTreeMap::new();
        for in_step in [true, false] {
            for v in &self.values {
                if (self.stage(v) == Stage::Step) == in_step
                    && let Some(first) = self.streams(v).into_iter().next()
                {
                    numbers.entry((self.family(v), first)).or_insert(v.number);
                }
            }
        }
        self.numbers = numbers;
    }

    fn number_of(&self, family: u32, stream: &Stream) -> Ratio {
        let number = self.numbers.get(&(family, stream.clone()));
        number.copied().unwrap_or(Ratio::ONE)
    }

    fn write(&mut self, sweep: usize, dim: usize) {
        let family = self.sweeps[sweep].family;
        let (mut kept, mut formed) = (Builder::default(), Builder::default());
        for k in 0..self.values.len() {
            let v = &self.values[k];
            if v.sweep != sweep {
                continue;
            }
            let power = self.shared[&(family, v.rest.clone())].power;
            let mut left = (v.power - power, v.number);
            let mut factors = Vec::new();
            for stream in self.streams(v) {
                match left.1.div(self.number_of(family, &stream)) {
                    Some(number) => left.1 = number,
                    None => self.algebra.overflow = true,
                }
                let r = self.stream(&mut kept, family, &stream);
                let position = kept.out(r);
                factors.push(formed.op(Op::Geo(position)));
            }
            let r = product(&mut formed, &factors, left, dim);
            formed.tape.outs.push(r);
        }
        self.sweeps[sweep].streams = kept.tape;
        self.sweeps[sweep].from_streams = formed.tape;
    }

    /// In the tape of what is kept.
    fn stream(&mut self, kept: &mut Builder, family: u32, stream: &Stream) -> u32 {
        let number = self.number_of(family, stream);
        let power = self.shared.get(&(family, stream.1.clone()));
        let mut p = self.algebra.mul(&stream.0, &stream.1);
        if let Some(n) = power.map(|s| s.power).filter(|n| *n != 0) {
            let x = self.algebra.intern(Atom::X);
            p = self.algebra.mul(&p, &Poly::power(x, n));
        }
        let p = self.algebra.scale(&p, number);
        self.constants.geometry(self.algebra, kept, &p)
    }
}

/// The power to keep, of those that are needed, in a step or not; `root`: 1/x is there anyway.
fn best(powers: &BTreeSet<(bool, i32)>, root: bool) -> i32 {
    let any = powers.iter().any(|(in_step, _)| *in_step);
    let counted = || powers.iter().filter(|(in_step, _)| *in_step == any);
    let all = || counted().map(|(_, n)| *n);
    let (least, most) = (all().min().unwrap_or(0), all().max().unwrap_or(0));
    match !root && all().all(|n| (n - least) % 2 == 0) {
        true => least,
        false => most,
    }
}

/// The factors, with a power of x and a number. The power comes first: a sign goes into the last factor, and in front of
/// a reciprocal it would cost a second division.
fn product(b: &mut Builder, streams: &[u32], (power, number): (i32, Ratio), dim: usize) -> u32 {
    let mut factors: Vec<u32> = Vec::new();
    factors.extend((power != 0).then(|| power_of_x(b, power, dim)));
    factors.extend(streams);
    let value = factors.into_iter().reduce(|v, r| b.op(Op::Mul(v, r)));
    match value {
        None => b.lit(number.value()),
        Some(v) if number.is_one() => v,
        Some(v) if number.neg().is_one() => b.op(Op::Neg(v)),
        Some(v) => {
            let number = b.lit(number.value());
            b.op(Op::Mul(v, number))
        }
    }
}

/// x = |xi|^2/|xi|. The order of the square is that of `norm_squared` in the runtime.
fn power_of_x(b: &mut Builder, n: i32, dim: usize) -> u32 {
    if n < 0 {
        let ix = b.op(Op::Ix);
        return b.power(ix, n.unsigned_abs());
    }
    let xi = b.op(Op::Xi(0));
    let mut square = b.op(Op::Mul(xi, xi));
    for a in 1..dim {
        let xi = b.op(Op::Xi(a as u8));
        square = b.op(Op::Fma(xi, xi, square));
    }
    let even = (n > 1).then(|| b.power(square, n as u32 / 2));
    let odd = (n % 2 == 1).then(|| {
        let ix = b.op(Op::Ix);
        b.op(Op::Mul(square, ix))
    });
    match (even, odd) {
        (Some(even), Some(odd)) => b.op(Op::Mul(even, odd)),
        (Some(r), None) | (None, Some(r)) => r,
        (None, None) => b.lit(1.0),
    }
}
