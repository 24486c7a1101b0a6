//! PD013: a unit where only a number makes sense.

use crate::diag::Diagnostic;
use crate::ir::Expr;

const CODE: &str = "PD013";

pub(crate) fn has_unit(what: &str, found: &Expr, unit: &str) -> Diagnostic {
    Diagnostic::error(CODE, format!("{what} must be a pure number"))
        .at(found.span, format!("unit: {unit}"))
        .help("divide by a quantity of the same unit")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn functions_take_numbers() {
        refuse("bond b = exp(-x)", "PD013", "-x");
        refuse("bond b = 2^x", "PD013", "x");
        refuse(
            "node b = det(sum(outer(xi, Y)))",
            "PD013",
            "sum(outer(xi, Y))",
        );
        accept("bond b = exp(-(x/delta)^2)*sin(5 deg)");
    }
}
