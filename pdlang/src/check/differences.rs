//! PD105: a difference of two equal values.

use crate::ast::{self, Expr, ExprKind, Item, Model};
use crate::diag::Diagnostic;
use crate::ir::BinaryOp;

const CODE: &str = "PD105";

/// Warns of every `C - C` that a model writes.
pub(crate) fn warn(model: &Model, report: &mut Vec<Diagnostic>) {
    for item in &model.items {
        match item {
            Item::Definition(definition) => look(&definition.expr, report),
            Item::Weight(weight) => look(&weight.expr, report),
            Item::Response(response) => look(&response.expr, report),
            Item::Update(update) => look(&update.expr, report),
            Item::AfterStep(after) => look(&after.expr, report),
            Item::Break(breaking) => look(&breaking.when, report),
            Item::Family(family) => look(&family.filter, report),
            Item::Field(ast::Field {
                lives: Some(when), ..
            }) => look(when, report),
            _ => {}
        }
    }
}

fn look(expr: &Expr, report: &mut Vec<Diagnostic>) {
    use ExprKind::*;
    if let Binary(BinaryOp::Sub, left, right) = &expr.kind
        && same(left, right)
    {
        let (other, this) = match &left.kind {
            Name(name) => (format!("{name}'"), name.as_str()),
            _ => ("C'".into(), "C"),
        };
        report.push(
            Diagnostic::warning(CODE, "this is zero whatever the values are")
                .at(expr.span, "a difference of two equal values")
                .help(format!(
                    "the other end is written with a prime: `{other} - {this}`"
                )),
        );
    }
    match &expr.kind {
        Number(..) | Name(_) => {}
        Call { args, .. } => args.iter().for_each(|arg| look(&arg.value, report)),
        Neg(a) | Not(a) | Prime(a) | Component(a, _) => look(a, report),
        Binary(_, a, b) | Compare(_, a, b) => {
            look(a, report);
            look(b, report);
        }
        Vector(parts) => parts.iter().for_each(|part| look(part, report)),
        Case(arms) => arms.iter().for_each(|(_, arm)| look(arm, report)),
    }
}

/// Whether two expressions are written alike, wherever they stand.
fn same(a: &Expr, b: &Expr) -> bool {
    use ExprKind::*;
    match (&a.kind, &b.kind) {
        (Name(a), Name(b)) => a == b,
        (Neg(a), Neg(b)) | (Prime(a), Prime(b)) => same(a, b),
        (Component(a, axes), Component(b, others)) => axes.text == others.text && same(a, b),
        (Binary(op, a, b), Binary(other, c, d)) => op == other && same(a, c) && same(b, d),
        (Vector(a), Vector(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        (Number(v, None), Number(w, None)) => v == w,
        (
            Call { name, family, args },
            Call {
                name: other,
                family: others,
                args: values,
            },
        ) => {
            let text = |f: &Option<crate::ast::Name>| f.as_ref().map(|f| f.text.clone());
            name.text == other.text
                && text(family) == text(others)
                && args.len() == values.len()
                && args
                    .iter()
                    .zip(values)
                    .all(|(a, b)| same(&a.value, &b.value))
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn differences_of_equal_values_are_zero() {
        let field = "field C : number \"C\" rate C";
        refuse(
            &format!("{field} = sum((C - C)/x)/(1 m^2)/(1 s)"),
            "PD105",
            "C - C",
        );
        refuse(
            &format!("{field} = mean(max(C', s) - max(C', s))/(1 s)"),
            "PD105",
            "max(C', s) - max(C', s)",
        );
        accept(&format!("{field} = mean(C' - C)/(1 s)"));
        accept(&format!("{field} = (mean(C') - mean(C - s))/(1 s)"));
    }
}
