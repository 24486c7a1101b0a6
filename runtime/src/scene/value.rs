//! The value of an expression that has no variables left.

use crate::spec::{Op, Tape};

/// NaN where the tape reads something that a constant cannot read.
pub(super) fn of(tape: &Tape) -> f64 {
    let mut registers: Vec<f64> = Vec::with_capacity(tape.ops.len());
    for op in &tape.ops {
        let value = operation(op, &registers);
        registers.push(value);
    }
    tape.outs.first().and_then(|r| registers.get(*r as usize)).copied().unwrap_or(f64::NAN)
}

fn operation(op: &Op, registers: &[f64]) -> f64 {
    let r = |k: u32| registers.get(k as usize).copied().unwrap_or(f64::NAN);
    let truth = |t: bool| f64::from(u8::from(t));
    match *op {
        Op::Lit(v) => v,
        Op::Inf => f64::INFINITY,
        Op::Add(a, b) => r(a) + r(b),
        Op::Sub(a, b) => r(a) - r(b),
        Op::Mul(a, b) => r(a) * r(b),
        Op::Div(a, b) => r(a) / r(b),
        Op::Fma(a, b, c) => r(a).mul_add(r(b), r(c)),
        Op::Neg(a) => -r(a),
        Op::Abs(a) => r(a).abs(),
        Op::Min(a, b) => r(a).min(r(b)),
        Op::Max(a, b) => r(a).max(r(b)),
        Op::Sqrt(a) => r(a).sqrt(),
        Op::Rsqrt(a) => 1.0 / r(a).sqrt(),
        Op::Exp(a) => r(a).exp(),
        Op::Ln(a) => r(a).ln(),
        Op::Sin(a) => r(a).sin(),
        Op::Cos(a) => r(a).cos(),
        Op::Tan(a) => r(a).tan(),
        Op::Pow(a, b) => r(a).powf(r(b)),
        Op::Powi(a, n) => r(a).powi(n),
        Op::Lt(a, b) => truth(r(a) < r(b)),
        Op::Le(a, b) => truth(r(a) <= r(b)),
        Op::And(a, b) => r(a).min(r(b)),
        Op::Or(a, b) => r(a).max(r(b)),
        Op::Not(a) => 1.0 - r(a),
        Op::Select(c, a, b) => r(if r(c) > 0.5 { a } else { b }),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_computed() {
        let ops = vec![Op::Lit(3.0), Op::Lit(4.0), Op::Mul(0, 0), Op::Fma(1, 1, 2), Op::Sqrt(3)];
        assert_eq!(of(&Tape { ops, outs: vec![4] }), 5.0);
    }

    #[test]
    fn what_is_not_constant_has_no_value() {
        assert!(of(&Tape { ops: vec![Op::Var(0)], outs: vec![0] }).is_nan());
        assert!(of(&Tape::default()).is_nan());
    }
}
