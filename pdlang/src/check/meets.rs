//! PD035: no way in which the values of two materials can meet.

use crate::check::suggest;
use crate::diag::Diagnostic;
use crate::ir::Meet;
use crate::span::Span;

const CODE: &str = "PD035";

pub(crate) fn unknown(word: &str, span: Span) -> Diagnostic {
    let words: Vec<&str> = Meet::WORDS.iter().map(|(word, _)| *word).collect();
    let finding = Diagnostic::error(CODE, format!("values cannot meet by `{word}`"))
        .at(span, "not a way to meet");
    match suggest::nearest(word, &words) {
        Some(near) => finding.help(format!("did you mean `{near}`?")),
        None => finding.help(format!(
            "choose one of {}, or write an expression in `a` and `b`, the values of the two materials, and in \
             `fa` and `fb`, the fractions of the bond in each",
            words.join(", ")
        )),
    }
}

pub(crate) fn of_flavour(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "how values meet cannot depend on the flavour")
        .at(span, "this holds a `case flavour`")
}

pub(crate) fn not_symmetric(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "a bond would have two values of this parameter")
        .at(span, "another value when the two ends change places")
        .help("which end of a bond is `a` depends on the end from which it is seen")
}

pub(crate) fn no_mean(span: Span, of_ones: f64) -> Diagnostic {
    Diagnostic::error(CODE, "values meet in a mean of them")
        .at(span, format!("this makes {of_ones} of 1 and 1"))
        .help("where both materials are the same, the value must be theirs")
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

    #[test]
    fn an_expression_is_a_mean() {
        let with = |meet: &str| format!("param k : pressure > 0 meets {meet} \"k\"");
        for meet in [
            "2*a*b/(a + b)",
            "sqrt(a*b)",
            "select(a > b, b, a)",
            "(a^3 + b^3)/(a^2 + b^2)",
            "1/(fa/a + fb/b)",
            "fa*a + fb*b",
            "select(fa > fb, a, select(fb > fa, b, (a + b)/2))",
        ] {
            accept(&with(meet));
        }
        refuse(&with("a"), "PD035", "a");
        refuse(&with("2*a - b"), "PD035", "2*a - b");
        refuse(&with("a + b"), "PD035", "a + b");
        refuse(&with("a*b"), "PD034", "a*b");
        refuse(&with("(a + c)/2"), "PD002", "c");
        refuse(&with("fb*a + fa^2*b"), "PD035", "fb*a + fa^2*b");
        refuse(&with("fa*a"), "PD035", "fa*a");
        refuse(&with("2*fa*a + 2*fb*b"), "PD035", "2*fa*a + 2*fb*b");
        refuse(&with("a/(1 + fa/a)"), "PD012", "fa/a");
    }

    #[test]
    fn fractions_are_known_where_materials_meet_only() {
        refuse(
            "param k : number meets series \"k\" let c = fa*k",
            "PD002",
            "fa",
        );
    }
}
