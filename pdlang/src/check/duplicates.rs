//! PD003: a name for two things.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::span::Span;
use std::collections::HashMap;

const CODE: &str = "PD003";

/// True for the first of a name; the second is reported.
pub(crate) fn first(
    seen: &mut HashMap<String, Span>,
    name: &Name,
    report: &mut Vec<Diagnostic>,
) -> bool {
    match seen.get(&name.text) {
        Some(earlier) => {
            report.push(twice(name, *earlier));
            false
        }
        None => {
            seen.insert(name.text.clone(), name.span);
            true
        }
    }
}

/// As `first`, for a short list.
pub(crate) fn among(earlier: &[Name], name: &Name, report: &mut Vec<Diagnostic>) -> bool {
    let found = earlier.iter().find(|known| known.text == name.text);
    report.extend(found.map(|known| twice(name, known.span)));
    found.is_none()
}

fn twice(name: &Name, earlier: Span) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{}` is defined twice", name.text))
        .at(name.span, "second definition")
        .at(earlier, "first definition")
        .help("one name, one meaning: rename one of them")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{law, refuse, refuse_text};

    #[test]
    fn finds_the_second_of_a_name() {
        refuse("param K : number \"again\"", "PD003", "K");
        refuse("let a = 1 bond a = x", "PD003", "a");
        refuse_text(&(law("") + &law("")), "PD003", "m");
        refuse_text(&format!("fn f(a, a) = a {}", law("")), "PD003", "a");
        refuse_text(
            &format!("fn f(a) = a fn f(b) = b {}", law("")),
            "PD003",
            "f",
        );
    }
}
