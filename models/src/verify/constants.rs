//! Constants of the continuum, against the parameters that declare them.
//!
//! What a law implies is asked of one node under uniform gradients, with a quadrature for its family: moduli from the
//! curvature of the energy or the slope of the stress, expansion from the stress of a temperature, conductivity from the
//! rate of a quadratic temperature. What it declares are its parameters, by their names (`K`, `G`, `E`, `nu`, `lambda`,
//! `alpha`, `k`; `E1`, `E2`, `G12`, `nu12` of a lamina) or descriptions. With a single elastic parameter Poisson's ratio
//! is that of bonds, 1/4, and 1/3 in plane stress. Where a constant is wrong, [`super::repair`] looks for the definition.

use pdlang::ir::{Flavour, Law, Response};
use pdlang::oracle::{Ball, Body, Oracle, Settings, Value};
use std::cell::OnceCell;

use super::ask;
use super::continuum::{self, Point};
use super::subject::{
    CONDUCTIVITY, CROSS, EXPANSION, HEAT_SUPPLY, PRESSURE, Subject, TEMPERATURE, has_unit,
};
use super::{Level, Verdict};

/// Relative error of a constant of the continuum.
pub const EXACT: f64 = 1e-6;
/// What a lattice may be off before it is worth a warning.
pub const LATTICE: f64 = 0.2;
const RADIAL: usize = 24;
const RADIAL_RINGS: usize = 14;

/// A constant that can be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// What resists the isotropic strain of the flavour: `W = K_d theta^2/2`.
    Isotropic,
    /// What resists a shear along the axes, and one along the diagonals.
    Shear,
    Diagonal,
    /// Stiffness of a lamina: both numbers are directions; 6 is the shear.
    Lamina(u8, u8),
    /// By the number of the field.
    Expansion(usize),
    Conductivity(usize),
}

impl Quantity {
    pub fn name(self, flavour: Flavour) -> String {
        match (self, flavour) {
            (Quantity::Isotropic, Flavour::Bar) => "E".into(),
            (Quantity::Isotropic, Flavour::Slab) => "K + 4 G/3".into(),
            (Quantity::Isotropic, Flavour::PlaneStress) => "E/(2 (1 - nu))".into(),
            (Quantity::Isotropic, Flavour::PlaneStrain) => "K + G/3".into(),
            (Quantity::Isotropic, Flavour::Solid) => "K".into(),
            (Quantity::Shear, _) => "G".into(),
            (Quantity::Diagonal, _) => "G along diagonals".into(),
            (Quantity::Lamina(a, b), _) => format!("Q{a}{b}"),
            (Quantity::Expansion(_), _) => "alpha".into(),
            (Quantity::Conductivity(_), _) => "k".into(),
        }
    }
}

/// The quadratures of a flavour.
pub struct Families {
    pub flavour: Flavour,
    one: Body,
    /// Of the families of neighbours, for laws that look far.
    coarse: Option<Vec<Point>>,
    rings: OnceCell<Body>,
}

impl Families {
    fn new(law: &Law, flavour: Flavour, points: &[Point], coarse: &[Point]) -> Families {
        let rate = |r: &Response| matches!(r, Response::Rate(..) | Response::Force(_));
        let looks_far = law.responses.iter().any(rate);
        Families {
            flavour,
            one: continuum::single(points),
            coarse: looks_far.then(|| coarse.to_vec()),
            rings: OnceCell::new(),
        }
    }

    fn rings(&self) -> Option<&Body> {
        let coarse = self.coarse.as_ref()?;
        Some(self.rings.get_or_init(|| continuum::two_rings(coarse)))
    }

    /// Of the continuum.
    pub fn continuum(law: &Law, flavour: Flavour, horizon: f64) -> Families {
        Families::of_ball(law, flavour, horizon, (true, RADIAL_RINGS))
    }

    /// Of the continuum, for many questions.
    pub fn coarse(law: &Law, flavour: Flavour, horizon: f64) -> Families {
        Families::of_ball(law, flavour, horizon, (false, 7))
    }

    fn of_ball(
        law: &Law,
        flavour: Flavour,
        horizon: f64,
        (fine, radial): (bool, usize),
    ) -> Families {
        let dim = flavour.dim();
        let cross = cross(flavour);
        let mut points = continuum::ball(dim, horizon, cross, RADIAL, fine);
        if law.families.len() > 1 {
            let volume = points.iter().map(|(_, w)| w).sum();
            points.extend(continuum::needles(dim, horizon, volume));
        }
        let rings = continuum::ball(dim, horizon, cross, radial, false);
        Families::new(law, flavour, &points, &rings)
    }

