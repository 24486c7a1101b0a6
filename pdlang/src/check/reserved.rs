//! PD004: a name that the language uses itself.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::resolve::names;

const CODE: &str = "PD004";

/// Whether a value may have this name.
pub(crate) fn allowed(name: &Name, report: &mut Vec<Diagnostic>) -> bool {
    let taken = names::is_primitive(&name.text);
    if taken {
        report.push(finding(name, "a quantity of the language"));
    }
    !taken
}

/// Whether a function may have this name.
pub(crate) fn allowed_function(name: &Name, report: &mut Vec<Diagnostic>) -> bool {
    let taken = names::is_function(&name.text);
    if taken {
        report.push(finding(name, "a function of the language"));
    }
    !taken
}

/// Whether a family may have this name.
pub(crate) fn allowed_family(name: &Name, report: &mut Vec<Diagnostic>) -> bool {
    let taken = name.text == "horizon";
    if taken {
        report.push(finding(name, "the family of all bonds"));
    }
    !taken
}

fn finding(name: &Name, what: &str) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{}` cannot be defined", name.text))
        .at(name.span, format!("this is {what}"))
        .help("choose another name")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, law, refuse, refuse_text};

    #[test]
    fn protects_the_words_of_the_language() {
        refuse("param delta : length \"mine\"", "PD004", "delta");
        refuse(
            "family horizon = horizon where x < delta",
            "PD004",
            "horizon",
        );
        refuse_text(&format!("fn sum(a) = a {}", law("")), "PD004", "sum");
        refuse_text(&format!("fn f(dim) = dim {}", law("")), "PD004", "dim");
        refuse_text(
            &format!("influence f(delta) = delta {}", law("")),
            "PD004",
            "delta",
        );
    }

    #[test]
    fn functions_and_values_have_names_of_their_own() {
        accept("node norm = sum(x)");
    }
}
