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
