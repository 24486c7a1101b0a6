//! Walking trees: what a written expression mentions, and what a typed one is made of.

use crate::ast;
use crate::ir::{ExprId, ExprKind};

/// Every name that a written expression mentions: values, families and influence functions, not functions.
pub(crate) fn mentioned(expr: &ast::Expr, found: &mut Vec<String>) {
    use ast::ExprKind::*;
    match &expr.kind {
        Number(..) => {}
        Name(text) => found.push(text.clone()),
        Call { family, args, .. } => {
            found.extend(family.iter().map(|name| name.text.clone()));
            args.iter().for_each(|arg| mentioned(&arg.value, found));
        }
        Neg(a) | Not(a) | Prime(a) | Component(a, _) => mentioned(a, found),
        Binary(_, a, b) | Compare(_, a, b) => {
            mentioned(a, found);
            mentioned(b, found);
        }
        Vector(parts) => parts.iter().for_each(|part| mentioned(part, found)),
        Case(arms) => arms.iter().for_each(|(_, arm)| mentioned(arm, found)),
    }
}

/// The direct operands of an expression; a definition has none.
pub(crate) fn operands(kind: &ExprKind) -> Vec<ExprId> {
    use ExprKind::*;
    match kind {
        Neg(a) | Not(a) | Component(a, _) | Reduce(_, _, a) | Ball(a) | Prime(a) => vec![*a],
        Binary(_, a, b) | Compare(_, a, b) => vec![*a, *b],
        Call(_, args) | Vector(args) => args.clone(),
        Case(arms) => arms.to_vec(),
        _ => Vec::new(),
    }
}

/// The same expression of other operands, in the order of [`operands`].
pub(crate) fn with_operands(kind: &ExprKind, parts: &[ExprId]) -> ExprKind {
    use ExprKind::*;
    match kind {
        Neg(_) => Neg(parts[0]),
        Not(_) => Not(parts[0]),
        Component(_, axes) => Component(parts[0], axes.clone()),
        Reduce(reduction, family, _) => Reduce(*reduction, *family, parts[0]),
        Ball(_) => Ball(parts[0]),
        Prime(_) => Prime(parts[0]),
        Binary(op, ..) => Binary(*op, parts[0], parts[1]),
        Compare(op, ..) => Compare(*op, parts[0], parts[1]),
        Call(builtin, _) => Call(*builtin, parts.to_vec()),
        Vector(_) => Vector(parts.to_vec()),
        Case(_) => Case(std::array::from_fn(|k| parts[k])),
        leaf => leaf.clone(),
    }
}

/// Every name that a written expression mentions, functions too.
pub(crate) fn called(expr: &ast::Expr, found: &mut Vec<String>) {
    use ast::ExprKind::*;
    match &expr.kind {
        Number(..) => {}
        Name(text) => found.push(text.clone()),
        Call { name, args, .. } => {
            found.push(name.text.clone());
            args.iter().for_each(|arg| called(&arg.value, found));
        }
        Neg(a) | Not(a) | Prime(a) | Component(a, _) => called(a, found),
        Binary(_, a, b) | Compare(_, a, b) => {
            called(a, found);
            called(b, found);
        }
        Vector(parts) => parts.iter().for_each(|part| called(part, found)),
        Case(arms) => arms.iter().for_each(|(_, arm)| called(arm, found)),
    }
}
