//! Numbers of a probe: scalar expressions of values that are known.

use crate::ir::{BinaryOp, Builtin, CompareOp, Expr, ExprId, ExprKind, Flavour};

/// What an expression is evaluated with: one value per variable, and the flavour of the probe.
pub(crate) struct Known<'a> {
    pub exprs: &'a [Expr],
    pub values: &'a [f64],
    pub flavour: Flavour,
}

impl Known<'_> {
    /// SI value; `None` for what is no number.
    pub(crate) fn number(&self, id: ExprId) -> Option<f64> {
        match &self.exprs[id.index()].kind {
            ExprKind::Number(value) => Some(*value),
            ExprKind::Pi => Some(std::f64::consts::PI),
            ExprKind::Var(k) => self.values.get(*k as usize).copied(),
            ExprKind::Neg(a) => Some(-self.number(*a)?),
            ExprKind::Binary(op, a, b) => {
                let (a, b) = (self.number(*a)?, self.number(*b)?);
                match op {
                    BinaryOp::Add => Some(a + b),
                    BinaryOp::Sub => Some(a - b),
                    BinaryOp::Mul => Some(a * b),
                    BinaryOp::Div => Some(a / b),
                    BinaryOp::Pow => Some(a.powf(b)),
                    BinaryOp::And | BinaryOp::Or => None,
                }
            }
            ExprKind::Call(builtin, args) => self.call(*builtin, args),
            ExprKind::Case(arms) => self.number(arms[self.flavour as usize]),
            _ => None,
        }
    }

    fn call(&self, builtin: Builtin, args: &[ExprId]) -> Option<f64> {
        let arg = |k: usize| self.number(*args.get(k)?);
        match builtin {
            Builtin::Sqrt => Some(arg(0)?.sqrt()),
            Builtin::Abs => Some(arg(0)?.abs()),
            Builtin::Exp => Some(arg(0)?.exp()),
            Builtin::Ln => Some(arg(0)?.ln()),
            Builtin::Sin => Some(arg(0)?.sin()),
            Builtin::Cos => Some(arg(0)?.cos()),
            Builtin::Tan => Some(arg(0)?.tan()),
            Builtin::Min => Some(arg(0)?.min(arg(1)?)),
            Builtin::Max => Some(arg(0)?.max(arg(1)?)),
            Builtin::Select => arg(if self.truth(*args.first()?)? { 1 } else { 2 }),
            _ => None,
        }
    }

    fn truth(&self, id: ExprId) -> Option<bool> {
        match &self.exprs[id.index()].kind {
            ExprKind::Compare(op, a, b) => {
                let (a, b) = (self.number(*a)?, self.number(*b)?);
                Some(match op {
                    CompareOp::Lt => a < b,
                    CompareOp::Le => a <= b,
                    CompareOp::Gt => a > b,
                    CompareOp::Ge => a >= b,
                })
            }
            ExprKind::Not(a) => Some(!self.truth(*a)?),
            ExprKind::Binary(BinaryOp::And, a, b) => Some(self.truth(*a)? && self.truth(*b)?),
            ExprKind::Binary(BinaryOp::Or, a, b) => Some(self.truth(*a)? || self.truth(*b)?),
            _ => None,
        }
    }
}
