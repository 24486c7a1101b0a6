//! PD016: a declared shape or unit is not what stands behind it.

use crate::ast::Annotation;
use crate::check::shape_name;
use crate::diag::Diagnostic;
use crate::ir::{Expr, Shape};

const CODE: &str = "PD016";

pub(crate) fn wrong_shape(annotation: &Annotation, declared: Shape, found: &Expr) -> Diagnostic {
    let finding = Diagnostic::error(
        CODE,
        format!(
            "declared as {}, but it is {}",
            shape_name(declared),
            shape_name(found.shape)
        ),
    )
    .at(annotation.span, shape_name(declared))
    .at(found.span, shape_name(found.shape));
    match (declared, found.shape) {
        (Shape::Symmetric, Shape::Tensor) => {
            finding.help("take the symmetric part with `sym(..)`, or declare a `tensor`")
        }
        _ => finding,
    }
}

pub(crate) fn wrong_unit(
    annotation: &Annotation,
    declared: &str,
    found: &Expr,
    unit: &str,
) -> Diagnostic {
    Diagnostic::error(CODE, "declared in another unit than it has")
        .at(annotation.span, format!("declared: {declared}"))
        .at(found.span, format!("found: {unit}"))
}

/// Shapes that a declaration admits: a symmetric tensor is a tensor.
pub(crate) fn admits(declared: Shape, found: Shape) -> bool {
    declared == found || (declared, found) == (Shape::Tensor, Shape::Symmetric)
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn declarations_are_kept() {
        refuse("bond b : vector = x", "PD016", ": vector");
        refuse("bond b : pressure = x", "PD016", ": pressure");
        refuse(
            "bond b : vector pressure = xi",
            "PD016",
            ": vector pressure",
        );
        accept("bond b : vector length = xi bond c : tensor = outer(xi, xi) let d : scalar = 1");
        accept("let zero : pressure = 0");
    }
}
