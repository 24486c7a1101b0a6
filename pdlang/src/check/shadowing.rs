//! PD101: a name of the prelude, defined again.

use crate::ast::Name;
use crate::diag::Diagnostic;

const CODE: &str = "PD101";

pub(crate) fn warning(name: &Name, what: &str) -> Diagnostic {
    Diagnostic::warning(
        CODE,
        format!("`{}` hides the {what} of the prelude", name.text),
    )
    .at(name.span, "from here on, the name means this")
    .help("readers know what the name means in every other law: choose another one")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{found, law, refuse, refuse_text};

    #[test]
    fn hiding_the_prelude_is_a_warning() {
        refuse("bond s = e/y", "PD101", "s");
        refuse_text(&format!("fn K_d(a) = a {}", law("")), "PD101", "K_d");
        refuse_text(
            &format!("influence gaussian(r) = r {}", law("")),
            "PD101",
            "gaussian",
        );
    }

    #[test]
    fn the_prelude_keeps_its_own_meaning() {
        // `e` of the prelude is y - x whatever the law calls y.
        let text = law("node y = sum(e)/sum(1)");
        assert_eq!(found(&text), [("PD101", "y".to_string())]);
        assert_eq!(crate::front::file(&text).laws.len(), 1);
    }
}