    /// Of the lattice.
    pub fn lattice(subject: &Subject, flavour: Flavour) -> Families {
        let points = lattice_points(subject, flavour);
        Families::new(subject.law, flavour, &points, &points)
    }
}

/// Thickness or cross-section of the quadratures.
pub fn cross(flavour: Flavour) -> f64 {
    if flavour == Flavour::Solid {
        1.0
    } else {
        CROSS
    }
}

/// The family of a node of the subject's lattice.
pub fn lattice_points(subject: &Subject, flavour: Flavour) -> Vec<Point> {
    let (dim, spacing) = (flavour.dim(), subject.spacing());
    let mut points = continuum::lattice(dim, spacing, subject.reach, cross(flavour));
    if subject.partial_volume {
        for (xi, weight) in &mut points {
            let length = xi.iter().map(|c| c * c).sum::<f64>().sqrt();
            *weight *= ((subject.horizon - length) / spacing + 0.5).min(1.0);
        }
    }
    points
}

/// What the oracle is asked with on the subject's lattice.
pub fn lattice_settings(subject: &Subject, flavour: Flavour) -> Settings {
    match subject.lattice_constants {
        true => subject.settings(flavour, Ball::Lattice(lattice_points(subject, flavour))),
        false => settings(subject, flavour, &subject.params),
    }
}

/// What the oracle is asked with.
pub fn settings(subject: &Subject, flavour: Flavour, params: &[f64]) -> Settings {
    let ball = Ball::Integral {
        cross: cross(flavour),
    };
    Settings {
        params: params.to_vec(),
        ..subject.settings(flavour, ball)
    }
}

/// A constant of a law.
///
/// # Errors
/// What the oracle cannot answer.
pub fn measure(
    what: Quantity,
    law: &Law,
    families: &Families,
    settings: &Settings,
) -> Result<f64, String> {
    let dim = families.flavour.dim();
    let text = |error: pdlang::oracle::Error| error.to_string();
    let unit = |a: usize, b: usize, value: f64| {
        let mut h = [[0.0; 3]; 3];
        (h[a][b], h[b][a]) = (value, value);
        h
    };
    let isotropic: [[f64; 3]; 3] =
        std::array::from_fn(|a| std::array::from_fn(|b| f64::from(u8::from(a == b && a < dim))));
    let diagonal = [[0.5, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0; 3]];
    if let Quantity::Conductivity(field) = what {
        return conductivity(field, law, families, settings);
    }
    let stated = law
        .responses
        .iter()
        .any(|r| matches!(r, Response::Force(_)));
    // Made where it is needed alone: a bond between any two nodes is much.
    if stated && let Some(rings) = families.rings() {
        return stated_modulus(what, law, rings, settings, dim);
    }
    let oracle = Oracle::new(law, &families.one, settings).map_err(text)?;
    let mut state = oracle.state();
    let stiffness = |a, b| {
        oracle
            .stiffness(&oracle.state(), 0, &[[0.0; 3]; 3], (a, b))
            .map_err(text)
    };
    match what {
        Quantity::Isotropic => Ok(stiffness(&isotropic, &isotropic)? / (dim * dim) as f64),
        Quantity::Shear => stiffness(&unit(0, 1, 0.5), &unit(0, 1, 0.5)),
        Quantity::Diagonal => stiffness(&diagonal, &diagonal),
        Quantity::Lamina(a, b) => {
            let strain = |k: u8| match k {
                6 => unit(0, 1, 0.5),
                k => unit(k as usize - 1, k as usize - 1, 1.0),
            };
            stiffness(&strain(a), &strain(b))
        }
        Quantity::Expansion(field) => {
            let stiff = stiffness(&isotropic, &isotropic)?;
            state.fields[field] = vec![Value::Scalar(1.0)];
            let stress = oracle
                .stress(&state, 0, &[[0.0; 3]; 3], &isotropic)
                .map_err(text)?;
            Ok(-stress / stiff)
        }
        Quantity::Conductivity(_) => Ok(0.0),
    }
}

