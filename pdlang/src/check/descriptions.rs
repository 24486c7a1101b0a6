//! PD032: a parameter, field or history without a description.

use crate::ast::Name;
use crate::diag::Diagnostic;

const CODE: &str = "PD032";

pub(crate) fn missing(what: &str, name: &Name) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("the {what} `{}` has no description", name.text),
    )
    .at(name.span, "what does a user read about it?")
    .help(format!(
        "end the line with a text in quotes, such as `{what} {} : ..  \"bulk modulus\"`",
        name.text
    ))
}
