//! PD102: a definition that nothing uses.

use crate::ast::Name;
use crate::diag::Diagnostic;

const CODE: &str = "PD102";

pub(crate) fn warning(what: &str, name: &Name) -> Diagnostic {
    Diagnostic::warning(CODE, format!("the {what} `{}` is never used", name.text))
        .at(name.span, "no response, break or node value needs it")
}
