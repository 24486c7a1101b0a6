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
