//! PD007: scalars, vectors and tensors that do not fit together.

use crate::check::shape_name;
use crate::diag::Diagnostic;
use crate::ir::{Expr, Shape};

const CODE: &str = "PD007";

/// `op` is a sign such as `+`, or words.
pub(crate) fn unlike(op: &str, left: &Expr, right: &Expr) -> Diagnostic {
    let message = match op {
        "+" => format!(
            "{} and {} have no sum",
            shape_name(left.shape),
            shape_name(right.shape)
        ),
        "-" => format!(
            "{} and {} have no difference",
            shape_name(left.shape),
            shape_name(right.shape)
        ),
        what => format!("{what} have different shapes"),
    };
    both(message, left, right)
}

pub(crate) fn no_product(left: &Expr, right: &Expr) -> Diagnostic {
    let finding = both(
        format!(
            "{} times {} is not defined",
            shape_name(left.shape),
            shape_name(right.shape)
        ),
        left,
        right,
    );
    match (left.shape, right.shape) {
        (Shape::Vector, Shape::Vector) => {
            finding.help("`dot(a, b)` is a scalar, `outer(a, b)` a tensor")
        }
        _ => finding.help(
            "a tensor stands to the left of the vector it acts on; `transpose(A)*v` is v times A",
        ),
    }
}

fn both(message: String, left: &Expr, right: &Expr) -> Diagnostic {
    Diagnostic::error(CODE, message)
        .at(right.span, shape_name(right.shape))
        .at(left.span, shape_name(left.shape))
}

pub(crate) fn no_power(base: &Expr) -> Diagnostic {
    let finding = Diagnostic::error(CODE, format!("{} has no powers", shape_name(base.shape)))
        .at(base.span, shape_name(base.shape));
    match base.shape {
        Shape::Vector => finding.help("the square of the length is `dot(v, v)`"),
        Shape::Tensor | Shape::Symmetric => finding.help("a product of tensors is written `A*A`"),
        _ => finding,
    }
}

pub(crate) fn not_a(what: &str, wanted: Shape, found: &Expr) -> Diagnostic {
    let finding = Diagnostic::error(CODE, format!("{what} must be {}", shape_name(wanted)))
        .at(found.span, format!("this is {}", shape_name(found.shape)));
    match (wanted, found.shape) {
        (Shape::Scalar, Shape::Vector) => {
            finding.help("the length of a vector is `norm(v)`, a component `v.x`")
        }
        (Shape::Scalar, Shape::Symmetric | Shape::Tensor) => {
            finding.help("scalars of a tensor are `tr(A)`, `det(A)` and components such as `A.xy`")
        }
        _ => finding,
    }
}

pub(crate) fn condition_as_value(op: &str, found: &Expr) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("{} cannot be applied to a condition", quoted(op)),
    )
    .at(found.span, "this is true or false")
    .help("a number that depends on a condition is `select(condition, a, b)`")
}

pub(crate) fn value_as_condition(op: &str, found: &Expr) -> Diagnostic {
    Diagnostic::error(CODE, format!("{} needs a condition", quoted(op)))
        .at(found.span, format!("this is {}", shape_name(found.shape)))
        .help("a condition is a comparison, such as `s > s0`")
}

fn quoted(op: &str) -> String {
    if op.contains(' ') {
        op.into()
    } else {
        format!("`{op}`")
    }
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn tells_scalars_vectors_and_tensors_apart() {
        refuse("bond b = xi + x", "PD007", "x");
        refuse("bond b = xi*eta", "PD007", "eta");
        refuse("bond b = xi*outer(xi, xi)", "PD007", "outer(xi, xi)");
        refuse("bond b = x/xi", "PD007", "xi");
        refuse("bond b = xi^2", "PD007", "xi");
        refuse("bond b = dot(xi, x)", "PD007", "x");
        refuse("bond b = tr(xi)", "PD007", "xi");
        refuse("bond b = exp(I)", "PD007", "I");
        refuse("state T = I*1 [N/m^6]", "PD007", "I*1 [N/m^6]");
    }

    #[test]
    fn tells_conditions_from_values() {
        refuse("bond b = (s > 0) + 1", "PD007", "s > 0");
        refuse("break when s", "PD007", "s");
        refuse("bond b = not x", "PD007", "x");
        accept("break when not (s > 0 and e < 1 mm) or x > delta");
    }

    #[test]
    fn knows_what_is_symmetric() {
        accept("bond a : symmetric = outer(Y, Y) bond b : symmetric = outer(xi + eta, xi + eta)");
        accept("node a : symmetric = inverse(sum(outer(xi, xi))) node b : tensor = a*a");
        refuse("bond b : symmetric = outer(xi, Y)", "PD016", ": symmetric");
        refuse(
            "node b : symmetric = sum(outer(xi, xi))*sum(outer(xi, xi))",
            "PD016",
            ": symmetric",
        );
    }
}
