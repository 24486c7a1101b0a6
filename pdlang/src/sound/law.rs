//! The checked law: ids that exist, definitions before use, and shapes, homes and units that follow from the operands.

use super::Report;
use crate::ir::{BinaryOp, Builtin, Expr, ExprId, ExprKind, Home, Law, Reduction, Response, Shape};
use crate::resolve::walk::operands;
use crate::units::Unit;

/// What is wrong with a checked law.
#[must_use]
pub fn law(law: &Law) -> Vec<String> {
    let mut report = Report::default();
    order(&mut report, law);
    // What follows walks down and would not end.
    if !report.found.is_empty() {
        return report.found;
    }
    for (k, e) in law.exprs.iter().enumerate() {
        report.at(format!("expression {k} ({:?})", e.kind));
        let Some((shape, home, unit)) = follows(&mut report, law, e) else {
            continue;
        };
        if home != e.home {
            report.add(format!("lives at {:?}, not {home:?}", e.home));
        }
        if !shapes_agree(shape, e.shape) {
            report.add(format!("is {:?}, not {shape:?}", e.shape));
        }
        if let Some(unit) = unit.filter(|u| *u != e.unit) {
            let (found, meant) = (e.unit.symbol(), unit.symbol());
            report.add(format!("is in {found}, not {meant}"));
        }
    }
    for def in &law.defs {
        report.at(format!("`{}`", def.name));
        let value = &law.exprs[def.expr.index()];
        if value.home > def.home || !shapes_agree(value.shape, def.shape) {
            report.add("its value has another home or shape".into());
        }
        same_unit(&mut report, law, def.expr, &def.unit);
    }
    answers(&mut report, law);
    report.found
}

/// Operands stand before an expression, definitions before those that need them.
fn order(report: &mut Report, law: &Law) {
    for (k, e) in law.exprs.iter().enumerate() {
        if operands(&e.kind).iter().any(|id| id.index() >= k) {
            report.at(format!("expression {k} ({:?})", e.kind));
            report.add("an operand comes later".into());
        }
    }
    if !report.found.is_empty() {
        return;
    }
    for (k, def) in law.defs.iter().enumerate() {
        report.at(format!("`{}`", def.name));
        let mut todo = vec![def.expr];
        while let Some(id) = todo.pop() {
            let kind = &law.exprs[id.index()].kind;
            if matches!(kind, ExprKind::Def(d) if d.index() >= k) {
                report.add("needs a definition that comes later".into());
            }
            todo.extend(operands(kind));
        }
    }
}

/// A general tensor may be declared symmetric where its structure says so, and the other way round.
fn shapes_agree(a: Shape, b: Shape) -> bool {
    let tensor = |s| matches!(s, Shape::Symmetric | Shape::Tensor);
    a == b || tensor(a) && tensor(b)
}

/// Zero and infinity fit any unit.
fn any_unit(law: &Law, id: ExprId) -> bool {
    match &law.exprs[id.index()].kind {
        ExprKind::Number(v) => *v == 0.0 || v.is_infinite(),
        ExprKind::Neg(a) => any_unit(law, *a),
        ExprKind::Binary(BinaryOp::Add | BinaryOp::Sub, a, b) => {
            any_unit(law, *a) && any_unit(law, *b)
        }
        ExprKind::Def(d) => any_unit(law, law.defs[d.index()].expr),
        ExprKind::Vector(parts) => parts.iter().all(|a| any_unit(law, *a)),
        ExprKind::Case(arms) => arms.iter().all(|a| any_unit(law, *a)),
        ExprKind::Call(Builtin::Min | Builtin::Max, args) => args.iter().all(|a| any_unit(law, *a)),
        ExprKind::Call(Builtin::Select, args) => args[1..].iter().all(|a| any_unit(law, *a)),
        _ => false,
    }
}

fn same_unit(report: &mut Report, law: &Law, id: ExprId, unit: &Unit) {
    let found = &law.exprs[id.index()].unit;
    if found != unit && !any_unit(law, id) {
        report.add(format!(
            "a value in {} where {} is meant",
            found.symbol(),
            unit.symbol()
        ));
    }
}