/// A modulus of a law that states the force of a node: by quadratic displacements, from the divergence of the stress.
fn stated_modulus(
    what: Quantity,
    law: &Law,
    rings: &Body,
    settings: &Settings,
    dim: usize,
) -> Result<f64, String> {
    let text = |error: pdlang::oracle::Error| error.to_string();
    let oracle = Oracle::new(law, rings, settings).map_err(text)?;
    let state = oracle.state();
    let by = |shape: &dyn Fn([f64; 3]) -> f64| {
        let du: Vec<[f64; 3]> = rings
            .nodes
            .iter()
            .map(|n| [shape(n.position), 0.0, 0.0])
            .collect();
        let force = oracle.stated_force(&state, 0, &du).map_err(text)?;
        Ok::<f64, String>(force[0])
    };
    let along = by(&|x| 0.5 * x[0] * x[0])?;
    match (what, dim) {
        (Quantity::Isotropic, 1) => Ok(along),
        (Quantity::Isotropic, dim) => {
            let shear = by(&|x| 0.5 * x[1] * x[1])?;
            Ok(along - 2.0 * shear * (dim as f64 - 1.0) / dim as f64)
        }
        (Quantity::Shear | Quantity::Diagonal, _) => by(&|x| 0.5 * x[1] * x[1]),
        _ => Err("a law with a force of a node is asked for moduli only".into()),
    }
}

fn conductivity(
    field: usize,
    law: &Law,
    families: &Families,
    settings: &Settings,
) -> Result<f64, String> {
    let text = |error: pdlang::oracle::Error| error.to_string();
    let rings = families.rings().ok_or("the law has no rate")?;
    let oracle = Oracle::new(law, rings, settings).map_err(text)?;
    let mut state = oracle.state();
    let id = pdlang::ir::FieldId(field as u32);
    let rate = |state: &pdlang::oracle::State| {
        let rate = oracle
            .rate(state, id, 0)
            .map_err(text)?
            .ok_or("the field has no rate")?;
        rate.scalar().map_err(text)
    };
    let capacity = match ask::scalar_fields(law, HEAT_SUPPLY).first() {
        Some((source, ..)) => {
            let mut fed = state.clone();
            fed.fields[*source] = vec![Value::Scalar(1.0); rings.nodes.len()];
            1.0 / (rate(&fed)? - rate(&state)?)
        }
        None => capacity(law, &settings.params).unwrap_or(1.0),
    };
    let scale = settings.horizon * settings.horizon;
    let warm =
        |n: &pdlang::oracle::Node| Value::Scalar(0.5 * n.position[0] * n.position[0] / scale);
    state.fields[field] = rings.nodes.iter().map(warm).collect();
    Ok(rate(&state)? * scale * capacity)
}

/// Density times specific heat, where the law has both.
pub fn capacity(law: &Law, params: &[f64]) -> Option<f64> {
    let value = |name: &str, words: &str| {
        let found = |p: &&pdlang::ir::Param| p.name == name || p.doc == words;
        law.params.iter().position(|p| found(&p)).map(|k| params[k])
    };
    let density = value("density", "mass density").or_else(|| value("rho", "mass density"));
    Some(density? * value("cv", "specific heat")?)
}

