//! PD010: a case that is not about the five flavours, or a law for one that does not exist.

use crate::ast::{Expr, Name};
use crate::check::suggest;
use crate::diag::Diagnostic;
use crate::ir::Flavour;
use crate::span::Span;

const CODE: &str = "PD010";

/// Findings about the names of the arms; none when there is one arm per flavour.
pub(crate) fn complete(arms: &[(Name, Expr)], span: Span) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    for (k, (name, _)) in arms.iter().enumerate() {
        if Flavour::ALL
            .iter()
            .all(|flavour| flavour.name() != name.text)
        {
            findings.push(unknown(name));
        } else if let Some((earlier, _)) = arms[..k]
            .iter()
            .find(|(earlier, _)| earlier.text == name.text)
        {
            findings.push(
                Diagnostic::error(CODE, format!("the flavour `{}` has two arms", name.text))
                    .at(name.span, "second arm")
                    .at(earlier.span, "first arm"),
            );
        }
    }
    let missing: Vec<&str> = Flavour::ALL
        .iter()
        .map(|flavour| flavour.name())
        .filter(|flavour| arms.iter().all(|(name, _)| name.text != *flavour))
        .collect();
    if !missing.is_empty() && findings.is_empty() {
        findings.push(incomplete(&missing, span));
    }
    findings
}

/// Findings about the flavours that a law is for.
pub(crate) fn named(names: &[Name]) -> Vec<Diagnostic> {
    let known = |name: &&Name| {
        Flavour::ALL
            .iter()
            .all(|flavour| flavour.name() != name.text)
    };
    names.iter().filter(known).map(unknown).collect()
}

pub(crate) fn unknown(name: &Name) -> Diagnostic {
    let finding = Diagnostic::error(CODE, format!("there is no flavour `{}`", name.text))
        .at(name.span, "unknown flavour");
    match suggest::question(&name.text, Flavour::ALL.map(Flavour::name)) {
        Some(question) => finding.help(question),
        None => finding.help("the flavours are bar, slab, plane_stress, plane_strain and 3d"),
    }
}

fn incomplete(missing: &[&str], span: Span) -> Diagnostic {
    let list = missing
        .iter()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ");
    Diagnostic::error(CODE, format!("no arm for {list}"))
        .at(span, "every flavour needs an arm")
        .help("one source serves all flavours: bar, slab, plane_stress, plane_strain and 3d")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, found, law, refuse, refuse_text};

    #[test]
    fn laws_may_be_for_some_flavours() {
        let text = |list: &str| law("").replacen('{', &format!("for {list} {{"), 1);
        assert!(found(&text("plane_strain, 3d")).is_empty());
        refuse_text(&text("plane_strain, 4d"), "PD010", "4d");
    }

    #[test]
    fn wants_one_arm_for_each() {
        refuse(
            "let c = case flavour { bar: 1, slab: 1, plane_stress: 1, 3d: 1 }",
            "PD010",
            "case flavour { bar: 1, slab: 1, plane_stress: 1, 3d: 1 }",
        );
        refuse(
            "let c = case flavour { bar: 1, slab: 1, plane_stres: 1, plane_strain: 1, 3d: 1 }",
            "PD010",
            "plane_stres",
        );
        refuse(
            "let c = case flavour { bar: 1, bar: 1, slab: 1, plane_stress: 1, plane_strain: 1, 3d: 1 }",
            "PD010",
            "bar",
        );
        refuse(
            "let c = case flavour { bar: 1, slab: 1 m, plane_stress: 1, plane_strain: 1, 3d: 1 }",
            "PD012",
            "1 m",
        );
        refuse(
            "let c = case flavour { bar: 1, slab: I, plane_stress: 1, plane_strain: 1, 3d: 1 }",
            "PD007",
            "I",
        );
        accept(
            "let c = case flavour { 3d: 0, bar: 1 m, slab: 1 m, plane_stress: 0, plane_strain: 1 mm }",
        );
    }
}
