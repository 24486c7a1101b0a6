//! PD036: a law that knows something of a check that does not exist.

use crate::ast::{Item, Model};
use crate::check::suggest;
use crate::diag::Diagnostic;
use crate::ir::Known;
use crate::known::CHECKS;

const CODE: &str = "PD036";

/// What the law says about itself, a check each.
pub(crate) fn read(model: &Model, report: &mut Vec<Diagnostic>) -> Vec<Known> {
    let mut found: Vec<Known> = Vec::new();
    for item in &model.items {
        let Item::Known(written) = item else { continue };
        if written.reason.text.trim().is_empty() {
            let finding = Diagnostic::error(CODE, "what is known needs its reason");
            report.push(finding.at(written.reason.span, "expected why the law is so"));
        }
        for name in &written.checks {
            let names = CHECKS.iter().map(|(name, _)| *name);
            if !names.clone().any(|check| check == name.text) {
                let finding = Diagnostic::error(CODE, format!("there is no check `{}`", name.text));
                let all = || {
                    format!(
                        "checks are {}",
                        names.clone().collect::<Vec<_>>().join(", ")
                    )
                };
                let help = suggest::question(&name.text, names.clone()).unwrap_or_else(all);
                report.push(
                    finding
                        .at(name.span, "not a check of `pdlang verify`")
                        .help(help),
                );
                continue;
            }
            if let Some(first) = found.iter().find(|known| known.check == name.text) {
                let message = format!("`{}` is said to be known twice", name.text);
                let finding = Diagnostic::error(CODE, message).at(name.span, "again");
                report.push(finding.at(first.span, "here already"));
                continue;
            }
            found.push(Known {
                check: name.text.clone(),
                reason: written.reason.text.clone(),
                span: name.span,
            });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn only_checks_are_known_each_once_and_with_a_reason() {
        accept("known zero_energy, objectivity \"small strains\"");
        refuse("known zero_energie \"why\"", "PD036", "zero_energie");
        refuse("known beauty \"why\"", "PD036", "beauty");
        refuse("known symmetry \" \"", "PD036", "\" \"");
        refuse(
            "known symmetry \"why\" known tangent, tangent \"why\"",
            "PD036",
            "tangent",
        );
        refuse("known \"why\"", "PD001", "\"why\"");
    }
}
