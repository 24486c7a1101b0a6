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

#[derive(Clone, Debug)]
enum Value {
    Of(Polynomial),
    /// What it is that is no polynomial.
    Not(&'static str),
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
    tape: &Tape,
    sums: usize,
    kinds: &Kinds,
) -> Result<Vec<Polynomial>, &'static str> {
    let reader = Reader {
        spec,
        p,
        homes,
        kinds,
    };
    let mut registers: Vec<Value> = Vec::with_capacity(tape.ops.len());
    let mut found = vec![Polynomial::new(); sums];
    for op in &tape.ops {
        let of = |r: &u32| registers[*r as usize].clone();
        match op {
            Op::AddTo(sum, a, b) => match multiply(&of(a), &of(b)) {
                Value::Of(product) => add(&mut found[*sum as usize], &product, 1.0),
                Value::Not(what) => return Err(what),
            },
            Op::MaxTo(..) => return Err("an extreme over bonds"),
            Op::PutHistory(..) => return Err("a history of bonds"),
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
        return Err("a product of displacements");
    }
    let finite = |numbers: &Vec<f64>| numbers.iter().all(|v| v.is_finite());
    if !found.iter().flat_map(Polynomial::values).all(finite) {
        return Err("a coefficient that is no number");
    }
    Ok(found)
}

/// What a sweep does at its nodes with sums of steps that would turn their last digits into more: a sum that is nothing
/// bond by bond is nothing to 16 digits of the largest one here, and has no inverse, root or sign.
pub(super) fn rough(spec: &Spec, s: &SweepSpec) -> Option<&'static str> {
    let summed = |slot: &u32| {
        matches!(
            spec.slots[*slot as usize].kind,
            SlotKind::Computed(Stage::Step)
        )
    };
    let walk = |tape: &Tape, handed: &[bool]| -> Result<Vec<bool>, &'static str> {
        let mut rounded: Vec<bool> = Vec::with_capacity(tape.ops.len());
        for op in &tape.ops {
            let of = |r: &u32| rounded[*r as usize];
            match op {
                Op::Div(_, b) if of(b) => return Err("the inverse of a sum"),
                Op::Sqrt(a) | Op::Rsqrt(a) | Op::Ln(a) | Op::Pow(a, _) if of(a) => {
                    return Err("a root of a sum");
                }
                Op::Powi(a, n) if *n < 0 && of(a) => return Err("the inverse of a sum"),
                Op::Lt(a, b) | Op::Le(a, b) if of(a) || of(b) => return Err("a choice by a sum"),
                _ => {}
            }
            rounded.push(match op {
                Op::Acc(_) => true,
                Op::Own(k) => s.own.get(*k as usize).is_some_and(summed),
                Op::Pre(k) => handed.get(*k as usize).is_some_and(|h| *h),
                op => operands(op).iter().any(of),
            });
        }
        Ok(tape.outs.iter().map(|r| rounded[*r as usize]).collect())
    };
    let handed = walk(&s.pre, &[]);
    handed.and_then(|handed| walk(&s.post, &handed)).err()
}

struct Reader<'a> {
    spec: &'a Spec,
    p: &'a Program,
    homes: &'a [Home],
    kinds: &'a Kinds<'a>,
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
                Value::Not("a history or a correction factor of single bonds")
            }
            Op::Add(a, b) => sum(of(a), of(b), 1.0),
            Op::Sub(a, b) => sum(of(a), of(b), -1.0),
            Op::Mul(a, b) => multiply(of(a), of(b)),
            Op::Fma(a, b, c) => sum(&multiply(of(a), of(b)), of(c), 1.0),
            Op::Neg(a) => multiply(&minus, of(a)),
            Op::Div(a, b) => match self.numbers(of(b)) {
                Some(divisors) => {
                    let inverse: Vec<f64> = divisors.iter().map(|d| 1.0 / d).collect();
                    multiply(of(a), &Value::Of(constant(inverse)))
                }
                None => Value::Not("a division"),
            },
            Op::Powi(a, n) => match (self.numbers(of(a)), *n) {
                (Some(_), n) => self.each(&[of(a)], "a power", |v| v[0].powi(n)),
                (None, 1..=POWERS) => {
                    (1..*n).fold(of(a).clone(), |power, _| multiply(&power, of(a)))
                }
                _ => Value::Not("a power"),
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
                Value::Not("a choice")
            }
            // Effects have no value, and others do not stand in tapes of bonds.
            _ => Value::Not("what a bond does not have"),
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
        if let Some(Value::Not(what)) = of.iter().find(|v| matches!(v, Value::Not(_))) {
            return Value::Not(what);
        }
        let numbers: Option<Vec<Vec<f64>>> = of.iter().map(|v| self.numbers(v)).collect();
        let Some(numbers) = numbers else {
            return Value::Not(what);
        };
        let kind = |k: usize| f(&numbers.iter().map(|n| n[k]).collect::<Vec<f64>>());
        Value::Of(constant((0..self.kinds.records.len()).map(kind).collect()))
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

fn sum(a: &Value, b: &Value, factor: f64) -> Value {
    match (a, b) {
        (Value::Of(a), Value::Of(b)) => {
            let mut sum = a.clone();
            add(&mut sum, b, factor);
            bounded(sum)
        }
        (Value::Not(what), _) | (_, Value::Not(what)) => Value::Not(what),
    }
}

fn multiply(a: &Value, b: &Value) -> Value {
    let (a, b) = match (a, b) {
        (Value::Of(a), Value::Of(b)) => (a, b),
        (Value::Not(what), _) | (_, Value::Not(what)) => return Value::Not(what),
    };
    let mut product = Polynomial::new();
    for (left, x) in a {
        for (right, y) in b {
            if product.len() > MOST {
                return Value::Not(TOO_MANY);
            }
            let numbers: Vec<f64> = x.iter().zip(y).map(|(x, y)| x * y).collect();
            add(
                &mut product,
                &Polynomial::from([(left.times(right), numbers)]),
                1.0,
            );
        }
    }
    bounded(product)
}

fn bounded(p: Polynomial) -> Value {
    match p.len() <= MOST {
        true => Value::Of(p),
        false => Value::Not(TOO_MANY),
    }
}
