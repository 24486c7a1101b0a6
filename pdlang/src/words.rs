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
}
