//! `[let]`: named expressions for every other expression and quantity of the scene.

use super::problem::Problem;
use super::reader::{COORDINATES, Named};
use super::section::Section;
use crate::language::{Compiled, Expected};

/// Reads them in the order of the text; each may use the ones above it.
pub(super) fn read(section: Section<'_>) {
    let reader = section.reader;
    for entry in section.entries() {
        section.value(&entry.key);
        if let Some(reason) = unfit(&entry.key) {
            reader.complain(
                Problem::new(format!("`{}` cannot be a name", entry.key))
                    .at(entry.key_span.clone(), reason),
            );
            continue;
        }
        let found = reader.expression(&entry.value, COORDINATES.len(), Expected::Scalar);
        if let Some(Compiled { tape, unit }) = found {
            reader.define(Named {
                name: entry.key.clone(),
                unit,
                tape,
            });
        }
    }
    section.finish();
}

fn unfit(name: &str) -> Option<&'static str> {
    let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    if !name.starts_with(letter) || !name.chars().all(|c| letter(c) || c.is_ascii_digit()) {
        return Some("a name is letters, digits and underscores");
    }
    if COORDINATES.iter().any(|(c, _)| *c == name) {
        return Some("this is a coordinate");
    }
    match name {
        "pi" => Some("this is the number pi"),
        "dx" => Some("this is the spacing of [body]"),
        _ => None,
    }
}
