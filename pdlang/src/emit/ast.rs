//! The tree of a model: one item per line, every operation in parentheses.

use crate::ast::*;
use crate::ir::{BinaryOp, CompareOp, Home, Shape};

pub(super) fn model(model: &Model) -> String {
    let mut text = format!("model {}\n", model.name.text);
    if let Some(title) = &model.title {
        text += &format!("  title {:?}\n", title.text);
    }
    for cite in &model.cites {
        text += &format!("  cite {:?}\n", cite.text);
    }
    for written in &model.items {
        text += &format!("  {}\n", item(written));
    }
    text
}

fn item(item: &Item) -> String {
    match item {
        Item::Influence(slot) => {
            let default = slot.default.as_ref().map(|d| format!(" = {}", expr(d)));
            format!(
                "influence {}{}",
                slot.name.text,
                default.unwrap_or_default()
            )
        }
        Item::Param(param) => format!(
            "param {} : {}{}{}{}",
            param.name.text,
            kind(&param.kind),
            param.bounds.iter().map(bound).collect::<String>(),
            param
                .default
                .as_ref()
                .map(|d| format!(" = {}", quantity(d)))
                .unwrap_or_default(),
            doc(&param.doc)
                + &param
                    .meet
                    .as_ref()
                    .map(|m| format!(" meets {}", expr(m)))
                    .unwrap_or_default(),
        ),
        Item::Definition(d) => {
            let home = match d.home {
                Home::Constant => "let",
                Home::Node => "node",
                Home::Bond => "bond",
            };
            format!(
                "{home} {}{} = {}",
                d.name.text,
                annotation(d.annotation.as_ref()),
                expr(&d.expr)
            )
        }
        Item::Response(r) => format!(
            "{}{} {}{} = {}",
            format!("{:?}", r.kind).to_lowercase(),
            family(&r.family),
            r.name.text,
            annotation(r.annotation.as_ref()),
            expr(&r.expr)
        ),
        Item::Field(f) => format!(
            "field {}{}{}{}{}",
            f.name.text,
            annotation(Some(&f.annotation)),
            if f.half { " at half" } else { "" },
            f.lives
                .as_ref()
                .map(|when| format!(" where {}", expr(when)))
                .unwrap_or_default(),
            doc(&f.doc)
        ),
        Item::History(h) => format!(
            "history {}{}{} on {}{}{}",
            h.name.text,
            annotation(Some(&h.annotation)),
            h.initial
                .as_ref()
                .map(|q| format!(" = {}", quantity(q)))
                .unwrap_or_default(),
            if h.home == Home::Bond { "bond" } else { "node" },
            family(&h.family),
            doc(&h.doc),
        ),
        Item::Update(u) => format!("update {} = {}", u.name.text, expr(&u.expr)),
        Item::Family(f) => format!(
            "family {} = {} where {}",
            f.name.text,
            f.base.text,
            expr(&f.filter)
        ),
        Item::Weight(w) => format!("weight {} = {}{}", w.name.text, expr(&w.expr), doc(&w.doc)),
        Item::Break(b) => format!(
            "break{}{} when {}",
            family(&b.family),
            if b.after { " after" } else { "" },
            expr(&b.when)
        ),
        Item::AfterStep(a) => format!("after step {} = {}", a.name.text, expr(&a.expr)),
        Item::Known(k) => {
            let checks: Vec<&str> = k.checks.iter().map(|c| c.text.as_str()).collect();
            format!("known {} {:?}", checks.join(", "), k.reason.text)
        }
        Item::Probe(p) => probe(p),
    }
}

fn probe(probe: &Probe) -> String {
    let mut text = format!("probe {} in {}", probe.name.text, probe.flavour.text);
    for (k, set) in probe.settings.iter().enumerate() {
        text += if k == 0 { " where " } else { ", " };
        text += &setting(set);
    }
    for line in &probe.lines {
        text += "\n    ";
        text += &match line {
            ProbeLine::Let(name, value) => format!("let {} = {}", name.text, expr(value)),
            ProbeLine::Node {
                name,
                position,
                settings,
            } => {
                format!(
                    "node {} = {}{}",
                    name.text,
                    components(position),
                    rest(settings)
                )
            }
            ProbeLine::Lattice {
                spacing, settings, ..
            } => {
                format!("lattice {}{}", expr(spacing), rest(settings))
            }
            ProbeLine::Cut(a, b) => format!("break ({}, {})", a.text, b.text),
            ProbeLine::Expect(e) => {
                let names: Vec<&str> = e.place.iter().map(|n| n.text.as_str()).collect();
                let place = if names.is_empty() {
                    String::new()
                } else {
                    format!("({})", names.join(", "))
                };
                let rate = if e.rate { "rate " } else { "" };
                let within = e.within.as_ref().map(|w| format!(" within {}", expr(w)));
                format!(
                    "expect {rate}{}{place} = {}{}",
                    e.name.text,
                    components(&e.value),
                    within.unwrap_or_default()
                )
            }
        };
    }
    text
}

