//! PD001: the text is not a law.

use crate::check::suggest;
use crate::diag::Diagnostic;
use crate::span::Span;
use crate::words::{ITEMS, TOP, WORDS};

const CODE: &str = "PD001";

/// What could have stood at the place of an error.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Expected {
    /// In words.
    Word(&'static str),
    /// As it is written.
    Token(&'static str),
    Operator,
    /// The next definition of a model, of a file.
    Item,
    TopItem,
    End,
    /// Possible almost anywhere, and no help.
    Anywhere,
}

/// `before` is the last token of an earlier line, after which something may be missing.
pub(crate) fn unexpected(
    span: Span,
    token: &str,
    before: Option<Span>,
    expected: Vec<Expected>,
) -> Diagnostic {
    let message = match token {
        "" => "the text ends too early".to_string(),
        "\"" => "this text in quotes does not end on its line".to_string(),
        _ => format!("`{token}` cannot stand here"),
    };
    let finding = Diagnostic::error(CODE, message);
    let starts = expected
        .iter()
        .any(|e| matches!(e, Expected::Item | Expected::TopItem));
    let named = expected
        .iter()
        .any(|e| matches!(e, Expected::Word("a name")));
    let list = alternatives(&in_order(expected));
    let finding = match before {
        _ if list.is_empty() || token == "\"" => finding.at(span, ""),
        Some(before) if !starts => finding
            .at(span, "")
            .at(before, format!("after this, expected {list}")),
        _ => finding.at(span, format!("expected {list}")),
    };
    let words = TOP.into_iter().chain(ITEMS);
    if named && words.clone().any(|word| word == token) {
        return finding.help(format!(
            "`{token}` begins a definition, and so it is no name"
        ));
    }
    if named && WORDS.contains(&token) {
        return finding.help(format!(
            "`{token}` is a word of the language, and so it is no name"
        ));
    }
    match suggest::question(token, words).filter(|_| starts) {
        Some(question) => finding.help(question),
        None => finding,
    }
}

/// Descriptions in a fixed order, each once: words, then tokens, then operators, then the end.
fn in_order(expected: Vec<Expected>) -> Vec<String> {
    // After a name, an operator is as good as the parentheses of a call, and shorter to say.
    let after_name = expected.contains(&Expected::Operator);
    let said = expected
        .into_iter()
        .filter(|e| !after_name || !matches!(e, Expected::Token("(" | "[")));
    let mut ranked: Vec<(u8, String)> = said.filter_map(describe).collect();
    ranked.sort();
    ranked.dedup();
    ranked.into_iter().map(|(_, text)| text).collect()
}

fn describe(expected: Expected) -> Option<(u8, String)> {
    match expected {
        Expected::Word(text) => Some((0, text.into())),
        Expected::Token(text) => Some((1, format!("`{text}`"))),
        Expected::Operator => Some((2, "an operator".into())),
        Expected::Item => Some((3, "the next definition".into())),
        Expected::TopItem => Some((3, "`model`, `influence` or `fn`".into())),
        Expected::End => Some((4, "the end of the text".into())),
        Expected::Anywhere => None,
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

#[cfg(test)]
mod tests {
    use crate::check::tests::{found, law, refuse};

    #[test]
    fn points_at_the_token_and_reads_on() {
        refuse("let c = 2*", "PD001", "}");
        refuse("let c = (1 + 2 let d = 3", "PD001", "let");
        refuse("param p number \"p\"", "PD001", "number");
        refuse("parm p : number \"p\" let c = p", "PD001", "parm");
        let text = law("let a = $ let b = 1 ! let c = a");
        assert_eq!(found(&text), [("PD001", "$".into()), ("PD001", "!".into())]);
    }

    #[test]
    fn says_what_could_stand_there() {
        let text = law("let c = ");
        let finding = &crate::front::file(&text).diagnostics[0];
        assert_eq!(finding.labels[0].1, "expected an expression");
    }

    #[test]
    fn refuses_what_is_nested_without_end() {
        let deep = "(".repeat(500) + "1" + &")".repeat(500);
        assert_eq!(found(&law(&format!("let c = {deep}")))[0].0, "PD001");
    }
}
