//! PD013: a unit where only a number makes sense.

use crate::diag::Diagnostic;
use crate::ir::Expr;

const CODE: &str = "PD013";

pub(crate) fn has_unit(what: &str, found: &Expr, unit: &str) -> Diagnostic {
    Diagnostic::error(CODE, format!("{what} must be a pure number"))
        .at(found.span, format!("unit: {unit}"))
        .help("divide by a quantity of the same unit")
}
