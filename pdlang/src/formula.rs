//! A register of a tape as a formula that a person can read.
//!
//! Contract. Total on every tape; parentheses only where they are needed; what is long ends in dots. Registers of other tapes keep the names that
//! generated code gives them: `c0` is a constant, `g0` a value of geometry, `stream0` a stream, `sum0` a sum.

use crate::spec::{SlotKind, SlotSpec, Spec, SweepSpec};
use crate::tape::{Op, Tape};

/// How tightly a formula holds together.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Tight {
    Sum,
    Product,
    Power,
    Atom,
}

type Shown = (String, Tight);

/// Longest formula of a register.
const LONG: usize = 160;

/// The value of register `r`. A sweep gives names to the node quantities that it reads.
pub fn formula(tape: &Tape, r: u32, spec: &Spec, sweep: Option<&SweepSpec>) -> String {
    shown(tape, r, spec, sweep).0
}

/// Registers one after the other, so that what is read twice is formed once.
fn shown(tape: &Tape, r: u32, spec: &Spec, sweep: Option<&SweepSpec>) -> Shown {
    let mut before: Vec<Shown> = Vec::new();
    for op in tape.ops.iter().take(r as usize + 1) {
        let (text, tight) = value(op, &before, spec, sweep);
        before.push(match text.len() > LONG {
            true => atom(".."),
            false => (text, tight),
        });
    }
    before.pop().unwrap_or_else(|| atom(format!("r{r}")))
}

fn value(op: &Op, before: &[Shown], spec: &Spec, sweep: Option<&SweepSpec>) -> Shown {
    let of = |r: &u32| before[*r as usize].clone();
    let at_least = |r: &u32, tight: Tight| match of(r) {
        (text, t) if t >= tight => text,
        (text, _) => format!("({text})"),
    };
    let sum = |a: &u32, sign: &str, b: &u32, right: Tight| {
        let text = format!("{} {sign} {}", of(a).0, at_least(b, right));
        (text, Tight::Sum)
    };
    let product = |a: &u32, b: &u32| match a == b {
        true => power(at_least(a, Tight::Atom), 2),
        _ if of(a).0 == "1" => of(b),
        _ if of(b).0 == "1" => of(a),
        false => {
            let (a, b) = (at_least(a, Tight::Product), at_least(b, Tight::Product));
            (format!("{a}*{b}"), Tight::Product)
        }
    };
    let call = |name: &str, args: &[u32]| {
        let args: Vec<String> = args.iter().map(|r| of(r).0).collect();
        atom(format!("{name}({})", args.join(", ")))
    };
    let node = |k: &u32, list: fn(&SweepSpec) -> &[u32]| {
        let slot = sweep.and_then(|s| list(s).get(*k as usize));
        slot.map_or_else(|| format!("q{k}"), |slot| quantity(spec, *slot))
    };
    match op {
        Op::Lit(v) if *v < 0.0 => (format!("{v}"), Tight::Product),
        Op::Lit(v) => atom(format!("{v}")),
        Op::Inf => atom("inf"),
        Op::Const(k) => atom(format!("c{k}")),
        Op::Geo(k) => atom(format!("g{k}")),
        Op::Acc(k) => atom(format!("sum{k}")),
        Op::Pre(k) => match sweep.and_then(|s| s.pre.outs.get(*k as usize).map(|r| (s, r))) {
            Some((s, r)) => shown(&s.pre, *r, spec, sweep),
            None => atom(format!("p{k}")),
        },
        Op::Param(k) => match spec.params.get(*k as usize) {
            Some(p) => atom(&p.name),
            None => atom(format!("param{k}")),
        },
        Op::Omega(k) => match spec.influences.get(*k as usize) {
            Some(i) => atom(&i.name),
            None => atom(format!("omega{k}")),
        },
        Op::Own(k) => atom(node(k, |s| &s.own)),
        Op::Nbr(k) => atom(format!("{}'", node(k, |s| &s.nbr))),
        Op::Var(k) => atom(format!("v{k}")),
        Op::History(k) => atom(format!("history{k}")),
        Op::Reverse(k) => atom(format!("history{k}'")),
        Op::Xi(a) => atom(format!("xi_{}", axis(*a))),
        Op::Eta(a) => atom(format!("eta_{}", axis(*a))),
        Op::Delta => atom("delta"),
        Op::X => atom("x"),
        Op::Ix => ("1/x".into(), Tight::Product),
        Op::Weight => atom("V"),
        Op::Case(flavours) => call("by_flavour", flavours),
        Op::Ball(inner) => match inner.outs.first() {
            Some(out) => atom(format!("ball({})", shown(inner, *out, spec, sweep).0)),
            None => atom("ball()"),
        },
        Op::Add(a, b) => sum(a, "+", b, Tight::Sum),
        Op::Sub(a, b) => sum(a, "-", b, Tight::Product),
        Op::Mul(a, b) => product(a, b),
        Op::Div(a, b) => {
            let (a, b) = (at_least(a, Tight::Product), at_least(b, Tight::Power));
            (format!("{a}/{b}"), Tight::Product)
        }
        Op::Fma(a, b, c) => (format!("{} + {}", product(a, b).0, of(c).0), Tight::Sum),
        Op::Neg(a) => (format!("-{}", at_least(a, Tight::Power)), Tight::Product),
        Op::Powi(a, n) => power(at_least(a, Tight::Atom), *n),
        Op::Abs(a) => call("abs", &[*a]),
        Op::Min(a, b) => call("min", &[*a, *b]),
        Op::Max(a, b) => call("max", &[*a, *b]),
        Op::Sqrt(a) => call("sqrt", &[*a]),
        Op::Rsqrt(a) => call("rsqrt", &[*a]),
        Op::Exp(a) => call("exp", &[*a]),
        Op::Ln(a) => call("ln", &[*a]),
        Op::Sin(a) => call("sin", &[*a]),
        Op::Cos(a) => call("cos", &[*a]),
        Op::Tan(a) => call("tan", &[*a]),
        Op::Pow(a, b) => call("pow", &[*a, *b]),
        Op::Lt(a, b) => call("less", &[*a, *b]),
        Op::Le(a, b) => call("at_most", &[*a, *b]),
        Op::And(a, b) => call("and", &[*a, *b]),
        Op::Or(a, b) => call("or", &[*a, *b]),
        Op::Not(a) => call("not", &[*a]),
        Op::Select(m, a, b) => call("if", &[*m, *a, *b]),
        // Effects have no value.
        Op::Kill(_) | Op::AddTo(..) | Op::MaxTo(..) | Op::PutHistory(..) => atom(""),
    }
}

