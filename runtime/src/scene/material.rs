//! `[material]`: the law, its parameters and influence functions.

use super::document::{Data, Value};
use super::family::Horizon;
use super::problem::Problem;
use super::section::{Placed, Section, listed};
use super::{family, shape};
use crate::engine::Law;
use crate::language::{Constant, dimension};
use crate::shape::Shape;
use crate::spec::{InfluenceFn, Number, ParamSpec};

/// A law with the values that a scene gives it.
#[derive(Clone)]
pub struct Material {
    /// Name or path of the law, as the scene gives it.
    pub model: String,
    pub law: Law,
    /// Mass density [kg/m^3]; `None` for a law that has no use for it. A parameter of the law that is called
    /// `density` is this one.
    pub density: Option<f64>,
    /// SI values, one per parameter of the law.
    pub params: Vec<f64>,
    /// Where the law has other values.
    pub parts: Vec<Part>,
    /// One per influence function of the law.
    pub influences: Vec<Influence>,
    /// Constants of the full family as sums over a full lattice family instead of integrals.
    pub lattice_constants: bool,
    /// Names of the law's weights that are 1 instead of computed.
    pub without: Vec<String>,
}

/// A region of another material: the same law with other values. Of several that overlap the last one counts.
#[derive(Clone, Debug)]
pub struct Part {
    pub region: Shape,
    pub density: Option<f64>,
    pub params: Vec<f64>,
    /// `None` for that of the family.
    pub horizon: Option<Horizon>,
}

impl Material {
    /// Density and parameter values of every material, the one outside of all parts first.
    pub fn sets(&self) -> Vec<(Option<f64>, Vec<f64>)> {
        let base = (self.density, self.params.clone());
        let parts = self.parts.iter().map(|p| (p.density, p.params.clone()));
        std::iter::once(base).chain(parts).collect()
    }

    /// The horizon of every material where that of the family is `base`.
    pub fn horizons<'a>(&'a self, base: &'a Horizon) -> Vec<&'a Horizon> {
        let parts = self.parts.iter();
        let parts = parts.map(|p| p.horizon.as_ref().unwrap_or(base));
        std::iter::once(base).chain(parts).collect()
    }
}

/// A choice of influence function.
#[derive(Clone, Debug, PartialEq)]
pub struct Influence {
    pub function: InfluenceFn,
    /// SI values, one per parameter of the function.
    pub values: Vec<f64>,
    /// As the scene writes it; `None` for the law's own default.
    pub text: Option<String>,
    /// What the names of the scene in this text stand for.
    pub constants: Vec<Constant>,
}

const WORDS: [(&str, bool); 2] = [("integral", false), ("lattice", true)];

pub(super) fn read(
    section: Section<'_>,
    dim: usize,
    spacing: Option<&Placed<f64>>,
) -> Option<Material> {
    let constants = section.choice("constants", &WORDS);
    let Some(law) = law(&section, dim) else {
        // Without the law, its parameters cannot be told from unknown keys.
        density(&section);
        section.abandon();
        return None;
    };
    let params: Vec<Option<f64>> = law
        .spec
        .params
        .iter()
        .map(|p| parameter(&section, p))
        .collect();
    let is_density = |p: &ParamSpec| p.name == "density" && p.exponents == dimension::DENSITY;
    let density = match law.spec.params.iter().position(is_density) {
        Some(k) => params[k].map(Some),
        None if law.spec.force.is_empty() => Some(None),
        None => density(&section).map(Some),
    };
    let parts: Vec<Option<Part>> = section
        .sections("part")
        .into_iter()
        .map(|part| self::part(part, &law, dim, spacing, density.flatten(), &params))
        .collect();
    let influences = influences(&section, &law);
    let without = without(&section, &law);
    let model = section.text("model").map(|m| m.value.to_string());
    section.finish();
    Some(Material {
        model: model?,
        density: density?,
        params: params.into_iter().collect::<Option<_>>()?,
        parts: parts.into_iter().collect::<Option<_>>()?,
        influences: influences?,
        lattice_constants: constants.unwrap_or(false),
        without,
        law,
    })
}

