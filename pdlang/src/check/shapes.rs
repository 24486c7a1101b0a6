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