fn rest(settings: &[Setting]) -> String {
    settings
        .iter()
        .map(|set| format!(", {}", setting(set)))
        .collect()
}

fn setting(setting: &Setting) -> String {
    format!("{} = {}", setting.name.text, components(&setting.value))
}

fn components(value: &Components) -> String {
    let row = |row: &Vec<Expr>| {
        let parts: Vec<String> = row.iter().map(expr).collect();
        format!("({})", parts.join(", "))
    };
    match value.rows.as_slice() {
        [one] if one.len() == 1 => expr(&one[0]),
        [one] => row(one),
        rows => format!("({})", rows.iter().map(row).collect::<Vec<_>>().join(", ")),
    }
}

fn doc(doc: &Option<Text>) -> String {
    doc.as_ref()
        .map(|d| format!(" {:?}", d.text))
        .unwrap_or_default()
}

fn family(family: &Option<Name>) -> String {
    family
        .as_ref()
        .map(|f| format!("[{}]", f.text))
        .unwrap_or_default()
}

fn annotation(annotation: Option<&Annotation>) -> String {
    let Some(a) = annotation else {
        return String::new();
    };
    let shape = a.shape.map(|s| match s {
        Shape::Vector => "vector",
        Shape::Symmetric => "symmetric",
        Shape::Tensor => "tensor",
        _ => "scalar",
    });
    let parts: Vec<String> = shape
        .map(String::from)
        .into_iter()
        .chain(a.kind.as_ref().map(kind))
        .collect();
    format!(" : {}", parts.join(" "))
}

fn kind(kind: &Kind) -> String {
    match kind {
        Kind::Named(name) => name.text.clone(),
        Kind::Unit(u) => format!("[{}]", unit(u)),
    }
}

/// A product of powers: `kg*m^-3`.
pub(super) fn unit(unit: &UnitExpr) -> String {
    let factor = |(name, power): &(Name, f64)| match *power {
        1.0 => name.text.clone(),
        n => format!("{}^{n}", name.text),
    };
    let factors: Vec<String> = unit.factors.iter().map(factor).collect();
    if factors.is_empty() {
        "1".into()
    } else {
        factors.join("*")
    }
}

pub(super) fn quantity(q: &Quantity) -> String {
    let unit = q.unit.as_ref().map(|u| format!(" [{}]", unit(u)));
    format!("{}{}", q.value, unit.unwrap_or_default())
}

fn bound(bound: &Bound) -> String {
    match bound {
        Bound::Side(op, q) => format!(" {} {}", compare(*op), quantity(q)),
        Bound::Interval {
            lower,
            lower_in,
            upper,
            upper_in,
            ..
        } => format!(
            " in {}{}, {}{}",
            if *lower_in { '[' } else { '(' },
            quantity(lower),
            quantity(upper),
            if *upper_in { ']' } else { ')' }
        ),
    }
}

pub(super) fn compare(op: CompareOp) -> &'static str {
    match op {
        CompareOp::Lt => "<",
        CompareOp::Le => "<=",
        CompareOp::Gt => ">",
        CompareOp::Ge => ">=",
    }
}

pub(super) fn binary(op: BinaryOp) -> &'static str {
    match op {
        BinaryOp::Add => " + ",
        BinaryOp::Sub => " - ",
        BinaryOp::Mul => "*",
        BinaryOp::Div => "/",
        BinaryOp::Pow => "^",
        BinaryOp::And => " and ",
        BinaryOp::Or => " or ",
    }
}

fn expr(e: &Expr) -> String {
    match &e.kind {
        ExprKind::Number(value, None) => value.to_string(),
        ExprKind::Number(value, Some(u)) => format!("{value} [{}]", unit(u)),
        ExprKind::Name(name) => name.clone(),
        ExprKind::Call {
            name,
            family: f,
            args,
        } => {
            let argument = |a: &Argument| match &a.name {
                Some(name) => format!("{} = {}", name.text, expr(&a.value)),
                None => expr(&a.value),
            };
            let args: Vec<String> = args.iter().map(argument).collect();
            format!("{}{}({})", name.text, family(f), args.join(", "))
        }
        ExprKind::Neg(a) => format!("(-{})", expr(a)),
        ExprKind::Not(a) => format!("(not {})", expr(a)),
        ExprKind::Binary(op, a, b) => format!("({}{}{})", expr(a), binary(*op), expr(b)),
        ExprKind::Compare(op, a, b) => format!("({} {} {})", expr(a), compare(*op), expr(b)),
        ExprKind::Vector(parts) => {
            let parts: Vec<String> = parts.iter().map(expr).collect();
            format!("({})", parts.join(", "))
        }
        ExprKind::Component(a, axes) => format!("{}.{}", expr(a), axes.text),
        ExprKind::Prime(a) => format!("{}'", expr(a)),
        ExprKind::Case(arms) => {
            let arms: Vec<String> = arms
                .iter()
                .map(|(f, a)| format!("{}: {}", f.text, expr(a)))
                .collect();
            format!("case flavour {{ {} }}", arms.join(", "))
        }
    }
}