/// The weights that the scene sets to 1, `Gd = 1`.
fn without(section: &Section<'_>, law: &Law) -> Vec<String> {
    let mut names: Vec<&String> = law.spec.weights.iter().map(|w| &w.name).collect();
    names.dedup();
    let mut without = Vec::new();
    for name in names {
        let Some(found) = section.quantity(name, dimension::NUMBER) else {
            continue;
        };
        if found.value != 1.0 {
            let problem = Problem::new(format!("the weight `{name}` is computed, or 1"))
                .at(found.span, "not 1")
                .help("leave it out to have it computed, or set it to 1 to do without it");
            section.reader.complain(problem);
        }
        without.push(name.clone());
    }
    without
}

/// `[[material.part]]`: what a part does not give is as everywhere.
fn part(
    section: Section<'_>,
    law: &Law,
    dim: usize,
    spacing: Option<&Placed<f64>>,
    density: Option<f64>,
    params: &[Option<f64>],
) -> Option<Part> {
    let region = shape::read(&section, "region", dim);
    let region = section.require("region", region, "{ box = .. }, where this material is");
    let found = law.spec.params.iter().zip(params).map(|(p, base)| {
        match section.value(&p.name).is_some() {
            true => parameter(&section, p),
            false => *base,
        }
    });
    let found: Vec<Option<f64>> = found.collect();
    let is_density = |p: &ParamSpec| p.name == "density" && p.exponents == dimension::DENSITY;
    let density = match law.spec.params.iter().position(is_density) {
        Some(k) => found[k],
        None if law.spec.force.is_empty() => None,
        None if section.value("density").is_none() => density,
        None => Some(self::density(&section)?),
    };
    let named = law.spec.params.iter().any(|p| p.name == "horizon");
    let horizon = match section.value("horizon").is_some() && !named {
        true => Some(family::horizon(&section, spacing)?),
        false => None,
    };
    section.finish();
    Some(Part {
        horizon,
        region: region?,
        density,
        params: found.into_iter().collect::<Option<_>>()?,
    })
}

fn density(section: &Section<'_>) -> Option<f64> {
    let found = section.positive("density", dimension::DENSITY);
    let found = section.require("density", found, "\"2200 kg/m^3\"");
    found.map(|d| d.value)
}

fn law(section: &Section<'_>, dim: usize) -> Option<Law> {
    let name = section.text("model");
    let name = section.require(
        "model",
        name,
        "\"pmb\", a law of the catalogue or a .pd file",
    )?;
    let (language, directory) = (section.reader.language, section.reader.directory);
    let linearised = section.flag("linearised").unwrap_or(false);
    let found = language.law(name.value, directory, dim);
    let found = found.map_err(|error| (error, name.span.clone()));
    let found = found.and_then(|law| match section.value("linearised") {
        Some(asked) if linearised => {
            let found = language.linearised(name.value, directory, dim);
            found.map_err(|error| (error, asked.span.clone()))
        }
        _ => Ok(law),
    });
    match found {
        Ok(law) => Some(law),
        Err((error, place)) => {
            let problem = Problem::new(error.message).at(place, "");
            section.reader.complain(Problem {
                help: error.help,
                report: error.report,
                ..problem
            });
            None
        }
    }
}

fn parameter(section: &Section<'_>, param: &ParamSpec) -> Option<f64> {
    let default = default_of(param);
    if section.value(&param.name).is_none() && default.is_some() {
        return default;
    }
    let found = section.quantity(&param.name, param.exponents);
    let found = section.require(&param.name, found, &example(section, param))?;
    if let Some(allowed) = outside(param, found.value) {
        let shown = section.reader.shown(found.value, param.exponents);
        let problem = Problem::new(format!("`{}` is out of its bounds", param.name))
            .at(found.span, format!("this is {shown}, expected {allowed}"));
        section.reader.complain(match param.doc.is_empty() {
            true => problem,
            false => problem.help(format!("`{}` is the {}", param.name, param.doc)),
        });
        return None;
    }
    Some(found.value)
}

