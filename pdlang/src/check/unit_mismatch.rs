//! PD012: units that differ where they must agree.

use crate::diag::Diagnostic;
use crate::ir::{CompareOp, Expr};

const CODE: &str = "PD012";

/// Both sides with their units in words. `op` is a sign, a function, or words.
pub(crate) fn between(op: &str, left: (&Expr, &str), right: (&Expr, &str)) -> Diagnostic {
    let message = match op {
        "+" => "a sum of different units".to_string(),
        "-" => "a difference of different units".to_string(),
        "<" | "<=" | ">" | ">=" => "a comparison of different units".to_string(),
        "min" | "max" | "select" => format!("`{op}` of different units"),
        what => format!("{what} have different units"),
    };
    Diagnostic::error(CODE, message)
        .at(right.0.span, format!("unit: {}", right.1))
        .at(left.0.span, format!("unit: {}", left.1))
}

pub(crate) fn symbol(op: CompareOp) -> &'static str {
    match op {
        CompareOp::Lt => "<",
        CompareOp::Le => "<=",
        CompareOp::Gt => ">",
        CompareOp::Ge => ">=",
    }
}
