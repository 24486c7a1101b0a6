//! Influence functions: scalar expressions in the reference bond length.

use super::Error;
use crate::ir::{BinaryOp, Builtin, CompareOp, ExprId, ExprKind, InfluenceFn};

/// Value of an influence function at bond length `r` [m], in its own unit.
///
/// # Errors
/// When the function holds what only a law can hold.
pub(super) fn value(f: &InfluenceFn, params: &[f64], r: f64, horizon: f64) -> Result<f64, Error> {
    Reader {
        f,
        params,
        r,
        horizon,
    }
    .number(f.body)
}

struct Reader<'a> {
    f: &'a InfluenceFn,
    params: &'a [f64],
    r: f64,
    horizon: f64,
}

impl Reader<'_> {
    fn number(&self, id: ExprId) -> Result<f64, Error> {
        match &self.f.exprs[id.index()].kind {
            ExprKind::Number(value) => Ok(*value),
            ExprKind::Pi => Ok(std::f64::consts::PI),
            ExprKind::Delta => Ok(self.horizon),
            ExprKind::Var(0) => Ok(self.r),
            ExprKind::Var(k) => self
                .params
                .get(*k as usize - 1)
                .copied()
                .ok_or_else(|| self.refusal()),
            ExprKind::Neg(a) => Ok(-self.number(*a)?),
            ExprKind::Binary(op, a, b) => self.binary(*op, self.number(*a)?, self.number(*b)?),
            ExprKind::Call(builtin, args) => self.call(*builtin, args),
            _ => Err(self.refusal()),
        }
    }

    fn binary(&self, op: BinaryOp, a: f64, b: f64) -> Result<f64, Error> {
        match op {
            BinaryOp::Add => Ok(a + b),
            BinaryOp::Sub => Ok(a - b),
            BinaryOp::Mul => Ok(a * b),
            BinaryOp::Div => Ok(a / b),
            BinaryOp::Pow => Ok(a.powf(b)),
            BinaryOp::And | BinaryOp::Or => Err(self.refusal()),
        }
    }

    fn call(&self, builtin: Builtin, args: &[ExprId]) -> Result<f64, Error> {
        let arg = |k: usize| {
            args.get(k)
                .map_or_else(|| Err(self.refusal()), |a| self.number(*a))
        };
        match builtin {
            Builtin::Sqrt => Ok(arg(0)?.sqrt()),
            Builtin::Abs | Builtin::Norm => Ok(arg(0)?.abs()),
            Builtin::Exp => Ok(arg(0)?.exp()),
            Builtin::Ln => Ok(arg(0)?.ln()),
            Builtin::Sin => Ok(arg(0)?.sin()),
            Builtin::Cos => Ok(arg(0)?.cos()),
            Builtin::Tan => Ok(arg(0)?.tan()),
            Builtin::Min => Ok(arg(0)?.min(arg(1)?)),
            Builtin::Max => Ok(arg(0)?.max(arg(1)?)),
            Builtin::Select if args.len() == 3 => {
                if self.truth(args[0])? {
                    arg(1)
                } else {
                    arg(2)
                }
            }
            _ => Err(self.refusal()),
        }
    }

    fn truth(&self, id: ExprId) -> Result<bool, Error> {
        match &self.f.exprs[id.index()].kind {
            ExprKind::Compare(op, a, b) => {
                let (a, b) = (self.number(*a)?, self.number(*b)?);
                Ok(compare(*op, a, b))
            }
            ExprKind::Not(a) => Ok(!self.truth(*a)?),
            ExprKind::Binary(BinaryOp::And, a, b) => Ok(self.truth(*a)? && self.truth(*b)?),
            ExprKind::Binary(BinaryOp::Or, a, b) => Ok(self.truth(*a)? || self.truth(*b)?),
            _ => Err(self.refusal()),
        }
    }

    fn refusal(&self) -> Error {
        Error(format!(
            "`{}` is not a function of the bond length alone",
            self.f.name
        ))
    }
}

pub(super) fn compare(op: CompareOp, a: f64, b: f64) -> bool {
    match op {
        CompareOp::Lt => a < b,
        CompareOp::Le => a <= b,
        CompareOp::Gt => a > b,
        CompareOp::Ge => a >= b,
    }
}
