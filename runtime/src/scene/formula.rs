//! Expressions as tapes: named expressions put in their places, and the value of what has no variables left.

use crate::spec::{Op, Tape};
use crate::tape::Function;

/// `tape` with `Var(first + k)` replaced by the k-th of `named`.
pub(super) fn splice(tape: &Tape, first: u32, named: &[&Tape]) -> Tape {
    let mut ops = Vec::with_capacity(tape.ops.len());
    let mut places: Vec<Option<u32>> = vec![None; named.len()];
    let mut moved: Vec<u32> = Vec::with_capacity(tape.ops.len());
    for op in &tape.ops {
        let inner = match op {
            Op::Var(k) => k.checked_sub(first).filter(|k| (*k as usize) < named.len()),
            _ => None,
        };
        let register = match inner {
            Some(k) => {
                let k = k as usize;
                *places[k].get_or_insert_with(|| append(&mut ops, named[k]))
            }
            None => {
                ops.push(renumbered(op, |r| {
                    moved.get(r as usize).copied().unwrap_or(r)
                }));
                ops.len() as u32 - 1
            }
        };
        moved.push(register);
    }
    let outs = tape
        .outs
        .iter()
        .filter_map(|r| moved.get(*r as usize).copied())
        .collect();
    Tape { ops, outs }
}

/// Appends all of `tape`; the register of its output.
fn append(ops: &mut Vec<Op>, tape: &Tape) -> u32 {
    let offset = ops.len() as u32;
    ops.extend(tape.ops.iter().map(|op| renumbered(op, |r| r + offset)));
    tape.outs.first().map_or(offset, |r| r + offset)
}

/// The operation with other registers; scalar operations only, which is what expressions hold.
fn renumbered(op: &Op, r: impl Fn(u32) -> u32) -> Op {
    match *op {
        Op::Add(a, b) => Op::Add(r(a), r(b)),
        Op::Sub(a, b) => Op::Sub(r(a), r(b)),
        Op::Mul(a, b) => Op::Mul(r(a), r(b)),
        Op::Div(a, b) => Op::Div(r(a), r(b)),
        Op::Fma(a, b, c) => Op::Fma(r(a), r(b), r(c)),
        Op::Neg(a) => Op::Neg(r(a)),
        Op::Abs(a) => Op::Abs(r(a)),
        Op::Min(a, b) => Op::Min(r(a), r(b)),
        Op::Max(a, b) => Op::Max(r(a), r(b)),
        Op::Sqrt(a) => Op::Sqrt(r(a)),
        Op::Rsqrt(a) => Op::Rsqrt(r(a)),
        Op::Exp(a) => Op::Exp(r(a)),
        Op::Ln(a) => Op::Ln(r(a)),
        Op::Sin(a) => Op::Sin(r(a)),
        Op::Cos(a) => Op::Cos(r(a)),
        Op::Tan(a) => Op::Tan(r(a)),
        Op::Pow(a, b) => Op::Pow(r(a), r(b)),
        Op::Powi(a, n) => Op::Powi(r(a), n),
        Op::Lt(a, b) => Op::Lt(r(a), r(b)),
        Op::Le(a, b) => Op::Le(r(a), r(b)),
        Op::And(a, b) => Op::And(r(a), r(b)),
        Op::Or(a, b) => Op::Or(r(a), r(b)),
        Op::Not(a) => Op::Not(r(a)),
        Op::Select(c, a, b) => Op::Select(r(c), r(a), r(b)),
        ref other => other.clone(),
    }
}

/// The largest variable that a tape reads.
pub(super) fn last_variable(tape: &Tape) -> Option<u32> {
    tape.ops
        .iter()
        .filter_map(|op| if let Op::Var(k) = op { Some(*k) } else { None })
        .max()
}

/// NaN where the tape reads something that a constant cannot read.
pub(super) fn value(tape: &Tape) -> f64 {
    Function::new(tape, 0).map_or(f64::NAN, |f| f.call(&[]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_computed() {
        let ops = vec![
            Op::Lit(3.0),
            Op::Lit(4.0),
            Op::Mul(0, 0),
            Op::Fma(1, 1, 2),
            Op::Sqrt(3),
        ];
        assert_eq!(value(&Tape { ops, outs: vec![4] }), 5.0);
    }

    #[test]
    fn a_named_expression_takes_its_place() {
        let square = Tape {
            ops: vec![Op::Var(0), Op::Mul(0, 0)],
            outs: vec![1],
        };
        // Var(0) + 2 * Var(1), the second variable being the square of the first.
        let ops = vec![
            Op::Var(1),
            Op::Lit(2.0),
            Op::Var(0),
            Op::Mul(1, 0),
            Op::Add(2, 3),
        ];
        let mut spliced = splice(&Tape { ops, outs: vec![4] }, 1, &[&square]);
        assert_eq!(last_variable(&spliced), Some(0));
        for op in &mut spliced.ops {
            if *op == Op::Var(0) {
                *op = Op::Lit(3.0);
            }
        }
        assert_eq!(value(&spliced), 21.0);
    }

    #[test]
    fn what_is_not_constant_has_no_value() {
        assert!(
            value(&Tape {
                ops: vec![Op::Var(0)],
                outs: vec![0]
            })
            .is_nan()
        );
        assert!(value(&Tape::default()).is_nan());
    }
}
