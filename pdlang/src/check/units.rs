//! PD011: a unit or kind that does not exist.

use crate::ast::Name;
use crate::check::{habits, suggest};
use crate::diag::Diagnostic;
use crate::units::{known_kinds, known_units};

const CODE: &str = "PD011";

pub(crate) fn unknown_unit(name: &Name) -> Diagnostic {
    let finding = Diagnostic::error(CODE, format!("`{}` is not a unit", name.text))
        .at(name.span, "unknown unit");
    if let Some(remedy) = habits::unit(&name.text) {
        return finding.help(remedy);
    }
    // `mpa` is one of two units, a billion apart.
    let alike = |unit: &String| unit.to_lowercase() == name.text.to_lowercase();
    let mut alike: Vec<String> = known_units().filter(alike).collect();
    alike.sort();
    if alike.len() > 1 {
        return finding.help(format!("did you mean `{}`?", alike.join("` or `")));
    }
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

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn knows_units_and_kinds() {
        refuse("let c = 1 GPA", "PD011", "GPA");
        refuse("let c = 2 K_d", "PD001", "K_d");
        refuse("param l : lenght \"l\"", "PD011", "lenght");
        refuse("param l : [kg/mm^3/foot] \"l\"", "PD011", "foot");
        accept("param l : [kg/mm^3] = 1e3 kg/m³ \"l\" let c = 5 [W/(m K)] + 3 W/(1 m)/(1 K)");
    }
}
