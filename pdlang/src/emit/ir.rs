//! A checked law: definitions in the order of need, each with home, shape and unit, functions inlined.

use super::ast::{binary, compare};
use crate::ir::*;
use crate::units::Unit;

pub(super) fn law(law: &Law) -> String {
    let mut text = format!("law {}\n", law.name);
    let mut line = |words: String| text += &format!("  {words}\n");
    for p in &law.params {
        let side = |b: Option<Bound>, strict: &str, loose: &str| {
            b.map(|b| format!(" {} {}", if b.inclusive { loose } else { strict }, b.value))
        };
        let bounds = [side(p.lower, ">", ">="), side(p.upper, "<", "<=")];
        let bounds: String = bounds.into_iter().flatten().collect();
        let default = p.default.map(|v| format!(" = {v}")).unwrap_or_default();
        line(format!(
            "param {} [{}]{bounds}{default}",
            p.name,
            p.unit.symbol()
        ));
    }
    for slot in &law.influences {
        let default = slot.default.as_ref().map(|f| format!(" = {}", f.name));
        line(format!(
            "influence {}{}",
            slot.name,
            default.unwrap_or_default()
        ));
    }
    for family in &law.families {
        let filter = family.filter.map(|f| format!(" where {}", expr(law, f)));
        line(format!(
            "family {}{}",
            family.name,
            filter.unwrap_or_default()
        ));
    }
    for field in &law.fields {
        line(format!(
            "field {} {} [{}]{}{}",
            field.name,
            shape(field.shape),
            field.unit.symbol(),
            if field.half { " at half" } else { "" },
            field
                .lives
                .as_ref()
                .map(|lives| format!(" where {}", expr(law, lives.when)))
                .unwrap_or_default()
        ));
    }
    for h in &law.histories {
        let name = &law.families[h.family.index()].name;
        line(format!(
            "history {} {} {} [{}] of {name} = {}, then {}",
            h.name,
            home(h.home),
            shape(h.shape),
            h.unit.symbol(),
            h.initial,
            expr(law, h.update)
        ));
    }
    for def in &law.defs {
        line(format!(
            "{} {} {} [{}] = {}",
            home(def.home),
            def.name,
            shape(def.shape),
            unit(law, &def.unit),
            expr(law, def.expr)
        ));
    }
    for weight in &law.weights {
        line(format!(
            "weight {} = {}",
            weight.name,
            expr(law, weight.expr)
        ));
    }
    for response in &law.responses {
        let of = |f: &FamilyId| law.families[f.index()].name.clone();
        line(match response {
            Response::Energy(e) => format!("energy = {}", expr(law, *e)),
            Response::Force(e) => format!("force = {}", expr(law, *e)),
            Response::Pair(f, e) => format!("pair over {} = {}", of(f), expr(law, *e)),
            Response::State(f, e) => format!("state over {} = {}", of(f), expr(law, *e)),
            Response::Rate(f, e) => {
                format!("rate {} = {}", law.fields[f.index()].name, expr(law, *e))
            }
        });
    }
    for b in &law.breaks {
        let after = if b.after { " after the force" } else { "" };
        let name = &law.families[b.family.index()].name;
        line(format!("break {name}{after} when {}", expr(law, b.when)));
    }
    if let Some(e) = law.after_step {
        line(format!("after step velocity = {}", expr(law, e)));
    }
    for k in &law.knowns {
        line(format!("known {} {:?}", k.check, k.reason));
    }
    for p in &law.probes {
        line(format!(
            "probe {} in {} of {} values",
            p.name,
            p.flavour.name(),
            p.expectations.len()
        ));
    }
    text
}

pub(crate) fn unit(law: &Law, unit: &Unit) -> String {
    let names: Vec<String> = law.influences.iter().map(|i| i.name.clone()).collect();
    unit.describe(&names)
}

pub(crate) fn home(home: Home) -> &'static str {
    match home {
        Home::Constant => "let",
        Home::Node => "node",
        Home::Bond => "bond",
    }
}

pub(crate) fn shape(shape: Shape) -> String {
    format!("{shape:?}").to_lowercase()
}

pub(crate) fn expr(law: &Law, id: ExprId) -> String {
    let e = |id: &ExprId| expr(law, *id);
    match &law.exprs[id.index()].kind {
        ExprKind::Number(v) => v.to_string(),
        ExprKind::Pi => "pi".into(),
        ExprKind::Dim => "dim".into(),
        ExprKind::Delta => "delta".into(),
        ExprKind::TimeStep => "dt".into(),
        ExprKind::Identity => "I".into(),
        ExprKind::Var(k) => format!("var{k}"),
        ExprKind::Param(p) => law.params[p.index()].name.clone(),
        ExprKind::Def(d) => law.defs[d.index()].name.clone(),
        ExprKind::Field(f) => law.fields[f.index()].name.clone(),
        ExprKind::History(h) => law.histories[h.index()].name.clone(),
        ExprKind::Influence(i) => law.influences[i.index()].name.clone(),
        ExprKind::Weight(w) => law.weights[w.index()].name.clone(),
        ExprKind::Xi => "xi".into(),
        ExprKind::Eta => "eta".into(),
        ExprKind::Velocity => "velocity".into(),
        ExprKind::Position => "X".into(),
        ExprKind::Neg(a) => format!("(-{})", e(a)),
        ExprKind::Not(a) => format!("(not {})", e(a)),
        ExprKind::Binary(op, a, b) => format!("({}{}{})", e(a), binary(*op), e(b)),
        ExprKind::Compare(op, a, b) => format!("({} {} {})", e(a), compare(*op), e(b)),
        ExprKind::Call(builtin, args) => {
            let args: Vec<String> = args.iter().map(e).collect();
            format!(
                "{}({})",
                format!("{builtin:?}").to_lowercase(),
                args.join(", ")
            )
        }
        ExprKind::Vector(parts) => {
            let parts: Vec<String> = parts.iter().map(e).collect();
            format!("({})", parts.join(", "))
        }
        ExprKind::Component(a, axes) => {
            let axes: String = axes
                .iter()
                .map(|k| ["x", "y", "z"].get(*k as usize).copied().unwrap_or("?"))
                .collect();
            format!("{}.{axes}", e(a))
        }
        ExprKind::Reduce(r, family, a) => {
            let name = match family.index() {
                0 => String::new(),
                k => format!("[{}]", law.families[k].name),
            };
            format!("{}{name}({})", format!("{r:?}").to_lowercase(), e(a))
        }
        ExprKind::Ball(a) => format!("ball({})", e(a)),
        ExprKind::Prime(a) => format!("{}'", e(a)),
        ExprKind::Case(arms) => {
            let arms: Vec<String> = Flavour::ALL
                .iter()
                .zip(arms)
                .map(|(f, a)| format!("{}: {}", f.name(), e(a)))
                .collect();
            format!("case {{ {} }}", arms.join(", "))
        }
    }
}
