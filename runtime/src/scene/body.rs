//! `[body]`: a shape carved out of a lattice, or points from a file.

use std::path::PathBuf;

use super::document::Data;
use super::problem::Problem;
use super::section::{Placed, Section};
use super::shape;
use crate::body::Flavour;
use crate::carve::{Anchor, Carve};
use crate::language::dimension::{AREA, LENGTH};

/// Where the nodes come from.
#[derive(Clone, Debug, PartialEq)]
pub enum Nodes {
    Carved(Carve),
    /// CSV with the columns x, y, z, volume.
    Points {
        file: PathBuf,
        flavour: Flavour,
        spacing: f64,
        cross: f64,
        period: [Option<f64>; 3],
    },
}

impl Nodes {
    pub fn flavour(&self) -> Flavour {
        match self {
            Nodes::Carved(c) => c.flavour,
            Nodes::Points { flavour, .. } => *flavour,
        }
    }

    /// [m]
    pub fn spacing(&self) -> f64 {
        match self {
            Nodes::Carved(c) => c.spacing,
            Nodes::Points { spacing, .. } => *spacing,
        }
    }

    /// Thickness (2D) [m] or cross-section (1D) [m^2]; 1 in 3D.
    pub fn cross(&self) -> f64 {
        match self {
            Nodes::Carved(c) => c.cross,
            Nodes::Points { cross, .. } => *cross,
        }
    }
}

pub(super) fn flavour(section: &Section<'_>) -> Option<Flavour> {
    let words = Flavour::ALL.map(|f| (f.name(), f));
    let found = section.choice("flavour", &words);
    section.require("flavour", found, "\"3d\"")
}

pub(super) fn spacing(section: &Section<'_>) -> Option<Placed<f64>> {
    let found = section.positive("spacing", LENGTH);
    section.require("spacing", found, "\"0.5 mm\"")
}

/// The nodes; `flavour` and `spacing` have been read before, because other sections need them.
pub(super) fn read(section: Section<'_>, flavour: Flavour, spacing: Option<f64>) -> Option<Nodes> {
    let cross = cross(&section, flavour);
    let points = section.text("points");
    let shaped = section.value("shape").is_some();
    let nodes = match points {
        Some(file) if !shaped => points_file(&section, file, flavour, spacing, cross),
        Some(file) => {
            let problem = Problem::new("a body is either a `shape` or `points`, not both");
            section
                .reader
                .complain(problem.at(file.span, "one of the two is too much"));
            None
        }
        None => carved(&section, flavour, spacing, cross),
    };
    section.finish();
    nodes
}

/// Thickness in two dimensions, cross-section in one.
fn cross(section: &Section<'_>, flavour: Flavour) -> Option<f64> {
    let (key, unit, example) = match flavour.dim() {
        1 => ("cross_section", AREA, "\"1 mm^2\""),
        2 => ("thickness", LENGTH, "\"1 mm\""),
        _ => return Some(1.0),
    };
    let found = section.positive(key, unit).map(|q| q.value);
    section.require(key, found, example)
}

fn carved(
    section: &Section<'_>,
    flavour: Flavour,
    spacing: Option<f64>,
    cross: Option<f64>,
) -> Option<Nodes> {
    let dim = flavour.dim();
    let anchor = match section.value("anchor") {
        None => Some(Anchor::CellCentres),
        Some(_) => section.vector("anchor", LENGTH, dim).map(Anchor::Node),
    };
    let periodic = directions(section, dim);
    let tolerance = section
        .quantity("tolerance", LENGTH)
        .map(|t| t.value.max(0.0));
    let shape = shape::read(section, "shape", dim);
    let shape = section.require("shape", shape, "{ box = { from = [0, 0, 0], to = [..] } }");
    Some(Nodes::Carved(Carve {
        shape: shape?,
        flavour,
        spacing: spacing?,
        anchor: anchor?,
        cross: cross?,
        periodic: periodic?,
        tolerance,
        memory: None,
    }))
}

/// `periodic = ["x", "y"]`.
fn directions(section: &Section<'_>, dim: usize) -> Option<[bool; 3]> {
    let mut periodic = [false; 3];
    let Some(value) = section.value("periodic") else {
        return Some(periodic);
    };
    let Data::List(list) = &value.data else {
        return section
            .reader
            .wrong_type(value, "a list of directions such as [\"x\", \"y\"]");
    };
    for item in list {
        let known = ["x", "y", "z"].iter().take(dim);
        let found = known
            .zip(&mut periodic)
            .find(|(d, _)| item.data == Data::Text(d.to_string()));
        let Some((_, flag)) = found else {
            return section
                .reader
                .wrong_type(item, "a direction of the body: \"x\", \"y\" or \"z\"");
        };
        *flag = true;
    }
    Some(periodic)
}

fn points_file(
    section: &Section<'_>,
    file: Placed<&str>,
    flavour: Flavour,
    spacing: Option<f64>,
    cross: Option<f64>,
) -> Option<Nodes> {
    let path = section.reader.directory.join(file.value);
    let period = periods(section, flavour.dim());
    if !path.is_file() {
        let problem = Problem::new(format!("there is no file `{}`", path.display()))
            .at(file.span, "not found")
            .help("a path is relative to the folder of the scene");
        section.reader.complain(problem);
        return None;
    }
    Some(Nodes::Points {
        file: path,
        flavour,
        spacing: spacing?,
        cross: cross?,
        period: period?,
    })
}

/// `period = ["10 mm", 0, 0]`: 0 where the body does not repeat itself.
fn periods(section: &Section<'_>, dim: usize) -> Option<[Option<f64>; 3]> {
    if section.value("period").is_none() {
        return Some([None; 3]);
    }
    let period = section.vector("period", LENGTH, dim)?;
    Some(period.map(|p| (p > 0.0).then_some(p)))
}
