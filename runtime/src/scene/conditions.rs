//! `[[initial]]`, `[[condition]]`, `[[indenter]]`, `[[no_fail]]`: what acts on the body, and where.

use std::ops::Range;

use super::document::{Data, Value};
use super::problem::Problem;
use super::section::Section;
use super::shape;
use crate::conditions::{Condition, Expression, Mirror, Parity, Quantity};
use crate::contact::{ContactLaw, Indenter};
use crate::language::{Expected, Exponents, dimension};
use crate::shape::Shape;
use crate::spec::Spec;

/// Coordinates that an expression may use: x, y, z, and for conditions t.
const WITHOUT_TIME: usize = 3;
const WITH_TIME: usize = 4;

/// Conditions, each with the place of its value.
type Found = Vec<(Condition, Range<usize>)>;

/// What a condition may set: key, quantity, unit, components.
type Target = (String, Quantity, Exponents, usize);

/// `[[initial]]`: values at t = 0.
pub(super) fn initial(section: Section<'_>, spec: &Spec) -> Option<Found> {
    let mut targets = motion(spec);
    targets.extend(fields(spec));
    read(section, &targets, spec, WITHOUT_TIME)
}

/// `[[condition]]`: values that hold for all time.
pub(super) fn condition(section: Section<'_>, spec: &Spec) -> Option<Found> {
    let mut targets = motion(spec);
    if !spec.force.is_empty() {
        targets.push((
            "body_force".into(),
            Quantity::Force,
            dimension::FORCE_DENSITY,
            spec.dim,
        ));
    }
    targets.extend(fields(spec));
    read(section, &targets, spec, WITH_TIME)
}

/// What moves; nothing where the law has no force.
fn motion(spec: &Spec) -> Vec<Target> {
    let dim = spec.dim;
    if spec.force.is_empty() {
        return Vec::new();
    }
    vec![
        (
            "displacement".into(),
            Quantity::Displacement,
            dimension::LENGTH,
            dim,
        ),
        (
            "velocity".into(),
            Quantity::Velocity,
            dimension::VELOCITY,
            dim,
        ),
    ]
}

fn fields(spec: &Spec) -> impl Iterator<Item = Target> + '_ {
    spec.fields.iter().map(|f| {
        (
            f.name.clone(),
            Quantity::Field(f.name.clone()),
            f.exponents,
            f.slots.len(),
        )
    })
}

fn read(
    section: Section<'_>,
    targets: &[Target],
    spec: &Spec,
    coordinates: usize,
) -> Option<Found> {
    let dim = spec.dim;
    let region = region(&section, dim);
    let mirrored = coordinates == WITH_TIME && section.value("mirror").is_some();
    let mirror = if mirrored {
        mirror(&section, dim)
    } else {
        None
    };
    let until = until(&section, coordinates);
    let given: Vec<&Target> = targets
        .iter()
        .filter(|t| section.value(&t.0).is_some())
        .collect();
    let silent = ["region", "mirror", "until"];
    if given.is_empty()
        && section
            .entries()
            .iter()
            .all(|e| silent.contains(&e.key.as_str()))
    {
        let names: Vec<&str> = targets.iter().map(|t| t.0.as_str()).collect();
        let problem = Problem::new(format!("{} sets nothing", section.title))
            .at(section.span.clone(), "")
            .help(format!("give one of {}", names.join(", ")));
        section.reader.complain(problem);
    }
    let values: Vec<_> = given
        .iter()
        .filter_map(|t| {
            let place = section.value(&t.0)?.span.clone();
            Some((value(&section, t, coordinates), place))
        })
        .collect();
    if mirror.is_some()
        && let Some(place) = section.value("mirror")
    {
        for (key, ..) in given.iter().filter(|t| !reflects(&t.1)) {
            let problem = Problem::new(format!("a mirror cannot continue the {key}"))
                .at(place.span.clone(), "goes with displacement and fields")
                .help("give the displacement: the velocity follows from it");
            section.reader.complain(problem);
        }
    }
    still(&section, spec, targets);
    section.finish();
    let region = region.filter(|_| mirror.is_some() == mirrored)?;
    given
        .iter()
        .zip(values)
        .map(|(t, (value, place))| {
            let condition = Condition {
                region: region.clone(),
                quantity: t.1.clone(),
                value: value?,
                mirror,
                until: until?,
            };
            Some((condition, place))
        })
        .collect()
}

/// The time after which a condition no longer holds: never, where none is given. Initial values have no such key.
fn until(section: &Section<'_>, coordinates: usize) -> Option<f64> {
    if coordinates < WITH_TIME || section.value("until").is_none() {
        return Some(f64::INFINITY);
    }
    section
        .positive("until", dimension::TIME)
        .map(|until| until.value)
}

