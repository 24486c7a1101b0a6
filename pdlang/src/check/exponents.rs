//! PD014: a power whose unit is unknown.

use crate::diag::Diagnostic;
use crate::ir::Expr;

const CODE: &str = "PD014";

pub(crate) fn unknown(exponent: &Expr, base: &Expr, unit: &str) -> Diagnostic {
    Diagnostic::error(CODE, "the unit of this power is unknown")
        .at(exponent.span, "not a multiple of one half written as a number")
        .at(base.span, format!("unit: {unit}"))
        .help("make the base a pure number, such as `x/delta`; only influence functions may raise a length to any power")
}

pub(crate) fn no_root(found: &Expr, unit: &str) -> Diagnostic {
    Diagnostic::error(CODE, "the unit of this root is unknown")
        .at(found.span, format!("unit: {unit}"))
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn units_have_known_powers() {
        refuse("bond b = x^s", "PD014", "s");
        refuse("bond b = x^0.3", "PD014", "0.3");
        refuse("bond b = x^dim", "PD014", "dim");
        refuse("bond b = sqrt(sqrt(x))", "PD014", "sqrt(x)");
        accept("bond b = x^(1/2) + sqrt(x) bond c = s^dim bond d = x^-2");
    }

    #[test]
    fn influence_functions_raise_lengths_to_any_power() {
        accept("influence a = (x + delta)^(-1.3) influence b = softened(p = 2.5, eps = 1 mm)");
    }
}
