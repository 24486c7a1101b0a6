//! PD031: no paper, or no equation number.

use crate::ast::{Name, Text};
use crate::diag::Diagnostic;

const CODE: &str = "PD031";

/// A law says where it comes from: at least one paper, at least one of them with the equation.
pub(crate) fn check(model: &Name, cites: &[Text]) -> Option<Diagnostic> {
    let finding = match cites {
        [] => Diagnostic::error(CODE, format!("the model `{}` cites no paper", model.text))
            .at(model.span, "expected `cite` after the title"),
        _ if cites.iter().any(|cite| names_equation(&cite.text)) => return None,
        [first, ..] => Diagnostic::error(
            CODE,
            format!("the model `{}` cites no equation", model.text),
        )
        .at(first.span, "no equation number"),
    };
    Some(finding.help("`cite \"Silling et al. 2007, J. Elasticity 88, eq. 104-108\"`"))
}

/// `eq. 3`, `Eqs 3.8-3.11`, `(12)`, `[3.5]`; a year in parentheses is no equation.
fn names_equation(cite: &str) -> bool {
    let lower = cite.to_lowercase();
    let worded = lower
        .match_indices("eq")
        .any(|(at, _)| lower[at..].chars().take(14).any(|c| c.is_ascii_digit()));
    worded
        || cite
            .split(['(', '['])
            .skip(1)
            .any(|rest| rest.split([')', ']']).next().is_some_and(is_number))
}

fn is_number(text: &str) -> bool {
    let year = text.len() == 4 && text.chars().all(|c| c.is_ascii_digit());
    text.starts_with(|c: char| c.is_ascii_digit()) && !year
}

#[cfg(test)]
mod tests {
    use super::names_equation;
    use crate::check::tests::{law, refuse_text};

    #[test]
    fn laws_say_where_they_come_from() {
        refuse_text(&law("").replace("cite \"Nobody, eq. 1\"", ""), "PD031", "m");
        refuse_text(&law("").replace(", eq. 1", ""), "PD031", "\"Nobody\"");
    }

    #[test]
    fn tells_equations_from_years() {
        for cite in [
            "Silling 2007, eq. 104-108",
            "Eqs. (12) and (13)",
            "Silling 2000 (3.5)",
            "Silling [3.5]",
        ] {
            assert!(names_equation(cite), "{cite}");
        }
        for cite in [
            "Silling (2000)",
            "Silling 2007, J. Elasticity 88",
            "",
            "equation of motion",
        ] {
            assert!(!names_equation(cite), "{cite}");
        }
    }
}
