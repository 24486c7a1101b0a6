//! What a bond adds to the sums of a sweep, as a polynomial: products of numbers at the node and numbers at the other end,
//! with a coefficient for every kind of bond of a lattice.
//!
//! The bond tape is walked once with polynomials in its registers. Sums and products stay polynomials, functions of
//! geometry are numbers; anything else of what changes is kept with the name of what it is, and counts only where a sum
//! takes it.
use super::super::Home;
use super::super::program::Program;
use crate::spec::{Op, SlotKind, Spec, Stage, SweepSpec, Tape};
use crate::tape::operands;
use std::collections::BTreeMap;

/// A number read at the node: a value of the prologue, or a node slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Own {
    Pre(usize),
    Slot(Home),
}

/// Factors at the node and at the other end, each in ascending order.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Monomial {
    pub own: Vec<Own>,
    pub far: Vec<Home>,
}

impl Monomial {
    fn times(&self, other: &Monomial) -> Monomial {
        let mut product = self.clone();
        product.own.extend(&other.own);
        product.far.extend(&other.far);
        product.own.sort_unstable();
        product.far.sort_unstable();
        product
    }
}

/// Coefficients by kinds of bonds; none is zero for all.
pub(super) type Polynomial = BTreeMap<Monomial, Vec<f64>>;

/// Products of a sweep above which their number is the reason not to go on.
const MOST: usize = 500;
const TOO_MANY: &str = "more than 500 products";
/// Powers that are multiplied out.
const POWERS: i32 = 4;

/// What stands in the way, and whether it is done to the deformation: then it may be gone at small displacements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Obstacle {
    pub what: &'static str,
    pub deformed: bool,
}

impl Obstacle {
    /// Of a law as it is, at any displacement.
    pub const fn lasting(what: &'static str) -> Obstacle {
        Obstacle {
            what,
            deformed: false,
        }
    }
}

#[derive(Clone, Debug)]
enum Value {
    Of(Polynomial),
    Not(Obstacle),
}

/// The kinds of bonds of a family: their records, as [`super::super::geometry::Geometry::Table`] has them.
pub(super) struct Kinds<'a> {
    pub dim: usize,
    pub records: Vec<&'a [f64]>,
}

impl Kinds<'_> {
    fn column(&self, k: usize) -> Vec<f64> {
        self.records.iter().map(|r| r[k]).collect()
    }
}

/// The polynomial of every sum, or what stands in the way.
pub(super) fn sums(
    spec: &Spec,
    p: &Program,
    homes: &[Home],
    sweep: &SweepSpec,
    kinds: &Kinds,
) -> Result<Vec<Polynomial>, Obstacle> {
    let deformed = deformed(spec);
    let moved = Marks::of_deformed(sweep, &deformed);
    let handed = sweep.pre.outs.iter().map(|r| moved.pre[*r as usize]);
    let reader = Reader {
        spec,
        p,
        homes,
        kinds,
        handed: handed.collect(),
        deformed,
    };
    let ops = &sweep.bond.ops;
    let mut registers: Vec<Value> = Vec::with_capacity(ops.len());
    let mut found = vec![Polynomial::new(); sweep.accumulators as usize];
    for op in ops {
        let of = |r: &u32| &registers[*r as usize];
        match op {
            Op::AddTo(sum, a, b) => match reader.multiply(of(a), of(b)) {
                Value::Of(product) => add(&mut found[*sum as usize], &product, 1.0),
                Value::Not(obstacle) => return Err(obstacle),
            },
            Op::MaxTo(..) => return Err(Obstacle::lasting("an extreme over bonds")),
            Op::PutHistory(..) => return Err(Obstacle::lasting("a history of bonds")),
            _ => {}
        }
        let value = reader.value(op, &registers);
        registers.push(value);
    }
    // Differences of far ends would be squared after they were taken apart: their digits are gone by then.
    let moved = |home: &Home| matches!(home, Home::Displacement(_));
    let square = |m: &Monomial| {
        let own = |own: &&Own| matches!(own, Own::Slot(home) if moved(home));
        m.own.iter().filter(own).count() + m.far.iter().filter(|h| moved(h)).count() > 1
    };
    if found.iter().flat_map(Polynomial::keys).any(square) {
        return Err(Obstacle {
            what: "a product of displacements",
            deformed: true,
        });
    }
    let finite = |numbers: &Vec<f64>| numbers.iter().all(|v| v.is_finite());
    if !found.iter().flat_map(Polynomial::values).all(finite) {
        return Err(Obstacle::lasting("a coefficient that is no number"));
    }
    Ok(found)
}