fn atom(text: impl Into<String>) -> Shown {
    (text.into(), Tight::Atom)
}

fn power(base: String, n: i32) -> Shown {
    (format!("{base}^{n}"), Tight::Power)
}

/// The name of a node quantity.
pub fn quantity(spec: &Spec, slot: u32) -> String {
    match spec.slots.get(slot as usize) {
        Some(SlotSpec { name, kind, .. }) => match kind {
            SlotKind::Velocity(a) | SlotKind::Position(a) | SlotKind::Increment(a) => {
                format!("{name}_{}", axis(*a))
            }
            _ => name.clone(),
        },
        None => format!("q{slot}"),
    }
}

/// The name of a direction.
pub fn axis(a: u8) -> char {
    ['x', 'y', 'z'].get(a as usize).copied().unwrap_or('?')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parentheses_stand_where_they_are_needed() {
        let (x, c) = (Op::X, Op::Const(0));
        let ops = vec![
            x,
            c,
            Op::Sub(0, 1),
            Op::Mul(2, 2),
            Op::Div(0, 3),
            Op::Sub(0, 2),
        ];
        let tape = Tape { ops, outs: vec![4] };
        let text = "model m \"t\" cite \"a, eq. 1\" { param K : pressure \"k\"  energy W = K*sum(s^2)/ball(1) }";
        let law = crate::front::file(text);
        assert!(!law.has_errors(), "{:?}", law.diagnostics);
        let spec =
            crate::assemble::spec(&law.laws[0], 1, crate::assemble::Kinematics::General).unwrap();
        let shown = |r| formula(&tape, r, &spec, None);
        assert_eq!(shown(4), "x/(x - c0)^2");
        assert_eq!(shown(5), "x - (x - c0)");
    }
}
