//! The words that begin a definition. The grammar has them as `top_word` and `item_word`; a test compares.

/// Outside of models.
pub(crate) const TOP: [&str; 7] = ["use", "model", "influence", "fn", "let", "node", "bond"];

/// In a model.
pub(crate) const ITEMS: [&str; 19] = [
    "influence",
    "param",
    "let",
    "node",
    "bond",
    "energy",
    "pair",
    "state",
    "field",
    "rate",
    "history",
    "update",
    "family",
    "weight",
    "break",
    "known",
    "probe",
    "force",
    "after",
];

/// In a definition.
pub(crate) const WORDS: [&str; 17] = [
    "cite", "for", "meets", "where", "when", "at", "half", "step", "on", "in", "and", "or", "not",
    "case", "expect", "within", "lattice",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn are_those_of_the_grammar() {
        for (rule, words) in [("top_word ", &TOP[..]), ("item_word ", &ITEMS[..])] {
            let grammar = include_str!("grammar.pest").lines();
            let mut rule = grammar.filter(|line| line.starts_with(rule));
            let line = rule.next().expect("the grammar has the rule");
            // `"node"`, `force_word` that looks ahead, `"after" ~ blank+ ~ "step"`.
            let word = |part: &'static str| part.split('"').nth(1).or(part.strip_suffix("_word"));
            let listed: Vec<&str> = line.split(" | ").filter_map(word).collect();
            assert_eq!(listed, words);
        }
    }

    #[test]
    fn are_all_there() {
        let grammar = include_str!("grammar.pest").lines();
        let rules = grammar.filter(|line| line.starts_with("kw_"));
        for word in rules.filter_map(|line| line.split('"').nth(1)) {
            let lists = [&TOP[..], &ITEMS, &WORDS];
            let known = lists.iter().any(|list| list.contains(&word));
            assert!(known || word == "flavour", "{word}");
        }
    }

    /// The grammar of editors colours every word of the language.
    #[test]
    fn are_coloured_by_editors() {
        let colours = include_str!("../../docs/editors/vscode/syntaxes/pdlang.tmLanguage.json");
        let apart = |c: char| !(c.is_ascii_alphanumeric() || c == '_');
        // A `\\b` stands before the first of a list.
        let known: Vec<&str> = colours
            .split(apart)
            .flat_map(|w| [w, w.strip_prefix('b').unwrap_or(w)])
            .collect();
        let rules = include_str!("grammar.pest")
            .lines()
            .filter(|line| line.starts_with("kw_"));
        let words = rules.filter_map(|line| line.split('"').nth(1));
        let items = TOP.iter().chain(&ITEMS).copied();
        let forms = crate::resolve::names::FORMS.iter().copied();
        for word in words.chain(items).chain(forms) {
            assert!(known.contains(&word), "`{word}` has no colour");
        }
    }
}
