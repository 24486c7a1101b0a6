//! `[let]`: named constants for every expression and quantity of the scene.

use super::document::Data;
use super::problem::Problem;
use super::reader::{COORDINATES, Constant};
use super::section::Section;
use crate::language::{Expected, dimension};

/// Reads the constants in the order of the text; each may use the ones above it.
pub(super) fn read(section: Section<'_>) {
    let reader = section.reader;
    for entry in section.entries() {
        section.value(&entry.key);
        if let Some(reason) = unfit(&entry.key) {
            reader.complain(
                Problem::new(format!("`{}` cannot name a constant", entry.key))
                    .at(entry.key_span.clone(), reason),
            );
            continue;
        }
        let found = match &entry.value.data {
            Data::Number(n, _) => Some((*n, dimension::NUMBER)),
            Data::Text(text) => reader.number(text, &entry.value, Expected::Scalar, &[]),
            _ => reader.wrong_type(&entry.value, "a number or an expression in quotes"),
        };
        if let Some((value, unit)) = found {
            reader.define(Constant {
                name: entry.key.clone(),
                value,
                unit,
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
