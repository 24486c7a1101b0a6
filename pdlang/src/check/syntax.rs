//! PD001: the text is not a law.

use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD001";

/// What could have stood at the place of an error.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Expected {
    /// In words.
    Word(&'static str),
    /// As it is written.
    Token(&'static str),
    Operator,
    End,
    /// Possible everywhere, and no help.
    Unit,
}

/// Descriptions in a fixed order, each once: words, then tokens, then operators, then the end.
pub(crate) fn in_order(expected: impl Iterator<Item = Expected>) -> Vec<String> {
    let mut ranked: Vec<(u8, String)> = expected.filter_map(describe).collect();
    ranked.sort();
    ranked.dedup();
    ranked.into_iter().map(|(_, text)| text).collect()
}

fn describe(expected: Expected) -> Option<(u8, String)> {
    match expected {
        Expected::Word(text) => Some((0, text.into())),
        Expected::Token(text) => Some((1, format!("`{text}`"))),
        Expected::Operator => Some((2, "an operator".into())),
        Expected::End => Some((3, "the end of the text".into())),
        Expected::Unit => None,
    }
}

/// `before` is the end of the line before, where what is missing would stand.
pub(crate) fn unexpected(
    span: Span,
    token: &str,
    before: Option<Span>,
    expected: &[String],
) -> Diagnostic {
    let message = match token {
        "" => "the text ends too early".to_string(),
        _ => format!("`{token}` cannot stand here"),
    };
    let list = alternatives(expected);
    let diagnostic = Diagnostic::error(CODE, message);
    match before {
        Some(line) if !list.is_empty() => diagnostic
            .at(span, "")
            .at(line, format!("after this, expected {list}")),
        _ if !list.is_empty() => diagnostic.at(span, format!("expected {list}")),
        _ => diagnostic.at(span, ""),
    }
}

fn alternatives(expected: &[String]) -> String {
    match expected {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} or {last}", most.join(", ")),
    }
}

pub(crate) fn too_deep(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "this expression is nested too deeply")
        .at(span, "")
        .help("give parts of it a name with `let`, `node` or `bond`")
}

pub(crate) fn unreadable(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "this cannot be read as a definition").at(span, "")
}
