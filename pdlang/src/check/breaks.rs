//! PD044, PD106: bonds that break by something that is not theirs.

use crate::diag::Diagnostic;
use crate::span::Span;

/// A condition of constants: it holds from the start or never. `hidden` is a bond quantity of the prelude that the law calls
/// something else.
pub(crate) fn constant(when: Span, hidden: Option<&str>) -> Diagnostic {
    let finding = Diagnostic::error(
        "PD044",
        "this condition is the same for every bond, for ever",
    )
    .at(when, "made of constants alone");
    finding.help(match hidden {
        Some(name) => format!("`{name}` is the law's own here, no longer that of the bond: give the law's another name"),
        None => "a bond breaks by what happens to it, its stretch for instance: `break when s > s0`".into(),
    })
}

/// A condition of the node: all of its bonds break at once.
pub(crate) fn of_node(when: Span) -> Diagnostic {
    Diagnostic::warning("PD106", "all bonds of a node break at once")
        .at(when, "the same for every bond of a node")
        .help("a bond breaks by what happens to it, its stretch for instance: `break when s > s0`; where nodes are meant to come off, say so in a comment")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn bonds_break_by_what_is_theirs() {
        refuse(
            "node theta = sum(omega*e)/sum(omega*x) break when theta > 0.1",
            "PD106",
            "theta > 0.1",
        );
        refuse("let a = 2 break when a > 1", "PD044", "a > 1");
        accept("node theta = sum(omega*e)/sum(omega*x) break when s > 0.1 + theta");
    }

    #[test]
    fn a_hidden_stretch_is_named() {
        let text = crate::check::tests::law("let s = 2 break when s > 1");
        let found = crate::front::file(&text).diagnostics;
        let error = found.iter().find(|d| d.code == "PD044").expect("an error");
        let help = error.help.clone().unwrap_or_default();
        assert!(help.starts_with("`s` is the law's own"), "{help}");
    }
}
