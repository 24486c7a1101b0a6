//! Scalar expressions of scenes and influence functions -> tape, as written, without normal form.

use crate::ir::{BinaryOp, Builtin, CompareOp, Expr, ExprId, ExprKind};
use crate::poly::Func;
use crate::sweep::function;
use crate::tape::{Builder, Op, Tape};

/// The tape of a scalar expression in variables, the horizon and numbers.
pub fn tape(exprs: &[Expr], root: ExprId) -> Tape {
    let mut b = Builder::default();
    let r = value(&mut b, exprs, root);
    b.out(r);
    b.tape
}

fn value(b: &mut Builder, exprs: &[Expr], id: ExprId) -> u32 {
    match &exprs[id.index()].kind {
        ExprKind::Number(v) => b.lit(*v),
        ExprKind::Pi => b.lit(std::f64::consts::PI),
        ExprKind::Delta => b.op(Op::Delta),
        ExprKind::Var(k) => b.op(Op::Var(*k)),
        ExprKind::Param(p) => b.op(Op::Param(p.0)),
        ExprKind::Neg(a) => {
            let a = value(b, exprs, *a);
            b.op(Op::Neg(a))
        }
        ExprKind::Not(a) => {
            let a = value(b, exprs, *a);
            b.op(Op::Not(a))
        }
        ExprKind::Binary(op, p, q) => binary(b, exprs, *op, *p, *q),
        ExprKind::Compare(op, p, q) => {
            let (p, q) = (value(b, exprs, *p), value(b, exprs, *q));
            b.op(match op {
                CompareOp::Lt => Op::Lt(p, q),
                CompareOp::Le => Op::Le(p, q),
                CompareOp::Gt => Op::Lt(q, p),
                CompareOp::Ge => Op::Le(q, p),
            })
        }
        ExprKind::Call(f, args) => {
            let args: Vec<u32> = args.iter().map(|a| value(b, exprs, *a)).collect();
            call(b, *f, &args)
        }
        // The front admits nothing else in such an expression.
        _ => b.lit(0.0),
    }
}

fn binary(b: &mut Builder, exprs: &[Expr], op: BinaryOp, p: ExprId, q: ExprId) -> u32 {
    let left = value(b, exprs, p);
    if let (BinaryOp::Pow, ExprKind::Number(n)) = (op, &exprs[q.index()].kind)
        && n.fract() == 0.0
        && n.abs() <= 64.0
    {
        return b.op(Op::Powi(left, *n as i32));
    }
    let right = value(b, exprs, q);
    b.op(match op {
        BinaryOp::Add => Op::Add(left, right),
        BinaryOp::Sub => Op::Sub(left, right),
        BinaryOp::Mul => Op::Mul(left, right),
        BinaryOp::Div => Op::Div(left, right),
        BinaryOp::Pow => Op::Pow(left, right),
        BinaryOp::And => Op::And(left, right),
        BinaryOp::Or => Op::Or(left, right),
    })
}

fn call(b: &mut Builder, f: Builtin, r: &[u32]) -> u32 {
    let f = match f {
        Builtin::Sqrt => Func::Sqrt,
        Builtin::Abs | Builtin::Norm => Func::Abs,
        Builtin::Exp => Func::Exp,
        Builtin::Ln => Func::Ln,
        Builtin::Sin => Func::Sin,
        Builtin::Cos => Func::Cos,
        Builtin::Tan => Func::Tan,
        Builtin::Min => Func::Min,
        Builtin::Max => Func::Max,
        Builtin::Select => Func::Select,
        _ => return b.lit(0.0),
    };
    function(b, f, r, false)
}
