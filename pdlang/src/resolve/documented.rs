//! The page of the language names everything that a law finds defined.

use super::library;
use super::names::{BUILTINS, FORMS, PRIMITIVES};

#[test]
fn the_page_of_the_language_is_complete() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/language.md");
    let page = std::fs::read_to_string(path).unwrap();
    let prelude = library::prelude();
    let conversion = |name: &str| name.contains("_of_");
    let names: Vec<&str> = (BUILTINS.iter().map(|builtin| builtin.0))
        .chain(FORMS.iter().map(|form| form.0))
        .chain(PRIMITIVES.iter().map(|primitive| primitive.name))
        .chain(prelude.functions.keys().map(String::as_str))
        .chain(prelude.definitions.keys().map(String::as_str))
        .chain(prelude.influences.iter().map(|f| f.name.as_str()))
        .chain(crate::units::kind_names())
        .filter(|name| !conversion(name))
        .collect();
    assert!(names.len() > 70);
    for name in names {
        let word = |c: char| c.is_alphanumeric() || c == '_';
        let named = page.split(|c| !word(c)).any(|found| found == name);
        assert!(named, "docs/language.md does not say `{name}`");
    }
}