/// Complains about motion where the law has none.
fn still(section: &Section<'_>, spec: &Spec, targets: &[Target]) {
    for key in ["displacement", "velocity", "body_force"] {
        let is_given = section.entries().iter().any(|e| e.key == key);
        let (true, true, Some(entry)) = (is_given, spec.force.is_empty(), section.entry(key))
        else {
            continue;
        };
        let names: Vec<&str> = targets.iter().map(|t| t.0.as_str()).collect();
        let problem = Problem::new(format!("`{key}` means nothing to `{}`", spec.law))
            .at(
                entry.key_span.clone(),
                "the law has no force, so that nothing moves",
            )
            .help(format!(
                "give one of {}, or choose a law that moves",
                names.join(", ")
            ));
        section.reader.complain(problem);
    }
}

fn reflects(quantity: &Quantity) -> bool {
    matches!(quantity, Quantity::Displacement | Quantity::Field(_))
}

const PARITIES: [(&str, Parity); 2] = [("odd", Parity::Odd), ("even", Parity::Even)];

/// `mirror = { point = [..], normal = [..], parity = "odd" }`.
fn mirror(section: &Section<'_>, dim: usize) -> Option<Mirror> {
    section.value("mirror")?;
    let table = section.section("mirror")?;
    let point = table.vector("point", dimension::LENGTH, dim);
    let point = table.require("point", point, "[\"0 mm\", ..], a point of the plane");
    let normal = table.vector("normal", dimension::NUMBER, dim);
    let normal = table.require("normal", normal, "[1, ..], the direction across the plane");
    let parity = match table.value("parity") {
        None => Some(Parity::Odd),
        Some(_) => table.choice("parity", &PARITIES),
    };
    table.finish();
    Some(Mirror {
        point: point?,
        normal: normal?,
        parity: parity?,
    })
}

/// The whole body when there is none.
pub(super) fn region(section: &Section<'_>, dim: usize) -> Option<Shape> {
    match section.value("region") {
        None => Some(Shape::All),
        Some(_) => shape::read(section, "region", dim),
    }
}

fn value(
    section: &Section<'_>,
    (key, _, unit, components): &Target,
    coordinates: usize,
) -> Option<Vec<Option<Expression>>> {
    let given = section.value(key)?;
    let items = match &given.data {
        Data::List(_) => section.reader.components(given, *components)?,
        _ if *components == 1 => std::slice::from_ref(given),
        _ => {
            return section
                .reader
                .wrong_type(given, &format!("a list of {components} components"));
        }
    };
    let read: Vec<_> = items
        .iter()
        .map(|v| component(section, v, *unit, coordinates))
        .collect();
    read.into_iter().collect()
}

/// An expression, or `"free"`.
fn component(
    section: &Section<'_>,
    value: &Value,
    unit: Exponents,
    coordinates: usize,
) -> Option<Option<Expression>> {
    let text = match &value.data {
        Data::Text(text) if text == "free" => return Some(None),
        Data::Text(text) => text.clone(),
        Data::Number(n, _) => n.to_string(),
        _ => String::new(),
    };
    let found = section
        .reader
        .expression(value, coordinates, Expected::Unit(unit))?;
    Some(Some(Expression {
        text,
        tape: found.tape,
    }))
}

/// `[[indenter]]`: a rigid sphere.
pub(super) fn indenter(section: Section<'_>, dim: usize) -> Option<Indenter> {
    let radius = section.positive("radius", dimension::LENGTH);
    let radius = section.require("radius", radius, "\"5 mm\"");
    let center = section.vector("center", dimension::LENGTH, dim);
    let center = section.require("center", center, "[\"0 mm\", ..], where it is at t = 0");
    let velocity = section.vector("velocity", dimension::VELOCITY, dim);
    let velocity = section.require("velocity", velocity, "[\"0 m/s\", ..]");
    let law = contact(&section);
    section.finish();
    Some(Indenter {
        center: center?,
        velocity: velocity?,
        radius: radius?.value,
        law: law?,
    })
}

fn contact(section: &Section<'_>) -> Option<ContactLaw> {
    let words = [("penalty", false), ("relocation", true)];
    if section.choice("contact", &words) == Some(true) {
        return Some(ContactLaw::Relocation);
    }
    let stiffness = section.positive("stiffness", dimension::CONTACT_STIFFNESS);
    let stiffness = section.require("stiffness", stiffness, "\"1e17 N/m^5\"")?;
    Some(ContactLaw::Penalty {
        stiffness: stiffness.value,
    })
}
