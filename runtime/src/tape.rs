//! Tapes as running code: checked once, packed into few registers, then executed over any lane type.
//!
//! Set-up (constants, geometry, influence functions, filters, expressions of a scene) runs them over `f64`, one by one or
//! at many places at once;
//! a sweep that was not compiled runs them over the lanes of the traversal ([`TapeSweep`]), its bonds in blocks. The
//! lane operations and their order are those that generated code has, so the results are the same to the bit.
mod ball;
mod block;
mod check;
mod exec;
mod many;
mod pack;
mod sweep;

pub(crate) use ball::ball;
pub(crate) use block::Blocks;
pub(crate) use check::{Limits, Place};
pub(crate) use exec::{Leaves, numbers, truth};
pub(crate) use many::Many;
pub(crate) use pack::{Leaf, operands, with_streams};
pub(crate) use sweep::MAX_VALUES;
pub use sweep::TapeSweep;

use crate::body::Flavour;
use crate::kernel::Lane;
use crate::spec::{InfluenceFn, Tape};
use std::fmt;

/// A tape that does not fit its place: an operand before its definition, a wrong type, an unknown input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TapeError(pub String);

impl fmt::Display for TapeError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for TapeError {}

/// A checked tape.
#[derive(Clone, Debug, Default)]
pub struct Code {
    pub(crate) steps: Vec<pack::Step>,
    /// Registers of the outputs.
    pub(crate) outs: Vec<u8>,
    /// How many registers of a kind are in use.
    pub(crate) registers: usize,
    /// What a bond tape finds in its registers.
    pub(crate) filled: pack::Filled,
    /// Tapes under integrals.
    pub(crate) balls: Vec<Code>,
}

/// A function of plain variables: an expression of a scene.
#[derive(Clone, Debug)]
pub struct Function(Code);

impl Function {
    /// Checks a tape that reads `Var(0..variables)` only and has at least one output.
    pub fn new(tape: &Tape, variables: usize) -> Result<Function, TapeError> {
        let limits = Limits {
            variables,
            ..Limits::default()
        };
        let code = Code::new(tape, Place::Expression, &limits, Flavour::Solid)?;
        match code.outs.is_empty() {
            true => Err(TapeError("an expression needs an output".into())),
            false => Ok(Function(code)),
        }
    }

    /// First output; missing variables read 0.
    pub fn call(&self, variables: &[f64]) -> f64 {
        let mut out = [0.0];
        numbers(
            &self.0,
            &mut Variables {
                variables,
                delta: 0.0,
            },
            &mut out,
        );
        out[0]
    }

    /// As many outputs as fit.
    pub fn call_into(&self, variables: &[f64], out: &mut [f64]) {
        numbers(
            &self.0,
            &mut Variables {
                variables,
                delta: 0.0,
            },
            out,
        );
    }
}

struct Variables<'a> {
    variables: &'a [f64],
    delta: f64,
}

impl Leaves<f64> for Variables<'_> {
    #[inline(always)]
    fn leaf(&mut self, leaf: Leaf, k: usize) -> f64 {
        match leaf {
            Leaf::Var => self.variables.get(k).copied().unwrap_or(0.0),
            Leaf::Delta => self.delta,
            _ => 0.0,
        }
    }
}

/// An influence function with its parameter values.
#[derive(Clone, Debug)]
pub struct Influence {
    code: Code,
    variables: Vec<f64>,
    delta: f64,
}

