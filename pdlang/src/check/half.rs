//! PD041: a field at half steps that cannot be stepped.

use crate::ast::Name;
use crate::damping;
use crate::diag::Diagnostic;
use crate::ir::{Law, Response};

const CODE: &str = "PD041";

pub(crate) fn without_rate(field: &Name) -> Diagnostic {
    let name = &field.text;
    Diagnostic::error(
        CODE,
        format!("the field `{name}` at half steps has no rate"),
    )
    .at(field.span, "what the scene sets stays as it is")
    .help(format!(
        "leave out `at half`, or give it a `rate {name} = ..`"
    ))
}

/// Fields at half steps whose rate reads what is not known where it is evaluated.
pub(crate) fn unstaggered(law: &Law) -> Vec<Diagnostic> {
    let one = |id: crate::ir::FieldId| {
        let field = &law.fields[id.index()];
        let rate = law.responses.iter().find_map(|r| match r {
            Response::Rate(f, e) if *f == id => Some(law.exprs[e.index()].span),
            _ => None,
        });
        let name = &field.name;
        Diagnostic::error(
            CODE,
            format!("the rate of `{name}` reads what is not known at full steps"),
        )
        .at(
            rate.unwrap_or(field.span),
            "a velocity, a field at half steps, or more of itself than a linear damping",
        )
        .at(field.span, "at half steps")
        .help(format!(
            "the rate of a field at half steps is made of displacements and of fields at full steps, less a damping times `{name}` itself, component by component"
        ))
    };
    damping::unstaggered(law).into_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn fields_at_half_steps_have_rates_of_full_steps() {
        let q = |rate: &str| format!("field q : vector velocity at half \"q\" {rate}");
        accept(&q("rate q = mean(eta)/(1 s)^2 - q/(1 s)"));
        refuse(&q("bond b = q"), "PD041", "q");
        for rate in ["velocity/(1 s)", "mean(q')/(1 s)", "norm(q)*q/(1 m)"] {
            refuse(&q(&format!("rate q = {rate}")), "PD041", rate);
        }
    }
}
