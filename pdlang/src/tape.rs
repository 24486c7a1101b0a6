//! Straight-line programs, and how a sum of products becomes one.
//!
//! The JSON form of [`Spec`] and everything below it is what the runtime reads; names and fields are part
//! of that contract and are documented there.

use std::collections::{BTreeMap, HashMap};

use serde::Serialize;

use crate::ratio::Ratio;

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tape {
    pub ops: Vec<Op>,
    pub outs: Vec<u32>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Op {
    Lit(f64),
    Inf,
    Const(u32),
    Param(u32),
    Var(u32),
    Delta,
    Own(u32),
    Nbr(u32),
    Geo(u32),
    Pre(u32),
    Acc(u32),
    History(u32),
    Reverse(u32),
    Xi(u8),
    Eta(u8),
    Ix,
    X,
    Omega(u32),
    Weight,
    Case([u32; 5]),
    Ball(Box<Tape>),
    Add(u32, u32),
    Sub(u32, u32),
    Mul(u32, u32),
    Div(u32, u32),
    Fma(u32, u32, u32),
    Neg(u32),
    Abs(u32),
    Min(u32, u32),
    Max(u32, u32),
    Sqrt(u32),
    Rsqrt(u32),
    Exp(u32),
    Ln(u32),
    Sin(u32),
    Cos(u32),
    Tan(u32),
    Pow(u32, u32),
    Powi(u32, i32),
    Lt(u32, u32),
    Le(u32, u32),
    And(u32, u32),
    Or(u32, u32),
    Not(u32),
    Select(u32, u32, u32),
    Kill(u32),
    AddTo(u32, u32, u32),
    MaxTo(u32, u32),
    PutHistory(u32, u32),
}

/// Registers that an operation reads.
pub(crate) fn operands(op: &Op) -> Vec<u32> {
    use Op::{
        Abs, Acc, Add, AddTo, And, Ball, Case, Const, Cos, Delta, Div, Eta, Exp, Fma, Geo, History,
        Inf, Ix, Kill, Le, Lit, Ln, Lt, Max, MaxTo, Min, Mul, Nbr, Neg, Not, Omega, Or, Own, Param,
        Pow, Powi, Pre, PutHistory, Reverse, Rsqrt, Select, Sin, Sqrt, Sub, Tan, Var, Weight, X,
        Xi,
    };
    match *op {
        Lit(_) | Inf | Const(_) | Param(_) | Var(_) | Delta | Own(_) | Nbr(_) | Geo(_) | Pre(_)
        | Acc(_) | History(_) | Reverse(_) | Xi(_) | Eta(_) | Ix | X | Omega(_) | Weight
        | Ball(_) => vec![],
        Case(r) => r.to_vec(),
        Add(a, b)
        | Sub(a, b)
        | Mul(a, b)
        | Div(a, b)
        | Min(a, b)
        | Max(a, b)
        | Pow(a, b)
        | Lt(a, b)
        | Le(a, b)
        | And(a, b)
        | Or(a, b)
        | AddTo(_, a, b) => vec![a, b],
        Fma(a, b, c) | Select(a, b, c) => vec![a, b, c],
        Neg(a)
        | Abs(a)
        | Sqrt(a)
        | Rsqrt(a)
        | Exp(a)
        | Ln(a)
        | Sin(a)
        | Cos(a)
        | Tan(a)
        | Powi(a, _)
        | Not(a)
        | Kill(a)
        | MaxTo(_, a)
        | PutHistory(_, a) => vec![a],
    }
}

/// Builds a tape; equal operations share a register.
#[derive(Default)]
pub struct Builder {
    pub tape: Tape,
    known: HashMap<String, u32>,
}

impl Builder {
    pub fn op(&mut self, op: Op) -> u32 {
        let key = format!("{op:?}");
        if let Some(r) = self.known.get(&key) {
            return *r;
        }
        let r = self.effect(op);
        self.known.insert(key, r);
        r
    }

    /// An operation that must not be shared.
    pub fn effect(&mut self, op: Op) -> u32 {
        self.tape.ops.push(op);
        self.tape.ops.len() as u32 - 1
    }

    pub fn lit(&mut self, v: f64) -> u32 {
        self.op(if v.is_infinite() { Op::Inf } else { Op::Lit(v) })
    }

    /// Makes a register an output and returns its position.
    pub fn out(&mut self, r: u32) -> u32 {
        if let Some(k) = self.tape.outs.iter().position(|o| *o == r) {
            return k as u32;
        }
        self.tape.outs.push(r);
        self.tape.outs.len() as u32 - 1
    }

    pub fn power(&mut self, r: u32, n: u32) -> u32 {
        match n {
            0 => self.lit(1.0),
            1 => r,
            2 => self.op(Op::Mul(r, r)),
            _ => self.op(Op::Powi(r, n as i32)),
        }
    }

    /// 1/r, or 0 where r is 0 if `guarded`: a node without bonds contributes nothing.
    pub fn recip(&mut self, r: u32, guarded: bool) -> u32 {
        let one = self.lit(1.0);
        let q = self.op(Op::Div(one, r));
        if !guarded {
            return q;
        }
        let zero = self.lit(0.0);
        let size = self.op(Op::Abs(r));
        let empty = self.op(Op::Le(size, zero));
        self.op(Op::Select(empty, zero, q))
    }
}

/// One product: coefficient, and factors with positive powers.
#[derive(Clone, Debug, PartialEq)]
pub struct Product<F: Ord> {
    pub coefficient: Ratio,
    pub factors: BTreeMap<F, u32>,
}

/// Evaluates a sum of products: the factor that most terms share is pulled out, again and again.
pub fn horner<F: Ord + Clone>(
    b: &mut Builder,
    terms: &[Product<F>],
    resolve: &mut dyn FnMut(&mut Builder, &F) -> u32,
) -> u32 {
    let Some(shared) = most_shared(terms) else {
        return plain_sum(b, terms, resolve);
    };
    let (with, without): (Vec<_>, Vec<_>) = terms
        .iter()
        .cloned()
        .partition(|t| t.factors.contains_key(&shared));
    let inner: Vec<Product<F>> = with.into_iter().map(|t| divide(t, &shared)).collect();
    let inner = horner(b, &inner, resolve);
    let factor = resolve(b, &shared);
    if without.is_empty() {
        return b.op(Op::Mul(inner, factor));
    }
    let rest = horner(b, &without, resolve);
    b.op(Op::Fma(inner, factor, rest))
}

fn divide<F: Ord + Clone>(mut t: Product<F>, f: &F) -> Product<F> {
    if let Some(n) = t.factors.get_mut(f) {
        *n -= 1;
        if *n == 0 {
            t.factors.remove(f);
        }
    }
    t
}

fn most_shared<F: Ord + Clone>(terms: &[Product<F>]) -> Option<F> {
    let mut count: BTreeMap<&F, usize> = BTreeMap::new();
    for t in terms {
        for f in t.factors.keys() {
            *count.entry(f).or_default() += 1;
        }
    }
    let best = count.values().copied().max().filter(|n| *n > 1)?;
    count
        .into_iter()
        .find(|(_, n)| *n == best)
        .map(|(f, _)| f.clone())
}

/// No factor is shared: products are added up, a positive one first so that differences are plain.
fn plain_sum<F: Ord + Clone>(
    b: &mut Builder,
    terms: &[Product<F>],
    resolve: &mut dyn FnMut(&mut Builder, &F) -> u32,
) -> u32 {
    let first = terms
        .iter()
        .position(|t| !t.coefficient.is_negative())
        .unwrap_or(0);
    let Some(start) = terms.get(first) else {
        return b.lit(0.0);
    };
    let mut sum = product(b, start.coefficient, &start.factors, resolve);
    for (k, t) in terms.iter().enumerate() {
        if k == first {
            continue;
        }
        sum = add_product(b, sum, t, resolve);
    }
    sum
}

/// Adds a product, fused where it is a plain product of several factors.
fn add_product<F: Ord + Clone>(
    b: &mut Builder,
    sum: u32,
    t: &Product<F>,
    resolve: &mut dyn FnMut(&mut Builder, &F) -> u32,
) -> u32 {
    if t.coefficient.is_negative() {
        let p = product(b, t.coefficient.neg(), &t.factors, resolve);
        return b.op(Op::Sub(sum, p));
    }
    let last = t.factors.iter().next_back().map(|(f, n)| (f.clone(), *n));
    match last {
        Some((f, 1)) if t.factors.len() > 1 => {
            let rest = divide(t.clone(), &f);
            let p = product(b, rest.coefficient, &rest.factors, resolve);
            let q = resolve(b, &f);
            b.op(Op::Fma(p, q, sum))
        }
        _ => {
            let p = product(b, t.coefficient, &t.factors, resolve);
            b.op(Op::Add(sum, p))
        }
    }
}

fn product<F: Ord + Clone>(
    b: &mut Builder,
    coefficient: Ratio,
    factors: &BTreeMap<F, u32>,
    resolve: &mut dyn FnMut(&mut Builder, &F) -> u32,
) -> u32 {
    let mut value = None;
    for (f, n) in factors {
        let r = resolve(b, f);
        let r = b.power(r, *n);
        value = Some(value.map_or(r, |v| b.op(Op::Mul(v, r))));
    }
    match value {
        None => b.lit(coefficient.value()),
        Some(v) if coefficient.is_one() => v,
        Some(v) if coefficient.neg().is_one() => b.op(Op::Neg(v)),
        Some(v) => {
            let c = b.lit(coefficient.value());
            b.op(Op::Mul(c, v))
        }
    }
}
