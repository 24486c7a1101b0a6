//! Scalar expressions of scenes and influence functions as tapes.

use pdlang::ir::{self, BinaryOp, Builtin, CompareOp, Expr, ExprId, ExprKind};
use pdlang_runtime::spec::{self, Number, Op, ParamSpec, Tape};

/// The tape of one expression; `None` when it holds what a number cannot depend on.
pub fn expression(exprs: &[Expr], root: ExprId) -> Option<Tape> {
    let mut tape = Tape::default();
    let out = walk(exprs, root, &mut tape)?;
    tape.outs.push(out);
    Some(tape)
}

/// An influence function for the runtime.
pub fn influence(function: &ir::InfluenceFn) -> Option<spec::InfluenceFn> {
    Some(spec::InfluenceFn {
        name: function.name.clone(),
        params: function.params.iter().map(parameter).collect(),
        body: expression(&function.exprs, function.body)?,
    })
}

fn parameter(param: &ir::Param) -> ParamSpec {
    let bound = |b: Option<ir::Bound>| b.map(|b| (b.value, b.inclusive));
    ParamSpec {
        name: param.name.clone(),
        doc: param.doc.clone(),
        unit: if param.unit.is_number() { String::new() } else { param.unit.symbol() },
        exponents: param.unit.base,
        lower: bound(param.lower),
        upper: bound(param.upper),
        default: param.default.map(number),
    }
}

fn number(value: f64) -> Number {
    if value.is_finite() { Number::Finite(value) } else { Number::Infinite }
}

fn walk(exprs: &[Expr], id: ExprId, tape: &mut Tape) -> Option<u32> {
    let op = match &exprs.get(id.index())?.kind {
        ExprKind::Number(v) if v.is_finite() => Op::Lit(*v),
        ExprKind::Number(_) => Op::Inf,
        ExprKind::Pi => Op::Lit(std::f64::consts::PI),
        ExprKind::Var(k) => Op::Var(*k),
        ExprKind::Delta => Op::Delta,
        ExprKind::Neg(a) => Op::Neg(walk(exprs, *a, tape)?),
        ExprKind::Not(a) => Op::Not(walk(exprs, *a, tape)?),
        ExprKind::Binary(op, a, b) => return binary(exprs, *op, *a, *b, tape),
        ExprKind::Compare(op, a, b) => {
            let (a, b) = (walk(exprs, *a, tape)?, walk(exprs, *b, tape)?);
            match op {
                CompareOp::Lt => Op::Lt(a, b),
                CompareOp::Le => Op::Le(a, b),
                CompareOp::Gt => Op::Lt(b, a),
                CompareOp::Ge => Op::Le(b, a),
            }
        }
        ExprKind::Call(function, arguments) => {
            let registers: Option<Vec<u32>> =
                arguments.iter().map(|a| walk(exprs, *a, tape)).collect();
            call(*function, &registers?)?
        }
        _ => return None,
    };
    Some(push(tape, op))
}

fn push(tape: &mut Tape, op: Op) -> u32 {
    tape.ops.push(op);
    tape.ops.len() as u32 - 1
}

fn binary(exprs: &[Expr], op: BinaryOp, a: ExprId, b: ExprId, tape: &mut Tape) -> Option<u32> {
    let left = walk(exprs, a, tape)?;
    if op == BinaryOp::Pow
        && let Some(n) = whole(exprs, b)
    {
        return Some(push(tape, Op::Powi(left, n)));
    }
    let right = walk(exprs, b, tape)?;
    let op = match op {
        BinaryOp::Add => Op::Add(left, right),
        BinaryOp::Sub => Op::Sub(left, right),
        BinaryOp::Mul => Op::Mul(left, right),
        BinaryOp::Div => Op::Div(left, right),
        BinaryOp::Pow => Op::Pow(left, right),
        BinaryOp::And => Op::And(left, right),
        BinaryOp::Or => Op::Or(left, right),
    };
    Some(push(tape, op))
}

/// A whole exponent: exact, and defined for negative bases.
fn whole(exprs: &[Expr], id: ExprId) -> Option<i32> {
    match exprs.get(id.index())?.kind {
        ExprKind::Number(v) if v.fract() == 0.0 && v.abs() <= 64.0 => Some(v as i32),
        ExprKind::Neg(a) => whole(exprs, a).map(|n| -n),
        _ => None,
    }
}

fn call(function: Builtin, r: &[u32]) -> Option<Op> {
    Some(match (function, r) {
        (Builtin::Sqrt, [a]) => Op::Sqrt(*a),
        (Builtin::Abs, [a]) => Op::Abs(*a),
        (Builtin::Exp, [a]) => Op::Exp(*a),
        (Builtin::Ln, [a]) => Op::Ln(*a),
        (Builtin::Sin, [a]) => Op::Sin(*a),
        (Builtin::Cos, [a]) => Op::Cos(*a),
        (Builtin::Tan, [a]) => Op::Tan(*a),
        (Builtin::Min, [a, b]) => Op::Min(*a, *b),
        (Builtin::Max, [a, b]) => Op::Max(*a, *b),
        (Builtin::Select, [c, a, b]) => Op::Select(*c, *a, *b),
        _ => return None,
    })
}
