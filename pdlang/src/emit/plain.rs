//! Written expressions as text of the language, with no more parentheses than they need.

use crate::ast::{Argument, Expr, ExprKind};
use crate::ir::{BinaryOp, CompareOp};

/// How tightly an expression holds together, loosest first.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Tight {
    Or,
    And,
    Not,
    Compare,
    Sum,
    Product,
    Power,
    Atom,
}

pub(super) fn expr(e: &Expr) -> String {
    tight(e).0
}

fn at_least(e: &Expr, wanted: Tight) -> String {
    match tight(e) {
        (text, tight) if tight >= wanted => text,
        (text, _) => format!("({text})"),
    }
}

fn tight(e: &Expr) -> (String, Tight) {
    match &e.kind {
        ExprKind::Number(value, None) => (number(*value), Tight::Atom),
        ExprKind::Number(value, Some(unit)) => (
            format!("{} {}", number(*value), self::unit(unit)),
            Tight::Product,
        ),
        ExprKind::Name(name) => (name.clone(), Tight::Atom),
        ExprKind::Call { name, family, args } => {
            let family = family.as_ref().map(|f| format!("[{}]", f.text));
            let args: Vec<String> = args.iter().map(argument).collect();
            let family = family.unwrap_or_default();
            (
                format!("{}{family}({})", name.text, args.join(", ")),
                Tight::Atom,
            )
        }
        ExprKind::Neg(a) => (format!("-{}", at_least(a, Tight::Product)), Tight::Sum),
        ExprKind::Not(a) => (format!("not {}", at_least(a, Tight::Compare)), Tight::Not),
        ExprKind::Binary(op, a, b) => binary(*op, a, b),
        ExprKind::Compare(op, a, b) => {
            let sign = match op {
                CompareOp::Lt => "<",
                CompareOp::Le => "<=",
                CompareOp::Gt => ">",
                CompareOp::Ge => ">=",
            };
            let (a, b) = (at_least(a, Tight::Sum), at_least(b, Tight::Sum));
            (format!("{a} {sign} {b}"), Tight::Compare)
        }
        ExprKind::Vector(parts) => {
            let parts: Vec<String> = parts.iter().map(expr).collect();
            (format!("({})", parts.join(", ")), Tight::Atom)
        }
        ExprKind::Component(a, axes) => (
            format!("{}.{}", at_least(a, Tight::Atom), axes.text),
            Tight::Atom,
        ),
        ExprKind::Prime(a) => (format!("{}'", at_least(a, Tight::Atom)), Tight::Atom),
        ExprKind::Case(arms) => {
            let arm = |(flavour, value): &(crate::ast::Name, Expr)| {
                format!("{}: {}", flavour.text, expr(value))
            };
            let arms: Vec<String> = arms.iter().map(arm).collect();
            (
                format!("case flavour {{ {} }}", arms.join(", ")),
                Tight::Atom,
            )
        }
    }
}

fn argument(a: &Argument) -> String {
    match &a.name {
        Some(name) => format!("{} = {}", name.text, expr(&a.value)),
        None => expr(&a.value),
    }
}

fn binary(op: BinaryOp, a: &Expr, b: &Expr) -> (String, Tight) {
    let (sign, own, left, right) = match op {
        BinaryOp::Add => (" + ", Tight::Sum, Tight::Sum, Tight::Product),
        BinaryOp::Sub => (" - ", Tight::Sum, Tight::Sum, Tight::Product),
        BinaryOp::Mul => ("*", Tight::Product, Tight::Product, Tight::Power),
        BinaryOp::Div => ("/", Tight::Product, Tight::Product, Tight::Power),
        BinaryOp::Pow => ("^", Tight::Power, Tight::Atom, Tight::Atom),
        BinaryOp::And => (" and ", Tight::And, Tight::And, Tight::Not),
        BinaryOp::Or => (" or ", Tight::Or, Tight::Or, Tight::And),
    };
    (
        format!("{}{sign}{}", at_least(a, left), at_least(b, right)),
        own,
    )
}

pub(super) fn number(value: f64) -> String {
    match value {
        _ if value == f64::INFINITY => "inf".into(),
        _ if value == f64::NEG_INFINITY => "-inf".into(),
        _ if value == 0.0 || (1e-3..1e6).contains(&value.abs()) => value.to_string(),
        _ => format!("{value:e}"),
    }
}

fn unit(unit: &crate::ast::UnitExpr) -> String {
    let one = |(name, power): &(crate::ast::Name, f64)| match power.abs() {
        1.0 => name.text.clone(),
        n => format!("{}^{n}", name.text),
    };
    let part = |sign: f64| -> Vec<String> {
        let factors = unit.factors.iter().filter(|(_, power)| power * sign > 0.0);
        factors.map(one).collect()
    };
    let above = part(1.0).join("*");
    let above = if above.is_empty() { "1".into() } else { above };
    part(-1.0)
        .into_iter()
        .fold(above, |text, below| format!("{text}/{below}"))
}
