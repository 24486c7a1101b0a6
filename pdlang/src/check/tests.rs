//! What the tests of the checks share: a law that is right, and what is found when items are added to it.

use crate::diag::Diagnostic;
use crate::front;

/// A law of these items alone.
pub(crate) fn bare(items: &str) -> String {
    format!("model m \"Test\" cite \"Nobody, eq. 1\" {{ {items} }}")
}

/// A law with an energy, a modulus and an influence function, and these items.
pub(crate) fn law(items: &str) -> String {
    bare(&format!(
        "influence omega = 1/x param K : pressure > 0 \"modulus\" energy W = K*sum(s^2)/ball(1) {items}"
    ))
}

/// The findings of a text, as (code, text of the token). Warnings of unused definitions, and of the energy of [`law`]
/// beside a bond force, are left out.
pub(crate) fn found(text: &str) -> Vec<(&'static str, String)> {
    let checked = front::file(text);
    let findings = checked
        .diagnostics
        .iter()
        .filter(|finding| !["PD102", "PD104"].contains(&finding.code));
    findings
        .map(|finding| (finding.code, token(finding, text)))
        .collect()
}

fn token(finding: &Diagnostic, text: &str) -> String {
    let span = finding.span();
    let in_prelude = finding.labels.iter().any(|(span, _)| span.prelude);
    assert!(!in_prelude, "points into the prelude: {finding:?}");
    text[span.start as usize..span.end as usize].to_string()
}

/// Asserts that in a law with these items exactly this is found, at this token.
#[track_caller]
pub(crate) fn refuse(items: &str, code: &str, token: &str) {
    refuse_text(&law(items), code, token);
}

#[track_caller]
pub(crate) fn refuse_text(text: &str, code: &str, token: &str) {
    assert_eq!(
        found(text),
        [(code, token.to_string())],
        "{text}\n{:#?}",
        front::file(text).diagnostics
    );
}

/// Asserts that nothing is found in a law with these items.
#[track_caller]
pub(crate) fn accept(items: &str) {
    let text = law(items);
    assert_eq!(
        found(&text),
        [],
        "{text}\n{:#?}",
        front::file(&text).diagnostics
    );
}