/// The unit of values that must be alike.
fn common(report: &mut Report, law: &Law, ids: &[ExprId]) -> Option<Unit> {
    let mut known = ids.iter().filter(|id| !any_unit(law, **id));
    let unit = law.exprs[known.next()?.index()].unit.clone();
    for id in known {
        same_unit(report, law, *id, &unit);
    }
    Some(unit)
}

type Facts = (Shape, Home, Option<Unit>);

/// What an expression must be, by its operands; no unit where any would do.
fn follows(report: &mut Report, law: &Law, e: &Expr) -> Option<Facts> {
    use ExprKind::*;
    let number = Some(Unit::NUMBER);
    let of = |id: &ExprId| &law.exprs[id.index()];
    let operands = operands(&e.kind);
    let home = operands
        .iter()
        .map(|id| of(id).home)
        .max()
        .unwrap_or(Home::Constant);
    let (bond, node) = (Home::Bond, Home::Node);
    let known = match &e.kind {
        Number(_) => (Shape::Scalar, Home::Constant, None),
        Pi | Dim => (Shape::Scalar, Home::Constant, number),
        Delta => (Shape::Scalar, Home::Constant, Some(Unit::length())),
        Identity => (Shape::Symmetric, Home::Constant, number),
        Var(_) => return None,
        Param(p) => {
            let p = named(report, law.params.get(p.index()))?;
            (Shape::Scalar, Home::Constant, Some(p.unit.clone()))
        }
        Def(d) => {
            let d = named(report, law.defs.get(d.index()))?;
            (d.shape, d.home, Some(d.unit.clone()))
        }
        Field(f) => {
            let f = named(report, law.fields.get(f.index()))?;
            (f.shape, node, Some(f.unit.clone()))
        }
        History(h) => {
            let h = named(report, law.histories.get(h.index()))?;
            (h.shape, h.home, Some(h.unit.clone()))
        }
        Influence(k) => {
            named(report, law.influences.get(k.index()))?;
            (Shape::Scalar, bond, Some(Unit::opaque(k.0)))
        }
        Weight(w) => {
            named(report, law.weights.get(w.index()))?;
            (Shape::Scalar, bond, number)
        }
        Vector(parts) => {
            if parts.iter().any(|part| of(part).shape != Shape::Scalar) {
                report.add("has components that are no scalars".into());
            }
            (Shape::Vector, home, common(report, law, parts))
        }
        Xi | Eta => (Shape::Vector, bond, Some(Unit::length())),
        Velocity => (Shape::Vector, node, Some(Unit::velocity())),
        Position => (Shape::Vector, node, Some(Unit::length())),
        TimeStep => (Shape::Scalar, node, Some(Unit::time())),
        Neg(a) => (of(a).shape, home, Some(of(a).unit.clone())),
        Not(_) => (Shape::Boolean, home, number),
        Compare(_, a, b) => {
            common(report, law, &[*a, *b]);
            (Shape::Boolean, home, number)
        }
        Binary(op, a, b) => (e.shape, home, binary(report, law, *op, *a, *b)),
        Component(a, _) => (Shape::Scalar, home, Some(of(a).unit.clone())),
        Reduce(r, family, a) => {
            if family.index() >= law.families.len() || of(a).home == node {
                report.add("sums over nothing".into());
            }
            let unit = match r {
                Reduction::Sum | Reduction::Sum0 => of(a).unit.times(&Unit::volume()),
                Reduction::Count => Unit::NUMBER,
                _ => of(a).unit.clone(),
            };
            let shape = if *r == Reduction::Count {
                Shape::Scalar
            } else {
                of(a).shape
            };
            (shape, node, Some(unit))
        }
        Ball(a) => (
            Shape::Scalar,
            Home::Constant,
            Some(of(a).unit.times(&Unit::volume())),
        ),
        Prime(a) => (of(a).shape, bond, Some(of(a).unit.clone())),
        Case(arms) => (e.shape, home, common(report, law, arms)),
        Call(f, args) => (e.shape, home, call(report, law, *f, args)),
    };
    Some(known)
}