/// What a sweep does at its nodes with sums of steps that would turn their last digits into more: a sum that is nothing
/// bond by bond is nothing to 16 digits of the largest one here, and has no inverse, root or sign.
pub(super) fn rough(spec: &Spec, s: &SweepSpec) -> Option<Obstacle> {
    let summed = |slot: u32| {
        let kind = spec.slots[slot as usize].kind;
        matches!(kind, SlotKind::Computed(Stage::Step))
    };
    let marks = Marks::new(s, summed, |_| false, true);
    let deformed = deformed(spec);
    let moved = Marks::of_deformed(s, &deformed);
    let tapes = [
        (&s.pre, &marks.pre, &moved.pre),
        (&s.post, &marks.post, &moved.post),
    ];
    tapes.into_iter().find_map(|(tape, marks, moved)| {
        let of = |r: &u32| marks[*r as usize];
        tape.ops.iter().find_map(|op| {
            let (what, by) = match op {
                Op::Div(_, b) if of(b) => ("the inverse of a sum", vec![b]),
                Op::Powi(a, n) if *n < 0 && of(a) => ("the inverse of a sum", vec![a]),
                Op::Sqrt(a) | Op::Rsqrt(a) | Op::Pow(a, _) if of(a) => ("a root of a sum", vec![a]),
                Op::Ln(a) if of(a) => ("the logarithm of a sum", vec![a]),
                Op::Lt(a, b) | Op::Le(a, b) if of(a) || of(b) => ("a choice by a sum", vec![a, b]),
                _ => return None,
            };
            let deformed = by.into_iter().any(|r| moved[*r as usize]);
            Some(Obstacle { what, deformed })
        })
    })
}

/// For every operation of the tapes of a sweep, whether something is in it.
struct Marks {
    pre: Vec<bool>,
    post: Vec<bool>,
}

impl Marks {
    /// `slot`: node slots that it is in; `bond`: what it is in on a bond, besides such slots. `sums`: in all sums alike.
    fn new(
        s: &SweepSpec,
        slot: impl Fn(u32) -> bool,
        bond: impl Fn(&Op) -> bool,
        sums: bool,
    ) -> Marks {
        let own = |k: u32| s.own.get(k as usize).is_some_and(|k| slot(*k));
        let pre = marked(&s.pre, |op| matches!(op, Op::Own(k) if own(*k)));
        let handed: Vec<bool> = s.pre.outs.iter().map(|r| pre[*r as usize]).collect();
        let handed = |k: u32| handed.get(k as usize).is_some_and(|h| *h);
        let bonds = marked(&s.bond, |op| match op {
            Op::Nbr(k) => s.nbr.get(*k as usize).is_some_and(|k| slot(*k)),
            Op::Pre(k) => handed(*k),
            op => bond(op),
        });
        let mut sum = vec![sums; s.accumulators as usize];
        for op in &s.bond.ops {
            if let Op::AddTo(k, a, b) = op {
                sum[*k as usize] |= bonds[*a as usize] || bonds[*b as usize];
            }
            if let Op::MaxTo(k, a) = op {
                sum[*k as usize] |= bonds[*a as usize];
            }
        }
        let post = marked(&s.post, |op| match op {
            Op::Acc(k) => sum[*k as usize],
            Op::Pre(k) => handed(*k),
            Op::Own(k) => own(*k),
            _ => false,
        });
        Marks { pre, post }
    }

    fn of_deformed(s: &SweepSpec, deformed: &[bool]) -> Marks {
        let eta = |op: &Op| matches!(op, Op::Eta(_));
        Marks::new(s, |slot| deformed[slot as usize], eta, false)
    }
}

/// The node slots that the displacement is in.
fn deformed(spec: &Spec) -> Vec<bool> {
    let of = |kind: SlotKind| matches!(kind, SlotKind::Displacement(_));
    let mut found: Vec<bool> = spec.slots.iter().map(|slot| of(slot.kind)).collect();
    for s in spec.sweeps.iter().filter(|s| s.stage <= Stage::Step) {
        let marks = Marks::of_deformed(s, &found);
        for (slot, r) in s.out.iter().zip(&s.post.outs) {
            found[*slot as usize] |= marks.post[*r as usize];
        }
    }
    found
}

/// For every operation of a tape, whether it is one of those, or depends on one.
fn marked(tape: &Tape, is: impl Fn(&Op) -> bool) -> Vec<bool> {
    let mut marks: Vec<bool> = Vec::with_capacity(tape.ops.len());
    for op in &tape.ops {
        marks.push(is(op) || operands(op).iter().any(|r| marks[*r as usize]));
    }
    marks
}

