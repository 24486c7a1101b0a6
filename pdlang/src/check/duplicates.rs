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
