//! PD008: components that a value does not have.

use crate::ast::Name;
use crate::check::shape_name;
use crate::diag::Diagnostic;
use crate::ir::{Expr, Shape};
use crate::span::Span;

const CODE: &str = "PD008";

/// Zero-based indices of `v.x`, `F.xy`.
pub(crate) fn indices(value: &Expr, axes: &Name) -> Result<Vec<u8>, Box<Diagnostic>> {
    let indices: Option<Vec<u8>> = axes
        .text
        .chars()
        .map(|axis| "xyz".find(axis).map(|k| k as u8))
        .collect();
    let wanted = match value.shape {
        Shape::Vector => 1,
        Shape::Tensor | Shape::Symmetric => 2,
        Shape::Scalar | Shape::Boolean => {
            let finding = no_components(value, axes);
            return Err(Box::new(match is_exponent(&axes.text) {
                true => finding.help(format!("a number with an exponent: `1.0{}`", axes.text)),
                false => finding,
            }));
        }
    };
    match indices {
        Some(indices) if indices.len() == wanted => Ok(indices),
        _ => Err(Box::new(unknown(value, axes))),
    }
}

/// `(a, b, c)` where there are no vectors.
pub(crate) fn outside_of_law(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "vectors have a meaning in laws only").at(span, "a vector")
}

pub(crate) fn too_many(span: Span, found: usize) -> Diagnostic {
    Diagnostic::error(CODE, format!("a vector of {found} components"))
        .at(span, "there are no more than three dimensions")
        .help("in fewer dimensions, the components that are too many are left out")
}

fn no_components(value: &Expr, axes: &Name) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!(
            "{} has no component `{}`",
            shape_name(value.shape),
            axes.text
        ),
    )
    .at(axes.span, "")
    .at(value.span, shape_name(value.shape))
}

/// `1.e5` is read as a component of 1.
fn is_exponent(axes: &str) -> bool {
    let digits = axes.strip_prefix(['e', 'E']);
    digits.is_some_and(|d| !d.is_empty() && d.bytes().all(|b| b.is_ascii_digit()))
}

fn unknown(value: &Expr, axes: &Name) -> Diagnostic {
    let known = if value.shape == Shape::Vector {
        "`x`, `y` and `z`"
    } else {
        "`xx`, `xy` and so on to `zz`"
    };
    no_components(value, axes).help(format!(
        "the components of {} are {known}",
        shape_name(value.shape)
    ))
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn knows_the_components() {
        refuse("bond b = xi.w", "PD008", "w");
        refuse("bond b = xi.xx", "PD008", "xx");
        refuse("bond b = x.x", "PD008", "x");
        refuse("bond b = outer(xi, Y).x", "PD008", "x");
        accept("bond b = xi.x + outer(xi, Y).xy/(1 m) + xi'.z");
    }
}