fn default_of(param: &ParamSpec) -> Option<f64> {
    match param.default? {
        Number::Finite(v) => Some(v),
        Number::Infinite => Some(f64::INFINITY),
    }
}

fn example(section: &Section<'_>, param: &ParamSpec) -> String {
    let value = match param.exponents {
        dimension::NUMBER => "..".to_string(),
        unit => format!("\".. {}\"", section.reader.language.unit_name(unit)),
    };
    if param.doc.is_empty() {
        value
    } else {
        format!("{value}, the {}", param.doc)
    }
}

/// The bounds in words, when `value` breaks them.
fn outside(param: &ParamSpec, value: f64) -> Option<String> {
    let below = param
        .lower
        .is_some_and(|(b, open)| value < b || (value == b && !open));
    let above = param
        .upper
        .is_some_and(|(b, open)| value > b || (value == b && !open));
    let side = |bound: Option<(f64, bool)>, strict: &str, loose: &str| {
        bound.map(|(b, included)| format!("{} {b}", if included { loose } else { strict }))
    };
    let words = [side(param.lower, ">", ">="), side(param.upper, "<", "<=")];
    (below || above).then(|| {
        words
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(" and ")
    })
}

/// `influence = "1/x"` for a law with one, `influence = { a = "1/x", b = .. }` for a law with several.
fn influences(section: &Section<'_>, law: &Law) -> Option<Vec<Influence>> {
    let slots = &law.spec.influences;
    let given: Vec<Option<&Value>> = match section.value("influence") {
        None => vec![None; slots.len()],
        Some(value) => match &value.data {
            Data::Table(_) => named(section, law)?,
            _ if slots.len() == 1 => vec![Some(value)],
            _ => {
                let law = &law.spec.law;
                let (label, help) = match slots.len() {
                    0 => (
                        "the law has none to choose",
                        "leave the key out".to_string(),
                    ),
                    _ => {
                        let names: Vec<&str> = slots.iter().map(|s| s.name.as_str()).collect();
                        (
                            "the law has several",
                            format!("give one for each of {}", listed(&names)),
                        )
                    }
                };
                let problem = Problem::new(format!("`influence` does not fit the law `{law}`"))
                    .at(value.span.clone(), label)
                    .help(help);
                section.reader.complain(problem);
                return None;
            }
        },
    };
    let found: Vec<_> = slots
        .iter()
        .zip(given)
        .map(|(slot, value)| influence(section, slot, value))
        .collect();
    found.into_iter().collect()
}

fn named<'a>(section: &Section<'a>, law: &Law) -> Option<Vec<Option<&'a Value>>> {
    let table = section.section("influence")?;
    let given = law
        .spec
        .influences
        .iter()
        .map(|slot| table.value(&slot.name))
        .collect();
    table.finish();
    Some(given)
}

fn influence(
    section: &Section<'_>,
    slot: &crate::spec::InfluenceSpec,
    value: Option<&Value>,
) -> Option<Influence> {
    match (value, &slot.default) {
        (Some(place), _) if matches!(place.data, Data::Text(_)) => chosen(section, place),
        (Some(value), _) => section
            .reader
            .wrong_type(value, "an influence function in quotes"),
        (None, Some(default)) => Some(Influence {
            function: default.clone(),
            values: default
                .params
                .iter()
                .map(default_of)
                .collect::<Option<_>>()?,
            text: None,
            constants: Vec::new(),
        }),
        (None, None) => section.require(
            "influence",
            None,
            "\"softened(p = 0, eps = 0.5 mm)\" or an expression such as \"1/x\"",
        ),
    }
}

fn chosen(section: &Section<'_>, place: &Value) -> Option<Influence> {
    let Data::Text(text) = &place.data else {
        return None;
    };
    let constants = section.reader.constants();
    match section.reader.language.influence(text, &constants) {
        Ok((function, values)) => Some(Influence {
            function,
            values,
            text: Some(text.clone()),
            constants,
        }),
        Err(complaints) => {
            section.reader.complain_all(complaints, text, place);
            None
        }
    }
}
