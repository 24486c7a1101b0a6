//! `[family]`: the horizon and how bonds are visited.

use std::ops::Range;

use super::document::Data;
use super::formula;
use super::problem::Problem;
use super::section::{Placed, Section};
use crate::conditions::Expression;
use crate::engine::{Isa, Precision, Traversal};
use crate::language::Expected;
use crate::language::dimension::LENGTH;

/// Which bonds there are and how they are visited.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    pub horizon: Horizon,
    /// How many different horizons there are at most where nodes have their own.
    pub horizon_levels: usize,
    /// Neighbours that the horizon cuts count in part.
    pub partial_volume: bool,
    pub traversal: Traversal,
    /// Where the scene says so.
    pub(super) traversal_place: Option<Range<usize>>,
    /// `None` takes the best that the machine has.
    pub isa: Option<Isa>,
    pub precision: Precision,
    /// Where the scene says so.
    pub(super) precision_place: Option<Range<usize>>,
}

/// How far bonds reach from the nodes of a body or of a part.
#[derive(Clone, Debug, PartialEq)]
pub enum Horizon {
    /// [m]
    Constant(f64, Range<usize>),
    /// In x, y and z.
    Expression(Expression, Range<usize>),
    /// A column of the point file [m].
    Column(String, Range<usize>),
}

impl Horizon {
    /// [m], where all nodes have the same.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Horizon::Constant(h, _) => Some(*h),
            _ => None,
        }
    }

    /// Where the scene gives it.
    pub(super) fn span(&self) -> Range<usize> {
        match self {
            Horizon::Constant(_, span)
            | Horizon::Expression(_, span)
            | Horizon::Column(_, span) => span.clone(),
        }
    }
}

const LEVELS: u64 = 64;

const TRAVERSALS: [(&str, Traversal); 4] = [
    ("auto", Traversal::Auto),
    ("lattice", Traversal::Lattice),
    ("cloud", Traversal::Cloud),
    ("convolution", Traversal::Convolution),
];

const INSTRUCTIONS: [(&str, Option<Isa>); 4] = [
    ("auto", None),
    ("scalar", Some(Isa::Scalar)),
    ("avx2", Some(Isa::Avx2)),
    ("avx512", Some(Isa::Avx512)),
];

const PRECISIONS: [(&str, Precision); 2] =
    [("double", Precision::Double), ("single", Precision::Single)];

pub(super) fn read(section: Section<'_>, spacing: Option<&Placed<f64>>) -> Option<Family> {
    let horizon = horizon(&section, spacing);
    let levels = section.count("horizon_levels", 1);
    let partial_volume = section.flag("partial_volume");
    let traversal = section.choice("traversal", &TRAVERSALS);
    let traversal_place = section.value("traversal").map(|v| v.span.clone());
    let isa = section.choice("instructions", &INSTRUCTIONS);
    let precision = section.choice("precision", &PRECISIONS);
    let precision_place = section.value("precision").map(|v| v.span.clone());
    section.finish();
    Some(Family {
        horizon: horizon?,
        horizon_levels: levels.unwrap_or(LEVELS) as usize,
        partial_volume: partial_volume.unwrap_or(false),
        traversal: traversal.unwrap_or(Traversal::Auto),
        traversal_place,
        isa: isa.flatten(),
        precision: precision.unwrap_or_default(),
        precision_place,
    })
}

/// A length, a multiple of the spacing, `"3 dx"`, an expression in x, y, z, or `{ column = ".." }` of a point file.
pub(super) fn horizon(section: &Section<'_>, spacing: Option<&Placed<f64>>) -> Option<Horizon> {
    let multiple = |text: &String| multiple(text).is_some();
    match section.value("horizon") {
        Some(value) if matches!(value.data, Data::Table(_)) => {
            let table = section.section("horizon")?;
            let column = table.text("column");
            let column = table.require("column", column, "\"delta\", the name of a column");
            table.finish();
            Some(Horizon::Column(column?.value.into(), value.span.clone()))
        }
        Some(value) if matches!(&value.data, Data::Text(text) if !multiple(text)) => {
            let unit = Expected::Unit(LENGTH);
            let found = section.reader.expression(value, 3, unit)?;
            match (formula::last_variable(&found.tape), &value.data) {
                (Some(_), Data::Text(text)) => {
                    let (text, tape) = (text.clone(), found.tape);
                    let expression = Expression { text, tape };
                    Some(Horizon::Expression(expression, value.span.clone()))
                }
                _ => constant(section, spacing),
            }
        }
        _ => constant(section, spacing),
    }
}

fn constant(section: &Section<'_>, spacing: Option<&Placed<f64>>) -> Option<Horizon> {
    let found = match (section.value("horizon").map(|v| &v.data), spacing) {
        (Some(Data::Text(text)), _) if multiple(text).is_some() => {
            let factor = multiple(text)?;
            let place = section.value("horizon")?.span.clone();
            Placed {
                value: factor * spacing?.value,
                span: place,
            }
        }
        _ => {
            let found = section.positive("horizon", LENGTH);
            section.require("horizon", found, "\"3 dx\", three times the spacing")?
        }
    };
    let spacing = spacing?;
    if found.value >= spacing.value {
        return Some(Horizon::Constant(found.value, found.span));
    }
    let problem = Problem::new("the horizon is smaller than the spacing: no node has a neighbour")
        .at(found.span, format!("this is {} m", found.value))
        .at(spacing.span.clone(), format!("this is {} m", spacing.value))
        .help("three times the spacing is usual: horizon = \"3 dx\"");
    section.reader.complain(problem);
    None
}

/// The factor in `3 dx`, `3*dx`, `dx`.
fn multiple(text: &str) -> Option<f64> {
    let factor = text
        .trim()
        .strip_suffix("dx")?
        .trim_end()
        .trim_end_matches('*')
        .trim_end();
    match factor {
        "" => Some(1.0),
        _ => factor.parse::<f64>().ok().filter(|f| f.is_finite()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_of_the_spacing() {
        assert_eq!(multiple("3 dx"), Some(3.0));
        assert_eq!(multiple("3.015*dx"), Some(3.015));
        assert_eq!(multiple("dx"), Some(1.0));
        assert_eq!(multiple("3 mm"), None);
        assert_eq!(multiple("inf dx"), None);
    }
}
