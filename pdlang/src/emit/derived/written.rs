//! Sums of products as expressions of the language: one fraction per product, constants first, sums over bonds last.

use super::algebra::{Atom, Kind, Product, Sum};
use crate::ast::{Argument, Expr, ExprKind, Name};
use crate::ir::{BinaryOp, Home};
use crate::ratio::Ratio;
use crate::span::Span;

fn expr(kind: ExprKind) -> Expr {
    Expr {
        kind,
        span: Span::default(),
    }
}

pub(super) fn named(text: &str) -> Name {
    Name {
        text: text.into(),
        span: Span::default(),
    }
}

pub(super) fn name(text: &str) -> Expr {
    expr(ExprKind::Name(text.into()))
}

pub(super) fn binary(op: BinaryOp, a: Expr, b: Expr) -> Expr {
    expr(ExprKind::Binary(op, Box::new(a), Box::new(b)))
}

pub(super) fn call(function: &str, family: Option<&str>, args: Vec<Expr>) -> Expr {
    let args = args.into_iter();
    expr(ExprKind::Call {
        name: named(function),
        family: family.map(named),
        args: args.map(|value| Argument { name: None, value }).collect(),
    })
}

pub(super) fn prime(a: Expr) -> Expr {
    expr(ExprKind::Prime(Box::new(a)))
}

fn number(value: f64) -> Expr {
    expr(ExprKind::Number(value, None))
}

pub(super) fn sum(sum: &Sum) -> Expr {
    let mut written: Option<Expr> = None;
    // What is added stands before what is taken away.
    let (plus, minus): (Vec<_>, Vec<_>) = sum.0.iter().partition(|p| !p.number.is_negative());
    for p in plus.into_iter().chain(minus) {
        let positive = Product {
            number: if p.number.is_negative() {
                p.number.neg()
            } else {
                p.number
            },
            ..p.clone()
        };
        let term = product(&positive);
        written = Some(match (written, p.number.is_negative()) {
            (None, false) => term,
            (None, true) => expr(ExprKind::Neg(Box::new(term))),
            (Some(before), false) => binary(BinaryOp::Add, before, term),
            (Some(before), true) => binary(BinaryOp::Sub, before, term),
        });
    }
    written.unwrap_or_else(|| number(0.0))
}

/// Constants, values of nodes, values of bonds, sums over bonds.
fn rank(atom: &Atom) -> (bool, Home) {
    let reduces = matches!(&atom.kind, Kind::Call(name, ..) if name == "sum" || name == "sum0");
    (reduces, atom.home)
}

fn product(p: &Product) -> Expr {
    let mut scalars: Vec<&(Atom, Ratio)> = p.scalars.iter().collect();
    scalars.sort_by_key(|(a, _)| rank(a));
    let (above, below): (Vec<_>, Vec<_>) = scalars
        .into_iter()
        .partition(|(_, power)| !power.is_negative());
    let (num, den) = p.number.parts();
    let factors = |number_of: i128, list: &[&(Atom, Ratio)], sign: i64| {
        let mut all: Vec<Expr> = vec![];
        if number_of != 1 {
            all.push(number(number_of as f64));
        }
        all.extend(list.iter().map(|(a, power)| raised(a, *power, sign)));
        all.into_iter().reduce(|a, b| binary(BinaryOp::Mul, a, b))
    };
    // Sums over bonds and tensors stand behind the fraction.
    let (before, sums): (Vec<_>, Vec<_>) = above.into_iter().partition(|(a, _)| !rank(a).0);
    let (above, below) = (factors(num, &before, 1), factors(den, &below, -1));
    let fraction = match (above, below) {
        (Some(a), Some(b)) => Some(binary(BinaryOp::Div, a, b)),
        (None, Some(b)) => Some(binary(BinaryOp::Div, number(1.0), b)),
        (a, None) => a,
    };
    let behind = sums.iter().map(|(a, power)| raised(a, *power, 1));
    let all = fraction
        .into_iter()
        .chain(behind)
        .chain(p.tensors.iter().map(atom));
    let written = all.reduce(|a, b| binary(BinaryOp::Mul, a, b));
    written.unwrap_or_else(|| number(1.0))
}

fn raised(base: &Atom, power: Ratio, sign: i64) -> Expr {
    let power = if sign < 0 { power.neg() } else { power };
    match power.is_one() {
        true => atom(base),
        false => {
            let (num, den) = power.parts();
            let exponent = match den {
                1 => number(num as f64),
                _ => binary(BinaryOp::Div, number(num as f64), number(den as f64)),
            };
            binary(BinaryOp::Pow, atom(base), exponent)
        }
    }
}

fn atom(a: &Atom) -> Expr {
    match &a.kind {
        Kind::Name(text) => name(text),
        Kind::Call(function, family, args) => {
            call(function, family.as_deref(), args.iter().map(sum).collect())
        }
        Kind::Prime(inner) => prime(atom(inner)),
        Kind::Sum(inner) => sum(inner),
        Kind::Power(a, b) => binary(BinaryOp::Pow, sum(a), sum(b)),
        Kind::Component(a, axes) => expr(ExprKind::Component(Box::new(sum(a)), named(axes))),
        Kind::Vector(parts) => expr(ExprKind::Vector(parts.iter().map(sum).collect())),
        Kind::Compare(op, a, b) => expr(ExprKind::Compare(*op, Box::new(sum(a)), Box::new(sum(b)))),
        Kind::Logic(op, a, b) => binary(*op, sum(a), sum(b)),
        Kind::Not(a) => expr(ExprKind::Not(Box::new(sum(a)))),
        Kind::Written(e) => e.clone(),
    }
}
