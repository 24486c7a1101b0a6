//! PD035: an unknown way in which the values of two materials meet.

use crate::ast::Name;
use crate::check::suggest;
use crate::diag::Diagnostic;
use crate::ir::Meet;

const CODE: &str = "PD035";

pub(crate) fn unknown(word: &Name) -> Diagnostic {
    let words: Vec<&str> = Meet::WORDS.iter().map(|(word, _)| *word).collect();
    let finding = Diagnostic::error(CODE, format!("values cannot meet by `{}`", word.text))
        .at(word.span, "not a way to meet");
    match suggest::nearest(&word.text, &words) {
        Some(near) => finding.help(format!("did you mean `{near}`?")),
        None => finding.help(format!("choose one of {}", words.join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn knows_the_ways_to_meet() {
        accept("param k : number > 0 = 3 meets harmonic \"k\" param l : length meets min \"l\"");
        refuse("param k : number meets harmonc \"k\"", "PD035", "harmonc");
        refuse("param k : number meets \"k\"", "PD001", "\"k\"");
    }
}