/// What an id names.
fn named<T>(report: &mut Report, found: Option<T>) -> Option<T> {
    if found.is_none() {
        report.add("names what does not exist".into());
    }
    found
}

fn binary(report: &mut Report, law: &Law, op: BinaryOp, a: ExprId, b: ExprId) -> Option<Unit> {
    let of = |id: ExprId| &law.exprs[id.index()];
    match op {
        BinaryOp::Add | BinaryOp::Sub => common(report, law, &[a, b]),
        BinaryOp::Mul => Some(of(a).unit.times(&of(b).unit)),
        BinaryOp::Div => Some(of(a).unit.per(&of(b).unit)),
        BinaryOp::And | BinaryOp::Or => Some(Unit::NUMBER),
        BinaryOp::Pow if of(a).unit.is_number() => Some(Unit::NUMBER),
        BinaryOp::Pow => None,
    }
}

fn call(report: &mut Report, law: &Law, f: Builtin, args: &[ExprId]) -> Option<Unit> {
    let unit = |k: usize| law.exprs[args[k].index()].unit.clone();
    Some(match f {
        Builtin::Dot | Builtin::Outer => unit(0).times(&unit(1)),
        Builtin::Inverse => unit(0).inverse(),
        Builtin::Sqrt => unit(0).power(0.5)?,
        Builtin::Det | Builtin::Exp | Builtin::Ln | Builtin::Sin | Builtin::Cos | Builtin::Tan => {
            same_unit(report, law, args[0], &Unit::NUMBER);
            Unit::NUMBER
        }
        Builtin::Min | Builtin::Max => return common(report, law, args),
        Builtin::Select => return common(report, law, &args[1..]),
        Builtin::Norm
        | Builtin::Trace
        | Builtin::Sym
        | Builtin::Dev
        | Builtin::Transpose
        | Builtin::Diag
        | Builtin::Abs => unit(0),
    })
}

/// Units and homes of what the law answers; the unit of an influence function has cancelled.
fn answers(report: &mut Report, law: &Law) {
    report.at("answer".into());
    let mut answer = |id: ExprId, most: Home, unit: Unit, shapes: &[Shape]| {
        let e = &law.exprs[id.index()];
        if e.home > most || !shapes.iter().any(|s| shapes_agree(*s, e.shape)) {
            report.add(format!("a {:?} of home {:?}", e.shape, e.home));
        }
        same_unit(report, law, id, &unit);
    };
    let (scalar, node, bond) = ([Shape::Scalar], Home::Node, Home::Bond);
    for r in &law.responses {
        match r {
            Response::Energy(e) => answer(*e, node, Unit::energy_density(), &scalar),
            Response::Pair(_, e) => answer(*e, bond, Unit::bond_force(), &scalar),
            Response::State(_, e) => {
                answer(
                    *e,
                    bond,
                    Unit::bond_force(),
                    &[Shape::Scalar, Shape::Vector],
                );
            }
            Response::Force(e) => answer(*e, node, Unit::force_density(), &[Shape::Vector]),
            Response::Rate(f, e) => {
                let field = &law.fields[f.index()];
                answer(*e, node, field.unit.per(&Unit::time()), &[field.shape]);
            }
        }
    }
    if let Some(velocity) = law.after_step {
        answer(velocity, node, Unit::velocity(), &[Shape::Vector]);
    }
    for h in &law.histories {
        answer(h.update, h.home, h.unit.clone(), &[h.shape]);
    }
    for w in &law.weights {
        answer(w.expr, bond, Unit::NUMBER, &scalar);
    }
    for b in &law.breaks {
        answer(b.when, bond, Unit::NUMBER, &[Shape::Boolean]);
    }
    for lives in law.fields.iter().filter_map(|f| f.lives.as_ref()) {
        answer(lives.when, node, Unit::NUMBER, &[Shape::Boolean]);
    }
    for filter in law.families.iter().filter_map(|f| f.filter) {
        answer(filter, bond, Unit::NUMBER, &[Shape::Boolean]);
    }
}