/// Bulk and shear modulus that a law declares.
pub fn declared(law: &Law, params: &[f64], flavour: Flavour) -> Option<(f64, f64)> {
    let value = |names: &[&str], words: &str, pressure: bool| {
        let fits = |p: &pdlang::ir::Param| has_unit(&p.unit, PRESSURE) == pressure;
        let named = law
            .params
            .iter()
            .position(|p| fits(p) && names.contains(&p.name.as_str()));
        let found = named.or_else(|| law.params.iter().position(|p| fits(p) && p.doc == words));
        found.map(|k| params[k])
    };
    let k = value(&["K", "kappa"], "bulk modulus", true);
    let g = value(&["G", "mu"], "shear modulus", true);
    let e = value(&["E"], "Young's modulus", true);
    let nu = value(&["nu"], "Poisson's ratio", false);
    let lambda = value(&["lambda"], "first Lame parameter", true);
    let of_nu = |e: f64, nu: f64| (e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
    let of_bonds = if flavour == Flavour::PlaneStress {
        1.0 / 3.0
    } else {
        0.25
    };
    match (k, g, e, nu, lambda) {
        (Some(k), Some(g), ..) => Some((k, g)),
        (Some(k), _, Some(e), ..) => Some((k, 3.0 * k * e / (9.0 * k - e))),
        (_, Some(g), Some(e), ..) => Some((e * g / (3.0 * (3.0 * g - e)), g)),
        (Some(k), _, _, Some(nu), _) => Some(of_nu(3.0 * k * (1.0 - 2.0 * nu), nu)),
        (_, Some(g), _, Some(nu), _) => Some(of_nu(2.0 * g * (1.0 + nu), nu)),
        (_, _, Some(e), Some(nu), _) => Some(of_nu(e, nu)),
        (Some(k), .., Some(lambda)) => Some((k, 1.5 * (k - lambda))),
        (_, Some(g), .., Some(lambda)) => Some((lambda + 2.0 * g / 3.0, g)),
        (_, _, _, Some(nu), Some(lambda)) => {
            Some(of_nu(lambda * (1.0 + nu) * (1.0 - 2.0 * nu) / nu, nu))
        }
        (Some(k), None, None, None, None) => {
            Some(of_nu(3.0 * k * (1.0 - 2.0 * of_bonds), of_bonds))
        }
        (None, Some(g), None, None, None) => Some(of_nu(2.0 * g * (1.0 + of_bonds), of_bonds)),
        (None, None, Some(e), None, None) => Some(of_nu(e, of_bonds)),
        _ => None,
    }
}

/// The value that a law declares for a constant.
pub fn expected(what: Quantity, law: &Law, params: &[f64], flavour: Flavour) -> Option<f64> {
    let named = |name: &str| {
        law.params
            .iter()
            .position(|p| p.name == name)
            .map(|k| params[k])
    };
    let moduli = declared(law, params, flavour);
    match what {
        Quantity::Isotropic => {
            let (k, g) = moduli?;
            Some(match flavour {
                Flavour::Bar => 9.0 * k * g / (3.0 * k + g),
                Flavour::Slab => k + 4.0 * g / 3.0,
                Flavour::PlaneStress => 9.0 * k * g / (3.0 * k + 4.0 * g),
                Flavour::PlaneStrain => k + g / 3.0,
                Flavour::Solid => k,
            })
        }
        Quantity::Shear | Quantity::Diagonal => moduli.map(|(_, g)| g),
        Quantity::Lamina(a, b) => {
            let (e1, e2, nu) = (named("E1")?, named("E2")?, named("nu12")?);
            let q22 = e2 / (1.0 - nu * nu * e2 / e1);
            Some(match (a, b) {
                (1, 1) => q22 * e1 / e2,
                (2, 2) => q22,
                (6, 6) => named("G12")?,
                _ => nu * q22,
            })
        }
        Quantity::Expansion(_) => {
            let alpha = named("alpha").or_else(|| {
                let words = |p: &pdlang::ir::Param| {
                    has_unit(&p.unit, EXPANSION) && p.doc.contains("thermal expansion")
                };
                law.params.iter().position(words).map(|k| params[k])
            });
            let (k, g) = moduli?;
            let nu = (3.0 * k - 2.0 * g) / (6.0 * k + 2.0 * g);
            alpha.map(|alpha| match flavour {
                Flavour::PlaneStrain => alpha * (1.0 + nu),
                Flavour::Slab => alpha * (1.0 + nu) / (1.0 - nu),
                _ => alpha,
            })
        }
        Quantity::Conductivity(_) => {
            let conducts = |p: &pdlang::ir::Param| {
                has_unit(&p.unit, CONDUCTIVITY) || has_unit(&p.unit, [2, 0, -1, 0, 0])
            };
            law.params.iter().position(conducts).map(|k| params[k])
        }
    }
}

/// The constants that a law declares in a flavour.
pub fn quantities(law: &Law, params: &[f64], flavour: Flavour) -> Vec<Quantity> {
    let mut list = vec![Quantity::Isotropic];
    if flavour.dim() > 1 {
        list.extend([Quantity::Shear, Quantity::Diagonal]);
    }
    if flavour == Flavour::PlaneStress {
        let pairs = [(1, 1), (2, 2), (1, 2), (6, 6)];
        list.extend(pairs.map(|(a, b)| Quantity::Lamina(a, b)));
    }
    let turned = law
        .params
        .iter()
        .zip(params)
        .any(|(p, v)| p.name == "angle" && *v != 0.0);
    list.retain(|q| !(turned && matches!(q, Quantity::Lamina(..))));
    let moves = law
        .responses
        .iter()
        .any(|r| !matches!(r, Response::Rate(..)));
    if !moves {
        list.clear();
    }
    if let [(field, ..)] = ask::scalar_fields(law, TEMPERATURE)[..]
        && moves
    {
        list.push(Quantity::Expansion(field));
    }
    for response in &law.responses {
        if let Response::Rate(field, _) = response
            && law.fields[field.index()].shape == pdlang::ir::Shape::Scalar
        {
            list.push(Quantity::Conductivity(field.index()));
        }
    }
    list.retain(|q| expected(*q, law, params, flavour).is_some());
    list
}

pub fn check(subject: &Subject, flavour: Flavour) -> Result<Vec<Verdict>, String> {
    let law = subject.law;
    let list = quantities(law, &subject.params, flavour);
    if list.is_empty() {
        let why = "the law declares no constant of the continuum by its usual name";
        return Ok(["constants", "lattice_constants"]
            .map(|check| Verdict::skip(check, flavour, why))
            .to_vec());
    }
    let settings = settings(subject, flavour, &subject.params);
    let families = Families::continuum(law, flavour, subject.horizon);
    let mut found = Vec::new();
    for &what in &list {
        let expected = expected(what, law, &subject.params, flavour).unwrap_or_default();
        found.push((what, measure(what, law, &families, &settings)?, expected));
    }
    let off = |measured: f64, expected: f64| {
        let scale = if expected == 0.0 { 1.0 } else { expected };
        let error = ((measured - expected) / scale).abs();
        if error.is_nan() { f64::INFINITY } else { error }
    };
    let wrong = found
        .iter()
        .any(|(_, measured, expected)| off(*measured, *expected) > EXACT);
    let cure = match wrong {
        true => subject
            .cures()
            .iter()
            .find(|(f, _)| *f == flavour)
            .map(|(_, cure)| cure),
        false => None,
    };
    let mut verdicts = Vec::new();
    for &(what, measured, expected) in &found {
        let level = if off(measured, expected) <= EXACT {
            Level::Pass
        } else {
            Level::Fail
        };
        let verdict = Verdict {
            measured: Some(measured),
            expected: Some(expected),
            ..Verdict::new("constants", flavour, level)
        };
        let verdict = verdict.of(what.name(flavour));
        let responsible = match what {
            Quantity::Conductivity(field) => subject.rate_place(field),
            _ => subject.force_place(),
        };
        let (place, advice) = match &cure {
            Some(cure) => (Some(cure.place.clone()), cure.advice.clone()),
            None => (responsible, String::new()),
        };
        verdicts.push(verdict.blames(place, |name| {
            let times = measured / expected;
            let name_ = what.name(flavour);
            match advice.is_empty() {
                true => format!("{name_} of the continuum is {times:.6} of the declared one: it comes from {name}"),
                false => format!("{name_} of the continuum is {times:.6} of the declared one: {advice}"),
            }
        }));
    }
    verdicts.extend(lattice(subject, flavour, &found)?);
    Ok(verdicts)
}

/// The same of a lattice: what a coarse body has.
fn lattice(
    subject: &Subject,
    flavour: Flavour,
    found: &[(Quantity, f64, f64)],
) -> Result<Vec<Verdict>, String> {
    let families = Families::lattice(subject, flavour);
    let settings = lattice_settings(subject, flavour);
    let mut verdicts = Vec::new();
    let known = |(_, value, _): &&(Quantity, f64, f64)| value.is_finite() && *value != 0.0;
    for &(what, continuum, _) in found.iter().filter(known) {
        let measured = measure(what, subject.law, &families, &settings)?;
        let ratio = measured / continuum;
        let level = if (ratio - 1.0).abs() <= LATTICE {
            Level::Pass
        } else {
            Level::Warn
        };
        let verdict = Verdict {
            measured: Some(measured),
            expected: Some(continuum),
            ..Verdict::new("lattice_constants", flavour, level)
        };
        let place = subject.force_place().or_else(|| match what {
            Quantity::Conductivity(field) => subject.rate_place(field),
            _ => None,
        });
        let reach = subject.reach;
        verdicts.push(verdict.of(what.name(flavour)).blames(place, |name| {
            format!(
                "{} of a lattice with {reach} spacings in a horizon is {ratio:.2} of that of the continuum, by {name}: `constants = \"lattice\"` or `partial_volume` in the scene's [family] may mend it",
                what.name(flavour)
            )
        }));
    }
    Ok(verdicts)
}
