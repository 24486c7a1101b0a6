//! PD006: arguments that do not fit a function.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD006";

/// `params`: what a function of the language calls its arguments.
pub(crate) fn of_function(name: &Name, found: usize, params: &[Name]) -> Diagnostic {
    let params: Vec<&str> = params.iter().map(|p| p.text.as_str()).collect();
    let call = format!("it is called `{}({})`", name.text, params.join(", "));
    count(name, found, params.len()).help(call)
}

pub(crate) fn count(name: &Name, found: usize, expected: usize) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("`{}` takes {}, not {found}", name.text, arguments(expected)),
    )
    .at(name.span, format!("{} given", arguments(found)))
}

fn arguments(count: usize) -> String {
    match count {
        1 => "1 argument".into(),
        n => format!("{n} arguments"),
    }
}

pub(crate) fn no_family(name: &Name, family: Span) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{}` does not sum over a family", name.text))
        .at(family, "a family stands after `sum` and `sum0` only")
}

pub(crate) fn by_position(function: &Name, argument: &Name) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("the arguments of `{}` have no names", function.text),
    )
    .at(argument.span, "named argument")
    .help("arguments are told apart by their position; only influence functions have named ones")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::refuse;

    #[test]
    fn counts_arguments() {
        refuse("let c = K_d(K)", "PD006", "K_d");
        refuse("bond b = norm(xi, eta)", "PD006", "norm");
        refuse("node b = sum(x, x)", "PD006", "sum");
        refuse("bond b = other()", "PD006", "other");
        refuse("bond b = norm(v = xi)", "PD006", "v");
        refuse(
            "family near = horizon where x < delta let b = ball[near](x)",
            "PD006",
            "near",
        );
    }
}