impl Influence {
    /// `values`: one per parameter of the function [SI]; `delta`: the horizon [m].
    pub fn new(function: &InfluenceFn, values: &[f64], delta: f64) -> Result<Influence, TapeError> {
        if values.len() != function.params.len() {
            let (name, n, given) = (&function.name, function.params.len(), values.len());
            return Err(TapeError(format!(
                "influence function `{name}` has {n} parameters, {given} values were given"
            )));
        }
        let limits = Limits {
            variables: 1 + values.len(),
            ..Limits::default()
        };
        let code = Code::new(&function.body, Place::Influence, &limits, Flavour::Solid)
            .map_err(|e| TapeError(format!("influence function `{}`: {e}", function.name)))?;
        if code.outs.len() != 1 {
            return Err(TapeError(format!(
                "influence function `{}` must have one output",
                function.name
            )));
        }
        let mut variables = vec![0.0];
        variables.extend_from_slice(values);
        Ok(Influence {
            code,
            variables,
            delta,
        })
    }

    /// Value at a reference distance [m].
    pub fn at(&self, r: f64) -> f64 {
        let mut out = [0.0];
        numbers(&self.code, &mut AtDistance { of: self, r }, &mut out);
        out[0]
    }
}

struct AtDistance<'a> {
    of: &'a Influence,
    r: f64,
}

impl Leaves<f64> for AtDistance<'_> {
    #[inline(always)]
    fn leaf(&mut self, leaf: Leaf, k: usize) -> f64 {
        match leaf {
            Leaf::Var if k == 0 => self.r,
            Leaf::Var => self.of.variables[k],
            Leaf::Delta => self.of.delta,
            _ => 0.0,
        }
    }
}

/// |v| as set-up computes it for `X`.
pub(crate) fn length(v: [f64; 3], dim: usize) -> f64 {
    length_squared(v, dim).sqrt()
}

/// |v|^2 in the order of [`crate::kernel::norm_squared`].
pub(crate) fn length_squared(v: [f64; 3], dim: usize) -> f64 {
    let mut s = v[0] * v[0];
    for c in &v[1..dim] {
        s = c.fma(*c, s);
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Op;

    fn function(ops: Vec<Op>, out: u32) -> Result<Function, TapeError> {
        Function::new(
            &Tape {
                ops,
                outs: vec![out],
            },
            2,
        )
    }

    #[test]
    fn expressions_of_variables() {
        // x^2 + sin(y), 7 where x < y.
        let ops = vec![
            Op::Var(0),
            Op::Var(1),
            Op::Powi(0, 2),
            Op::Sin(1),
            Op::Add(2, 3),
            Op::Lt(0, 1),
            Op::Lit(7.0),
            Op::Select(5, 6, 4),
        ];
        let f = function(ops, 7).unwrap();
        assert_eq!(f.call(&[2.0, 0.5]), 4.0 + 0.5f64.sin());
        assert_eq!(f.call(&[2.0, 3.0]), 7.0);
    }

    #[test]
    fn registers_are_reused_and_dead_operations_go() {
        // A chain of 1000 additions needs two registers, and the logarithm nobody reads none.
        let mut ops = vec![Op::Var(0), Op::Ln(0)];
        ops.push(Op::Add(0, 0));
        for k in 2..1001 {
            ops.push(Op::Add(k, 0));
        }
        let f = function(ops, 1001).unwrap();
        assert_eq!(f.0.steps.len(), 1001);
        assert_eq!(f.call(&[1.0]), 1001.0);
    }

    #[test]
    fn misfits_are_errors() {
        for (ops, says) in [
            (
                vec![Op::Add(0, 0)],
                "operation 0 reads register 0 before it is defined",
            ),
            (
                vec![Op::Var(2)],
                "operation 0: Var(2) is out of range (there are 2)",
            ),
            (
                vec![Op::Xi(0)],
                "operation 0: Xi(0) may not stand in a Expression tape",
            ),
            (
                vec![Op::Var(0), Op::Not(0)],
                "operation 1 has an operand of the wrong kind",
            ),
            (
                vec![Op::Var(0), Op::Lt(0, 0)],
                "output register 1 is missing or of the wrong kind",
            ),
        ] {
            let out = ops.len() as u32 - 1;
            assert_eq!(function(ops, out).unwrap_err().0, says);
        }
    }
}
