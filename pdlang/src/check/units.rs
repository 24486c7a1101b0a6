//! PD011: a unit or kind that does not exist.

use crate::ast::Name;
use crate::check::suggest;
use crate::diag::Diagnostic;
use crate::units::{known_kinds, known_units};

const CODE: &str = "PD011";

pub(crate) fn unknown_unit(name: &Name) -> Diagnostic {
    let finding = Diagnostic::error(CODE, format!("`{}` is not a unit", name.text))
        .at(name.span, "unknown unit");
    match suggest::nearest(&name.text, known_units()) {
        Some(meant) => finding.help(format!("did you mean `{meant}`?")),
        None => finding.help(format!(
            "a word after a number is its unit; a product is written `*`: `2*{}`",
            name.text
        )),
    }
}

pub(crate) fn unknown_kind(name: &Name) -> Diagnostic {
    let finding = Diagnostic::error(CODE, format!("`{}` is not a kind of quantity", name.text))
        .at(name.span, "unknown kind");
    match suggest::question(&name.text, known_kinds()) {
        Some(question) => finding.help(question),
        None => finding.help("write the unit in brackets, such as `[J/m^2]`, or one of the named kinds: number, length, pressure, density, temperature, .."),
    }
}
