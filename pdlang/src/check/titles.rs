//! PD030: a law without a title.

use crate::ast::Name;
use crate::diag::Diagnostic;

const CODE: &str = "PD030";

pub(crate) fn missing(model: &Name) -> Diagnostic {
    Diagnostic::error(CODE, format!("the model `{}` has no title", model.text))
        .at(model.span, "expected a title after this name")
        .help(format!(
            "`model {} \"Linear peridynamic solid\" ..`",
            model.text
        ))
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{law, refuse_text};

    #[test]
    fn laws_have_titles() {
        refuse_text(&law("").replace("\"Test\"", ""), "PD030", "m");
        refuse_text(&law("").replace("\"Test\"", "\" \""), "PD030", "m");
    }
}
