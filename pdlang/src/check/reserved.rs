//! PD004: a name that the language uses itself.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::resolve::names;

const CODE: &str = "PD004";

/// Whether a value may have this name.
pub(crate) fn allowed(name: &Name, report: &mut Vec<Diagnostic>) -> bool {
    let taken = names::is_primitive(&name.text);
    if taken {
        report.push(finding(name, "a quantity of the language"));
    }
    !taken
}

/// Whether a function may have this name.
pub(crate) fn allowed_function(name: &Name, report: &mut Vec<Diagnostic>) -> bool {
    let taken = names::is_function(&name.text);
    if taken {
        report.push(finding(name, "a function of the language"));
    }
    !taken
}

/// Whether a family may have this name.
pub(crate) fn allowed_family(name: &Name, report: &mut Vec<Diagnostic>) -> bool {
    let taken = name.text == "horizon";
    if taken {
        report.push(finding(name, "the family of all bonds"));
    }
    !taken
}

fn finding(name: &Name, what: &str) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{}` cannot be defined", name.text))
        .at(name.span, format!("this is {what}"))
        .help("choose another name")
}
