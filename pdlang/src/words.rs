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

/// What every word is, as editors say it. A word is in the table once, wherever it may stand.
const SAID: [(&str, &str); 39] = [
    (
        "use",
        "takes the definitions of another file, `use \"elastic.pd\"`; its models stay its own",
    ),
    (
        "model",
        "a law: its name, its title, where it comes from, and its definitions",
    ),
    (
        "influence",
        "a function of the reference length of a bond; a scene may choose another one for that of a law",
    ),
    (
        "fn",
        "a function of its arguments, which sees the shared definitions and no name of a model",
    ),
    (
        "let",
        "a constant: one number per material; in a probe, a name for a number",
    ),
    (
        "node",
        "a value per node; in a probe, a node with its position, its volume and what it is set to",
    ),
    (
        "bond",
        "a value per directed bond, from this node to the other end",
    ),
    (
        "param",
        "a parameter: a kind or unit, bounds, perhaps a default, and a description",
    ),
    (
        "energy",
        "strain energy density of a node [J/m^3]; the force is its derivative, through all sums",
    ),
    (
        "pair",
        "force of a bond along it, the same from both ends [N/m^6]",
    ),
    (
        "state",
        "force state, a scalar along the deformed bond or a vector [N/m^6]; the node feels `T - T'`",
    ),
    (
        "field",
        "a value of every node, which the scene sets; without a `rate` it is a coefficient",
    ),
    ("rate", "time derivative of a field, in its unit per second"),
    (
        "history",
        "a value of a node or of a directed bond that an `update` replaces when a step is accepted",
    ),
    (
        "update",
        "the next value of a history; reading one gives that of the last accepted step",
    ),
    (
        "family",
        "a part of the horizon, by the reference bond; without a name in brackets, everything is about the whole",
    ),
    (
        "weight",
        "a number on a bond that the law multiplies into its sums, computed once from the reference body",
    ),
    (
        "break",
        "a bond for which the condition is true dies before the force of that step, with `after` behind it",
    ),
    (
        "known",
        "what the law is known not to do, with the reason: that check of `pdlang verify` warns in the place of failing",
    ),
    (
        "probe",
        "states what is known in closed form; `pdlang check` finds out",
    ),
    (
        "force",
        "force density of a node, a vector, beside the other forces [N/m^3]",
    ),
    (
        "after",
        "`after step velocity = ..` replaces the velocity of a node when a step is accepted; `break after when` breaks bonds behind the force",
    ),
    (
        "cite",
        "where the law comes from, with the number of the equation",
    ),
    ("for", "the flavours that the law is for; without it, all"),
    (
        "meets",
        "how the values of two materials meet on a bond between them; without it, in their average",
    ),
    (
        "where",
        "the condition for a part of the body or of the bonds; in a probe, the values of parameters",
    ),
    ("when", "the condition under which bonds break"),
    (
        "at",
        "`at half`: the field lives at half steps, where the velocity does",
    ),
    (
        "half",
        "`at half`: the field lives at half steps, where the velocity does",
    ),
    (
        "step",
        "`after step`: when a step is accepted, once all of it is read",
    ),
    ("on", "whether a history is that of a node or of a bond"),
    (
        "in",
        "the bounds of a parameter, `in (-1, 0.5)`; in a probe, its flavour",
    ),
    ("and", "true where both conditions are"),
    ("or", "true where one of the conditions is, or both"),
    ("not", "true where the condition is not"),
    (
        "case",
        "`case flavour`: an arm for each of `bar`, `slab`, `plane_stress`, `plane_strain` and `3d`",
    ),
    (
        "expect",
        "what is known of an energy, of `force`, of a rate or of a definition",
    ),
    (
        "within",
        "the error that is allowed, a part of the value or a quantity",
    ),
    (
        "lattice",
        "a node of an unbounded lattice under a displacement gradient `H`, with the spacing behind the word",
    ),
];

/// Shapes of a value, behind the colon of a definition.
pub(crate) const SHAPES: [(&str, &str); 4] = [
    ("scalar", "a number"),
    ("vector", "one number per dimension"),
    (
        "symmetric",
        "a tensor that is the same transposed: 1, 3 or 6 numbers in 1, 2 or 3 dimensions",
    ),
    ("tensor", "1, 4 or 9 numbers in 1, 2 or 3 dimensions"),
];

/// Flavours of a body.
pub(crate) const FLAVOURS: [(&str, &str); 5] = [
    ("bar", "one dimension, and no stress across it"),
    ("slab", "one dimension, and no strain across it"),
    ("plane_stress", "two dimensions, and no stress across them"),
    ("plane_strain", "two dimensions, and no strain across them"),
    ("3d", "three dimensions"),
];

/// How the values of two materials meet, by name.
pub(crate) const MEETINGS: [(&str, &str); 5] = [
    ("arithmetic", "their average, `(a + b)/2`"),
    ("harmonic", "`2*a*b/(a + b)`, that of two halves in a row"),
    (
        "series",
        "`1/(fa/a + fb/b)`, that of the two pieces of the bond in a row",
    ),
    ("min", "the smaller one"),
    ("max", "the larger one"),
];

/// What a table says of a word.
pub(crate) fn in_table(table: &[(&str, &'static str)], word: &str) -> Option<&'static str> {
    let mut all = table.iter();
    all.find(|(known, _)| *known == word).map(|(_, said)| *said)
}

pub(crate) fn said(word: &str) -> Option<&'static str> {
    in_table(&SAID, word)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::{Flavour, Meet};

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

    #[test]
    fn are_all_explained_once() {
        let all = TOP.iter().chain(&ITEMS).chain(&WORDS);
        let all: std::collections::BTreeSet<&str> = all.copied().collect();
        let said: Vec<&str> = SAID.iter().map(|(word, _)| *word).collect();
        assert_eq!(said.len(), all.len());
        for word in all {
            assert!(said.contains(&word), "`{word}` has no sentence");
        }
    }

    #[test]
    fn tables_are_complete() {
        let listed = |table: &[(&'static str, &str)]| -> Vec<&str> {
            table.iter().map(|(word, _)| *word).collect()
        };
        let mut grammar = include_str!("grammar.pest").lines();
        let shapes = grammar.find(|line| line.starts_with("shape_word"));
        let shapes: Vec<&str> = shapes.unwrap_or("").split('"').skip(1).step_by(2).collect();
        assert_eq!(listed(&SHAPES), shapes);
        assert_eq!(listed(&FLAVOURS), Flavour::ALL.map(|f| f.name()));
        assert_eq!(listed(&MEETINGS), Meet::WORDS.map(|(word, _)| word));
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
        let forms = crate::resolve::names::FORMS.iter().map(|form| form.0);
        for word in words.chain(items).chain(forms) {
            assert!(known.contains(&word), "`{word}` has no colour");
        }
    }
}
