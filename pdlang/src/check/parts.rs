//! PD043: a field on a part of the body that a run could change, or without anything to do there.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD043";

pub(crate) fn changes(field: &Name, span: Span, why: &str) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!(
            "where the field `{}` lives is decided once, at the start, node by node",
            field.text
        ),
    )
    .at(span, why)
    .help("it may depend on fields without a rate, positions, parameters and constants")
}

pub(crate) fn without_rate(field: &Name) -> Diagnostic {
    let name = &field.text;
    Diagnostic::error(
        CODE,
        format!("the field `{name}` on a part of the body has no rate"),
    )
    .at(
        field.span,
        "a coefficient is what the scene sets, zero where it sets none",
    )
    .help(format!(
        "leave out `where ..`, or give it a `rate {name} = ..`"
    ))
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    fn field(condition: &str) -> String {
        format!(
            "field phi : vector frequency \"phi\" field C : number \"C\" rate C = -C/(1 s)
             node theta = mean(s) node fixed = norm(phi)*(1 s)
             field q : number where {condition} \"q\" rate q = theta*norm(phi)"
        )
    }

    #[test]
    fn a_part_of_the_body_is_what_coefficients_positions_and_constants_say() {
        accept(&field("norm(phi) > 0"));
        accept(&field("fixed > 0 and X.x < delta or K > 1 GPa"));
        for (wrong, at) in [
            ("C", "C"),
            ("q", "q"),
            ("theta", "theta"),
            ("dt/(1 s)", "dt"),
            ("mean(x)/(1 m)", "mean(x)"),
            ("sum0(1)/ball(1)", "sum0(1)"),
            ("norm(velocity)/(1 [m/s])", "velocity"),
        ] {
            refuse(&field(&format!("{wrong} > 0")), "PD043", at);
        }
    }

    #[test]
    fn it_is_a_condition_on_nodes() {
        refuse(&field("norm(phi)*(1 s)"), "PD007", "norm(phi)*(1 s)");
        refuse(&field("x > 1 mm"), "PD043", "x");
        refuse(&field("norm(phi') > 0"), "PD043", "phi'");
        refuse(&field("norm(phi) > 1 m"), "PD012", "1 m");
    }

    #[test]
    fn what_lives_there_has_a_rate() {
        refuse(
            "field q : number where X.x > 0 \"q\" bond b = q",
            "PD043",
            "q",
        );
    }
}
