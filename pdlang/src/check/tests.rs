//! What the tests of the checks share.

use crate::diag::Diagnostic;
use crate::front;

/// Puts items into a law that is right without them.
pub(crate) fn law(items: &str) -> String {
    format!("model m \"Test\" cite \"Nobody, eq. 1\" {{ {items} }}")
}

/// The findings of a text, as (code, text of the token).
pub(crate) fn found(text: &str) -> Vec<(&'static str, String)> {
    let checked = front::file(text);
    checked
        .diagnostics
        .iter()
        .map(|finding| (finding.code, token(finding, text)))
        .collect()
}

fn token(finding: &Diagnostic, text: &str) -> String {
    let span = finding.span();
    assert!(!span.prelude, "points into the prelude: {finding:?}");
    text[span.start as usize..span.end as usize].to_string()
}

/// Asserts that exactly this is found in a law with these items.
#[track_caller]
pub(crate) fn expect(items: &str, code: &str, token: &str) {
    let text = law(items);
    assert_eq!(
        found(&text),
        [(code, token.to_string())],
        "{items}\n{:#?}",
        front::file(&text).diagnostics
    );
}
