//! PD026: `under` of what a uniform displacement gradient does not determine.

use crate::check::shape_name;
use crate::diag::Diagnostic;
use crate::ir::Expr;
use crate::span::Span;

const CODE: &str = "PD026";

pub(crate) fn outside_of_law(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "`under` has a meaning in laws only")
        .at(span, "there is no displacement here")
}

pub(crate) fn no_tensor(gradient: &Expr) -> Diagnostic {
    Diagnostic::error(CODE, "a displacement gradient is a tensor")
        .at(gradient.span, shape_name(gradient.shape))
        .help("`diag((1, 0, 0))` is a stretch along x, `outer((1, 0, 0), (0, 1, 0))` a shear")
}

pub(crate) fn unit(gradient: &Expr, unit: &str) -> Diagnostic {
    Diagnostic::error(CODE, "a displacement gradient has no unit")
        .at(gradient.span, format!("this is in {unit}"))
}

pub(crate) fn not_uniform(gradient: &Expr) -> Diagnostic {
    Diagnostic::error(
        CODE,
        "the gradient of `under` is the same in the whole body",
    )
    .at(gradient.span, "this differs from node to node")
    .help("write a constant tensor")
}

pub(crate) fn undetermined(span: Span, name: &str, through: Option<&str>) -> Diagnostic {
    let read = match through {
        Some(definition) => format!("`{definition}` reads `{name}`"),
        None => format!("this reads `{name}`"),
    };
    Diagnostic::error(CODE, format!("a gradient does not determine `{name}`"))
        .at(span, read)
        .help("`under` evaluates what depends on the reference body and the displacement alone")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn a_gradient_determines_what_depends_on_the_displacement_alone() {
        refuse("bond b = under(I, edot)", "PD026", "edot");
        refuse(
            "field T : temperature \"T\" node b = under(I, T*sum(e))",
            "PD026",
            "T*sum(e)",
        );
        refuse("node b = under(I, dt)", "PD026", "dt");
        refuse(
            "history h : length = 0 on bond \"h\" update h = e bond r = h + e node b = under(I, sum(r))",
            "PD026",
            "sum(r)",
        );
        accept(
            "node t = sum(omega*e) node b = under(I/1000, t) bond c = under(diag((1, 0, 0)), (t' - t)*norm(X))",
        );
    }

    #[test]
    fn a_gradient_is_a_constant_tensor() {
        refuse("bond b = under(1, e)", "PD026", "1");
        refuse("bond b = under(outer(xi, xi), e)", "PD026", "outer(xi, xi)");
        refuse(
            "bond b = under(outer(xi, xi)/x^2, e)",
            "PD026",
            "outer(xi, xi)/x^2",
        );
        refuse("influence a = under(x, x)", "PD026", "under(x, x)");
    }
}
