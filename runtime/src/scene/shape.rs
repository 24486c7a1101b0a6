//! Shapes and surfaces as tables with one key: `{ sphere = { center = [..], radius = .. } }`.

use super::document::{Data, Value};
use super::problem::Problem;
use super::section::{Section, listed};
use crate::error::InputError;
use crate::language::dimension::{LENGTH, NUMBER};
use crate::shape::{Shape, Surface};

/// The words for shapes per dimension.
fn words(dim: usize) -> &'static [&'static str] {
    match dim {
        1 => &["box", "union", "intersection", "difference"],
        2 => &["box", "disc", "union", "intersection", "difference"],
        _ => &[
            "box",
            "cylinder",
            "sphere",
            "union",
            "intersection",
            "difference",
        ],
    }
}

/// The shape under `key` of a section.
pub(super) fn read(section: &Section<'_>, key: &str, dim: usize) -> Option<Shape> {
    let value = section.value(key)?;
    let shape = table(section, value, key, dim)?;
    match shape.check() {
        Ok(()) => Some(shape),
        Err(error) => complain(section, value, error),
    }
}

fn table(parent: &Section<'_>, value: &Value, key: &str, dim: usize) -> Option<Shape> {
    let section = parent
        .reader
        .section_of(value, format!("`{key}`"), value.span.clone())?;
    let words = words(dim);
    let given: Vec<&str> = words
        .iter()
        .copied()
        .filter(|w| section.value(w).is_some())
        .collect();
    let shape = match given.as_slice() {
        [word] => named(&section, word, dim),
        [] if !section.entries().is_empty() => None,
        _ => {
            let problem = Problem::new(format!("`{key}` must be one shape")).at(
                value.span.clone(),
                format!("expected one of {}", listed(words)),
            );
            section
                .reader
                .complain(problem.help("combine several as { union = [ .., .. ] }"));
            None
        }
    };
    section.finish();
    shape
}

fn named(section: &Section<'_>, word: &str, dim: usize) -> Option<Shape> {
    match word {
        "union" => Some(Shape::Union(parts(section, word, dim)?)),
        "intersection" => Some(Shape::Intersection(parts(section, word, dim)?)),
        "difference" => {
            let mut parts = parts(section, word, dim)?;
            let base = parts.remove(0);
            Some(Shape::Difference(Box::new(base), parts))
        }
        _ => simple(section, word, dim),
    }
}

/// At least one shape.
fn parts(section: &Section<'_>, word: &str, dim: usize) -> Option<Vec<Shape>> {
    let value = section.value(word)?;
    let Data::List(list) = &value.data else {
        return section.reader.wrong_type(value, "a list of shapes");
    };
    if list.is_empty() {
        let problem = Problem::new(format!("`{word}` of no shapes"));
        section
            .reader
            .complain(problem.at(value.span.clone(), "list at least one shape"));
        return None;
    }
    let parts: Vec<_> = list.iter().map(|v| table(section, v, word, dim)).collect();
    parts.into_iter().collect()
}

fn simple(parent: &Section<'_>, word: &str, dim: usize) -> Option<Shape> {
    let section = parent.section(word)?;
    let point = |key: &str| {
        let found = section.vector(key, LENGTH, dim);
        section.require(key, found, "[\"0 mm\", ..], one length per dimension")
    };
    let radius = || {
        let found = section.positive("radius", LENGTH).map(|r| r.value);
        section.require("radius", found, "\"10 mm\"")
    };
    let shape = match word {
        "box" => pair(point("from"), point("to")).map(|(mut from, mut to)| {
            // Without end beyond the dimension: a box has an inside there too, which a difference takes away.
            for d in dim..3 {
                (from[d], to[d]) = (f64::NEG_INFINITY, f64::INFINITY);
            }
            Shape::Box { from, to }
        }),
        "cylinder" => {
            let ends = pair(point("from"), point("to"));
            pair(ends, radius()).map(|((from, to), radius)| Shape::Cylinder { from, to, radius })
        }
        _ => {
            pair(point("center"), radius()).map(|(center, radius)| Shape::Sphere { center, radius })
        }
    };
    section.finish();
    shape
}

/// Both, where both are there; both are read, so that all problems show.
fn pair<A, B>(a: Option<A>, b: Option<B>) -> Option<(A, B)> {
    Some((a?, b?))
}

/// What `[[crack]]` cuts.
pub(super) fn surface(section: &Section<'_>, dim: usize) -> Option<Surface> {
    let words: &[&str] = match dim {
        1 => &["point"],
        2 => &["segment", "plane"],
        _ => &["plane", "patch", "disc"],
    };
    let given: Vec<&str> = words
        .iter()
        .copied()
        .filter(|w| section.value(w).is_some())
        .collect();
    let [word] = given.as_slice() else {
        if section.entries().is_empty() || given.len() > 1 {
            let problem = Problem::new(format!("{} must be one surface", section.title));
            let label = format!("expected one of {}", listed(words));
            section
                .reader
                .complain(problem.at(section.span.clone(), label));
        }
        return None;
    };
    let place = section.value(word)?;
    let surface = if *word == "point" {
        section
            .quantity("point", LENGTH)
            .map(|x| Surface::Point { x: x.value })
    } else {
        let inner = section.section(word)?;
        let surface = surface_named(&inner, word, dim);
        inner.finish();
        surface
    }?;
    match surface.check() {
        Ok(()) => Some(surface),
        Err(error) => complain(section, place, error),
    }
}

fn surface_named(section: &Section<'_>, word: &str, dim: usize) -> Option<Surface> {
    let vector = |key: &str, unit, example: &str| {
        let found = section.vector(key, unit, dim);
        section.require(key, found, example)
    };
    let point = |key: &str| vector(key, LENGTH, "[\"0 mm\", ..], one length per dimension");
    let normal = || vector("normal", NUMBER, "[0, 1, 0], a direction");
    match word {
        "plane" => {
            pair(point("point"), normal()).map(|(point, normal)| Surface::Plane { point, normal })
        }
        "segment" => pair(point("from"), point("to")).map(|(from, to)| Surface::Segment {
            from: [from[0], from[1]],
            to: [to[0], to[1]],
        }),
        "disc" => {
            let radius = section.positive("radius", LENGTH).map(|r| r.value);
            let radius = section.require("radius", radius, "\"10 mm\"");
            let place = pair(point("center"), normal());
            pair(place, radius).map(|((center, normal), radius)| Surface::Disc {
                center,
                normal,
                radius,
            })
        }
        _ => pair(point("corner"), edges(section, dim))
            .map(|(corner, edges)| Surface::Patch { corner, edges }),
    }
}

/// `edges = [[..], [..]]`: two vectors from the corner.
fn edges(section: &Section<'_>, dim: usize) -> Option<[[f64; 3]; 2]> {
    let value = section.value("edges");
    let value = section.require("edges", value, "[[\"1 mm\", 0, 0], [0, \"2 mm\", 0]]")?;
    match &value.data {
        Data::List(list) if list.len() == 2 => Some([
            section.reader.vector(&list[0], LENGTH, dim)?,
            section.reader.vector(&list[1], LENGTH, dim)?,
        ]),
        _ => section.reader.wrong_type(value, "a list of two vectors"),
    }
}

pub(super) fn complain<T>(section: &Section<'_>, place: &Value, error: InputError) -> Option<T> {
    let problem = Problem::new(error.what).at(place.span.clone(), "");
    section.reader.complain(problem.help(error.remedy));
    None
}