struct Reader<'a> {
    spec: &'a Spec,
    p: &'a Program,
    homes: &'a [Home],
    kinds: &'a Kinds<'a>,
    /// Node slots, and values of the prologue, that the displacement is in.
    deformed: Vec<bool>,
    handed: Vec<bool>,
}

impl Reader<'_> {
    fn value(&self, op: &Op, registers: &[Value]) -> Value {
        let of = |r: &u32| &registers[*r as usize];
        let minus = Value::Of(self.number(-1.0));
        match op {
            Op::Lit(v) => Value::Of(self.number(*v)),
            Op::Inf => Value::Of(self.number(f64::INFINITY)),
            Op::Geo(k) => Value::Of(self.geometry(2 + self.kinds.dim + *k as usize)),
            Op::Ix => Value::Of(self.geometry(1 + self.kinds.dim)),
            Op::Xi(a) => Value::Of(self.geometry(1 + *a as usize)),
            Op::Eta(a) => {
                let u = Home::Displacement(*a as usize);
                let mut eta = self.variable(vec![], vec![u]);
                add(&mut eta, &self.variable(vec![Own::Slot(u)], vec![]), -1.0);
                Value::Of(eta)
            }
            Op::Pre(k) => Value::Of(self.variable(vec![Own::Pre(*k as usize)], vec![])),
            Op::Nbr(k) => Value::Of(self.far(self.p.nbr[*k as usize])),
            Op::History(_) | Op::Reverse(_) => {
                let what = "a history, a weight or a reverse value of single bonds";
                Value::Not(Obstacle::lasting(what))
            }
            Op::Add(a, b) => self.sum(of(a), of(b), 1.0),
            Op::Sub(a, b) => self.sum(of(a), of(b), -1.0),
            Op::Mul(a, b) => self.multiply(of(a), of(b)),
            Op::Fma(a, b, c) => self.sum(&self.multiply(of(a), of(b)), of(c), 1.0),
            Op::Neg(a) => self.multiply(&minus, of(a)),
            Op::Div(a, b) => match self.numbers(of(b)) {
                Some(divisors) => {
                    let inverse: Vec<f64> = divisors.iter().map(|d| 1.0 / d).collect();
                    self.multiply(of(a), &Value::Of(constant(inverse)))
                }
                None => self.not("a division", &[of(a), of(b)]),
            },
            Op::Powi(a, n) => match (self.numbers(of(a)), *n) {
                (Some(_), n) => self.each(&[of(a)], "a power", |v| v[0].powi(n)),
                (None, 1..=POWERS) => {
                    (1..*n).fold(of(a).clone(), |power, _| self.multiply(&power, of(a)))
                }
                _ => self.not("a power", &[of(a)]),
            },
            Op::Abs(a) => self.each(&[of(a)], "an absolute value", |v| v[0].abs()),
            Op::Sqrt(a) => self.each(&[of(a)], "a root", |v| v[0].sqrt()),
            Op::Rsqrt(a) => self.each(&[of(a)], "a root", |v| 1.0 / v[0].sqrt()),
            Op::Exp(a) => self.each(&[of(a)], "an exponential", |v| v[0].exp()),
            Op::Ln(a) => self.each(&[of(a)], "a logarithm", |v| v[0].ln()),
            Op::Sin(a) => self.each(&[of(a)], "a sine", |v| v[0].sin()),
            Op::Cos(a) => self.each(&[of(a)], "a cosine", |v| v[0].cos()),
            Op::Tan(a) => self.each(&[of(a)], "a tangent", |v| v[0].tan()),
            Op::Min(a, b) => self.each(&[of(a), of(b)], "a minimum", |v| v[0].min(v[1])),
            Op::Max(a, b) => self.each(&[of(a), of(b)], "a maximum", |v| v[0].max(v[1])),
            Op::Pow(a, b) => self.each(&[of(a), of(b)], "a power", |v| v[0].powf(v[1])),
            Op::Lt(..) | Op::Le(..) | Op::And(..) | Op::Or(..) | Op::Not(_) | Op::Select(..) => {
                let all: Vec<&Value> = operands(op).iter().map(of).collect();
                self.not("a choice", &all)
            }
            // Effects have no value, and others do not stand in tapes of bonds.
            _ => Value::Not(Obstacle::lasting("what a bond does not have")),
        }
    }

    /// A position is that of the node and the bond, also where the other end is an image.
    fn far(&self, slot: usize) -> Polynomial {
        match (self.spec.slots[slot].kind, self.homes[slot]) {
            (SlotKind::Position(a), home) => {
                let mut x = self.geometry(1 + a as usize);
                add(&mut x, &self.variable(vec![Own::Slot(home)], vec![]), 1.0);
                x
            }
            (_, home) => self.variable(vec![], vec![home]),
        }
    }

    fn number(&self, v: f64) -> Polynomial {
        constant(vec![v; self.kinds.records.len()])
    }

    fn geometry(&self, column: usize) -> Polynomial {
        constant(self.kinds.column(column))
    }

    fn variable(&self, own: Vec<Own>, far: Vec<Home>) -> Polynomial {
        Polynomial::from([(Monomial { own, far }, vec![1.0; self.kinds.records.len()])])
    }

    /// A value of the geometry alone.
    fn numbers(&self, value: &Value) -> Option<Vec<f64>> {
        let Value::Of(p) = value else {
            return None;
        };
        match p.len() {
            0 => Some(vec![0.0; self.kinds.records.len()]),
            1 => p.get(&Monomial::default()).cloned(),
            _ => None,
        }
    }

    /// A function of geometry, kind by kind.
    fn each(&self, of: &[&Value], what: &'static str, f: impl Fn(&[f64]) -> f64) -> Value {
        let numbers: Option<Vec<Vec<f64>>> = of.iter().map(|v| self.numbers(v)).collect();
        let Some(numbers) = numbers else {
            return self.not(what, of);
        };
        let kind = |k: usize| f(&numbers.iter().map(|n| n[k]).collect::<Vec<f64>>());
        Value::Of(constant((0..self.kinds.records.len()).map(kind).collect()))
    }

    /// What this is of those, or what one of them is already.
    fn not(&self, what: &'static str, of: &[&Value]) -> Value {
        let earlier = of.iter().find_map(|v| match v {
            Value::Not(obstacle) => Some(*obstacle),
            Value::Of(_) => None,
        });
        let deforms = |v: &&Value| matches!(v, Value::Of(p) if p.keys().any(|m| self.deforms(m)));
        Value::Not(earlier.unwrap_or_else(|| Obstacle {
            what,
            deformed: of.iter().any(deforms),
        }))
    }

    /// Whether the displacement is in it, by itself or in a sum.
    fn deforms(&self, m: &Monomial) -> bool {
        let home = |home: &Home| {
            let mut slots = self.homes.iter().zip(&self.deformed);
            matches!(home, Home::Displacement(_))
                || slots.any(|(h, deformed)| *deformed && h == home)
        };
        let own = |own: &Own| match own {
            Own::Pre(k) => self.handed[*k],
            Own::Slot(slot) => home(slot),
        };
        m.own.iter().any(own) || m.far.iter().any(home)
    }

    fn sum(&self, a: &Value, b: &Value, factor: f64) -> Value {
        let (Value::Of(p), Value::Of(q)) = (a, b) else {
            return self.not("a sum", &[a, b]);
        };
        let mut sum = p.clone();
        add(&mut sum, q, factor);
        self.bounded(sum)
    }

    fn multiply(&self, a: &Value, b: &Value) -> Value {
        let (Value::Of(p), Value::Of(q)) = (a, b) else {
            return self.not("a product", &[a, b]);
        };
        let mut product = Polynomial::new();
        for (left, x) in p {
            for (right, y) in q {
                if product.len() > MOST {
                    return self.not(TOO_MANY, &[a, b]);
                }
                let numbers: Vec<f64> = x.iter().zip(y).map(|(x, y)| x * y).collect();
                let one = Polynomial::from([(left.times(right), numbers)]);
                add(&mut product, &one, 1.0);
            }
        }
        self.bounded(product)
    }

    fn bounded(&self, p: Polynomial) -> Value {
        match p.len() <= MOST {
            true => Value::Of(p),
            false => self.not(TOO_MANY, &[&Value::Of(p)]),
        }
    }
}

fn constant(numbers: Vec<f64>) -> Polynomial {
    let mut p = Polynomial::new();
    if numbers.iter().any(|v| *v != 0.0) {
        p.insert(Monomial::default(), numbers);
    }
    p
}

/// `to += factor * p`
fn add(to: &mut Polynomial, p: &Polynomial, factor: f64) {
    for (monomial, numbers) in p {
        let sum = to
            .entry(monomial.clone())
            .or_insert_with(|| vec![0.0; numbers.len()]);
        for (s, n) in sum.iter_mut().zip(numbers) {
            *s += factor * n;
        }
        if sum.iter().all(|s| *s == 0.0) {
            to.remove(monomial);
        }
    }
}
