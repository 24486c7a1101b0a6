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

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn both_sides_agree() {
        refuse("bond b = x + s", "PD012", "s");
        refuse("bond b = e - 0.5", "PD012", "0.5");
        refuse("break when e > 0.1", "PD012", "0.1");
        refuse("let c = max(K, delta)", "PD012", "delta");
        refuse("bond b = select(s > 0, x, s)", "PD012", "s");
        refuse("node b = sum(omega) + sum(1)", "PD012", "sum(1)");
    }

    #[test]
    fn the_value_of_a_function_is_where_it_is_called() {
        refuse("let c = 1 - K_d(K, K)", "PD012", "K_d(K, K)");
        refuse("let c = K_d(K, K) - 1", "PD012", "1");
    }

    #[test]
    fn zero_and_infinity_fit_all() {
        accept("bond b = max(0, e) + 0 bond c = min(e, inf) break when e > 0");
        refuse("bond b = e + 0 s", "PD012", "0 s");
    }
}
