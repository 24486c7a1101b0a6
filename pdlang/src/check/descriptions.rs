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

#[cfg(test)]
mod tests {
    use crate::check::tests::refuse;

    #[test]
    fn parameters_are_described() {
        refuse("param p : number", "PD032", "p");
        refuse("field T : number rate T = T/(1 s)", "PD032", "T");
        refuse("history p : number on bond update p = s", "PD032", "p");
    }
}
