//! PD050: an influence function that is not complete.

use crate::ast::Name;
use crate::check::suggest;
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD050";

pub(crate) fn missing(function: &str, params: &[String], span: Span) -> Diagnostic {
    let list = params
        .iter()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ");
    let example = params
        .iter()
        .map(|name| format!("{name} = .."))
        .collect::<Vec<_>>()
        .join(", ");
    Diagnostic::error(
        CODE,
        format!("the influence function `{function}` needs {list}"),
    )
    .at(span, "")
    .help(format!("`{function}({example})`"))
}

pub(crate) fn unknown(name: &str, span: Span, known: &[&str]) -> Diagnostic {
    let finding = Diagnostic::error(CODE, format!("there is no influence function `{name}`"))
        .at(span, "unknown influence function");
    match suggest::question(name, known) {
        Some(question) => finding.help(question),
        None => finding.help(format!("known are {}", known.join(", "))),
    }
}

pub(crate) fn unknown_parameter(function: &str, name: &Name, known: &[String]) -> Diagnostic {
    let finding = Diagnostic::error(
        CODE,
        format!(
            "the influence function `{function}` has no parameter `{}`",
            name.text
        ),
    )
    .at(name.span, "unknown parameter");
    match (suggest::question(&name.text, known), known) {
        (Some(question), _) => finding.help(question),
        (None, []) => finding.help(format!("`{function}` has no parameters")),
        (None, _) => finding.help(format!("its parameters are {}", known.join(", "))),
    }
}

pub(crate) fn twice(name: &Name) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{}` is given twice", name.text)).at(name.span, "")
}

pub(crate) fn unnamed(function: &str, span: Span, params: &[String]) -> Diagnostic {
    let finding = Diagnostic::error(
        CODE,
        format!("the parameters of `{function}` are given by name"),
    )
    .at(span, "which parameter is this?");
    match params {
        [] => finding.help(format!("`{function}` has no parameters")),
        [first, ..] => finding.help(format!("`{function}({first} = ..)`")),
    }
}

pub(crate) fn outside(name: &str, span: Span) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{name}` is outside of its bounds")).at(span, "")
}

pub(crate) fn not_scalar(span: Span) -> Diagnostic {
    Diagnostic::error(
        CODE,
        "an influence function is a scalar function of the bond length",
    )
    .at(span, "not a scalar")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn influence_functions_are_complete() {
        refuse("influence a = softened(p = 0)", "PD050", "softened");
        refuse("influence a = softened", "PD050", "softened");
        refuse(
            "influence a = softened(p = 0, eps = 1 mm, q = 2)",
            "PD050",
            "q",
        );
        refuse(
            "influence a = softened(p = 0, p = 0, eps = 1 mm)",
            "PD050",
            "p",
        );
        refuse("influence a = gaussian(1 mm)", "PD050", "1 mm");
        refuse("influence a = gaussian(l = -1 mm)", "PD050", "-1 mm");
        refuse("influence a = x > 0", "PD050", "x > 0");
        refuse(
            "influence a = softend(p = 0, eps = 1 mm)",
            "PD050",
            "softend",
        );
        refuse("influence a = gausian(1 mm)", "PD050", "gausian");
        refuse("influence a = linaer", "PD050", "linaer");
        refuse("influence a = hat(r = 1)", "PD050", "hat");
        accept(
            "influence a = constant influence b = softened(p = -1/2, eps = 2*1 mm) influence c = 1 - x/delta influence d",
        );
    }
}
