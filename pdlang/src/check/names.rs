//! PD002: a name that means nothing here.

use crate::ast::Name;
use crate::check::{habits, suggest};
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD002";

/// What a name means elsewhere.
#[derive(Clone, Copy)]
pub(crate) enum Meaning {
    Function,
    ValueOfLaws,
}

pub(crate) fn unknown_value(
    name: &str,
    span: Span,
    candidates: &[String],
    meaning: Option<Meaning>,
    habit: Option<&str>,
) -> Diagnostic {
    let finding =
        Diagnostic::error(CODE, format!("`{name}` is not defined")).at(span, "unknown name");
    if let (None, Some(remedy)) = (meaning, habit) {
        return finding.help(remedy);
    }
    match (meaning, suggest::question(name, candidates)) {
        (Some(Meaning::Function), _) => finding.help(format!(
            "`{name}` is a function: write its arguments in parentheses"
        )),
        (Some(Meaning::ValueOfLaws), _) => finding.help(format!(
            "`{name}` means something in laws; here, there is {}",
            list(candidates)
        )),
        (None, Some(question)) => finding.help(question),
        // Outside of laws, few names mean anything: all of them can be said.
        (None, None) if candidates.len() <= 8 => {
            finding.help(format!("here, there is {}", list(candidates)))
        }
        (None, None) => finding,
    }
}

/// A unit of several words behind a number: said where the second word is no value.
pub(crate) fn unit_without_brackets(finding: Diagnostic) -> Diagnostic {
    finding.help("a unit with `/` or `*` stands in brackets: `1e-6 [m^2/s]`")
}

fn list(names: &[String]) -> String {
    names
        .iter()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ")
}

pub(crate) fn unknown_function(
    name: &Name,
    candidates: &[String],
    is_value: bool,
    is_influence: bool,
) -> Diagnostic {
    let finding = Diagnostic::error(CODE, format!("there is no function `{}`", name.text))
        .at(name.span, "unknown function");
    let question = suggest::question(&name.text, candidates);
    match question {
        _ if is_value => finding.help(format!(
            "`{0}` is a value; a product is written `{0}*(..)`",
            name.text
        )),
        _ if is_influence => finding.help(format!(
            "`{0}` is an influence function: declare `influence omega = {0}(..)` and use `omega`",
            name.text
        )),
        question => match habits::function(&name.text).map(String::from).or(question) {
            Some(help) => finding.help(help),
            None => finding,
        },
    }
}

pub(crate) fn unknown_family(name: &Name, known: &[String]) -> Diagnostic {
    let finding = Diagnostic::error(CODE, format!("there is no family `{}`", name.text))
        .at(name.span, "unknown family");
    match suggest::question(&name.text, known) {
        Some(question) => finding.help(question),
        None => finding.help(format!(
            "declare it: `family {} = horizon where ..`",
            name.text
        )),
    }
}

pub(crate) fn family_as_value(name: &str, span: Span) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{name}` is a family, not a value"))
        .at(span, "a family stands in brackets")
        .help(format!("sum over it with `sum[{name}](..)`"))
}

/// `rate`, `update` of something else than a field, a history.
pub(crate) fn nothing_to_change(name: &Name, what: &str, known: &[String]) -> Diagnostic {
    let finding = Diagnostic::error(CODE, format!("there is no {what} `{}`", name.text))
        .at(name.span, format!("unknown {what}"));
    match suggest::question(&name.text, known) {
        Some(question) => finding.help(question),
        None => finding.help(format!("declare it: `{what} {} : ..`", name.text)),
    }
}

pub(crate) fn only_in_laws(name: &Name) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{}` has a meaning in laws only", name.text))
        .at(name.span, "there are no bonds here")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::refuse;

    #[test]
    fn finds_unknown_names() {
        refuse("node t = sum(ee)", "PD002", "ee");
        refuse("node t = sun(e)", "PD002", "sun");
        refuse("node t = sum[near](e)", "PD002", "near");
        refuse("node t = sum(K_d*e)", "PD002", "K_d");
        refuse("bond b = K(1)", "PD002", "K");
        refuse(
            "family near = horizon where x < delta bond b = near*2",
            "PD002",
            "near",
        );
        refuse("influence a = r", "PD002", "r");
        refuse("rate T = 1", "PD002", "T");
        refuse("update p = 1", "PD002", "p");
    }

    #[test]
    fn is_silent_about_what_failed_elsewhere() {
        refuse(
            "node a = sum(ee) node b = a + 1 bond c = b*a'",
            "PD002",
            "ee",
        );
    }
}
