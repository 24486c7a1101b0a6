//! A law with the numbers that it is verified at.
//!
//! Input: a law and what the caller chose. Output: a value for every parameter (chosen, else a usual one of its name
//! or unit within its bounds, else its default), an influence function for every slot, and the lengths of the bodies.

use pdlang::assemble::Kinematics;
use pdlang::diag::Diagnostic;
use pdlang::ir::{Bound, Flavour, InfluenceFn, Law, Param};
use pdlang::oracle::{self, Ball};
use pdlang::units::Unit;
use pdlang_runtime::engine;
use std::cell::OnceCell;

use super::bodies::DX;
use super::repair::{self, Cure};
use crate::language;

/// Spacings in a horizon, on all bodies, unless the caller chooses.
pub const REACH: f64 = 3.0;
/// Thickness of plates [m], cross-section of bars [m^2] of the quadratures.
pub const CROSS: f64 = 1.25e-3;

/// What a caller may choose.
#[derive(Clone, Debug)]
pub struct Options {
    /// Name and SI value.
    pub params: Vec<(String, f64)>,
    /// Influence function of every slot.
    pub influence: Option<(InfluenceFn, Vec<f64>)>,
    /// Horizon [m].
    pub horizon: f64,
    /// Spacings in it.
    pub reach: f64,
    /// Mass density [kg/m^3], where the law has no parameter for it.
    pub density: f64,
    /// As the keys of a scene: constants of a full family by its sum; bonds that the horizon cuts count in part.
    pub lattice_constants: bool,
    pub partial_volume: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            params: Vec::new(),
            influence: None,
            horizon: REACH * DX,
            reach: REACH,
            density: 2200.0,
            lattice_constants: false,
            partial_volume: false,
        }
    }
}

/// A law at certain values.
pub struct Subject<'a> {
    pub law: &'a Law,
    pub text: &'a str,
    /// SI values, one per parameter.
    pub params: Vec<f64>,
    /// One per influence slot, with its parameters.
    pub influences: Vec<(InfluenceFn, Vec<f64>)>,
    /// [m]
    pub horizon: f64,
    /// Spacings in it.
    pub reach: f64,
    pub density: f64,
    pub lattice_constants: bool,
    pub partial_volume: bool,
    /// What may mend wrong constants; asked once.
    cures: OnceCell<Vec<(Flavour, Cure)>>,
    /// Of one, two and three dimensions; made where it is asked for, which takes seconds for a large law.
    compiled: [OnceCell<Result<engine::Law, String>>; 3],
}

impl<'a> Subject<'a> {
    /// # Errors
    /// When a parameter that is chosen does not exist, or is outside of its bounds.
    pub fn new(law: &'a Law, text: &'a str, options: &Options) -> Result<Subject<'a>, String> {
        let spacing = options.horizon / options.reach;
        for (name, value) in &options.params {
            let Some(param) = law.params.iter().find(|p| p.name == *name) else {
                let names: Vec<&str> = law.params.iter().map(|p| p.name.as_str()).collect();
                let list = names.join(", ");
                return Err(format!(
                    "`{}` has no parameter `{name}`; it has {list}",
                    law.name
                ));
            };
            if !fits(param, *value) {
                return Err(format!(
                    "{name} = {value} is outside of the bounds of `{name}`"
                ));
            }
        }
        let chosen = |p: &Param| {
            let given = options
                .params
                .iter()
                .rev()
                .find(|(name, _)| *name == p.name);
            given.map(|(_, value)| *value)
        };
        let params: Vec<f64> = (law.params.iter())
            .map(|p| chosen(p).unwrap_or_else(|| value(p, spacing)))
            .collect();
        let influence = |slot: &pdlang::ir::Influence| match (&options.influence, &slot.default) {
            (Some(chosen), _) => chosen.clone(),
            (None, Some(default)) => (default.clone(), Vec::new()),
            (None, None) => (constant(), Vec::new()),
        };
        let named = |name: &str| law.params.iter().position(|p| p.name == name);
        let density = named("density").or_else(|| named("rho")).map(|k| params[k]);
        Ok(Subject {
            law,
            text,
            influences: law.influences.iter().map(influence).collect(),
            horizon: options.horizon,
            reach: options.reach,
            density: density.unwrap_or(options.density),
            lattice_constants: options.lattice_constants,
            partial_volume: options.partial_volume,
            params,
            cures: OnceCell::new(),
            compiled: Default::default(),
        })
    }

    /// What may mend the constants that are wrong, by flavour.
    pub fn cures(&self) -> &[(Flavour, Cure)] {
        self.cures.get_or_init(|| repair::find(self))
    }

    /// The spacing of lattices [m].
    pub fn spacing(&self) -> f64 {
        self.horizon / self.reach
    }

    /// The law as the engine takes it.
    ///
    /// # Errors
    /// When it is too large.
    pub fn compiled(&self, flavour: Flavour) -> Result<engine::Law, String> {
        let dim = flavour.dim();
        if !self.law.flavours.iter().any(|f| f.dim() == dim) {
            return Err("the law is not for this flavour".into());
        }
        let made = self.compiled[dim - 1].get_or_init(|| {
            let first =
                |found: Vec<Diagnostic>| found.first().map_or(String::new(), |d| d.message.clone());
            language::interpreted(self.law, dim, Kinematics::General).map_err(first)
        });
        made.clone()
    }

    /// What the oracle is asked with.
    pub fn settings(&self, flavour: Flavour, ball: Ball) -> oracle::Settings {
        oracle::Settings {
            flavour,
            params: self.params.clone(),
            influences: self.influences.clone(),
            horizon: self.horizon,
            ball,
            without: Vec::new(),
        }
    }

    /// The value of a parameter by its name.
    pub fn param(&self, name: &str) -> Option<f64> {
        let k = self.law.params.iter().position(|p| p.name == name)?;
        Some(self.params[k])
    }
}

/// The influence function of a slot without a default.
fn constant() -> InfluenceFn {
    let all = pdlang::front::influences().iter();
    let found = all
        .clone()
        .find(|f| f.name == "constant")
        .or_else(|| all.clone().next());
    found.expect("the prelude has influence functions").clone()
}

/// Whether a parameter may have this value.
pub fn fits(param: &Param, value: f64) -> bool {
    let inside = |bound: Option<Bound>, side: f64| match bound {
        Some(b) if b.inclusive => (value - b.value) * side >= 0.0,
        Some(b) => (value - b.value) * side > 0.0,
        None => true,
    };
    !value.is_nan() && inside(param.lower, 1.0) && inside(param.upper, -1.0)
}

/// Exponents of metre, kilogram, second, ampere and kelvin.
type Exponents = [i16; 5];
pub const PRESSURE: Exponents = [-1, 1, -2, 0, 0];
const LENGTH: Exponents = [1, 0, 0, 0, 0];
pub const TEMPERATURE: Exponents = [0, 0, 0, 0, 1];
pub const CONDUCTIVITY: Exponents = [1, 1, -3, 0, -1];
pub const EXPANSION: Exponents = [0, 0, 0, 0, -1];
pub const HEAT_SUPPLY: Exponents = [-1, 1, -3, 0, 0];
pub const FORCE_DENSITY: Exponents = [-2, 1, -2, 0, 0];
pub const RELEASE_RATE: Exponents = [0, 1, -2, 0, 0];

/// Whether a unit has these exponents, whatever influence functions add.
pub fn has_unit(unit: &Unit, exponents: Exponents) -> bool {
    // Exponents are stored twice, so that roots have them.
    (0..5).all(|k| unit.base[k] == 2 * exponents[k])
}

/// A value for a parameter: usual, its default, or anything within its bounds.
fn value(param: &Param, spacing: f64) -> f64 {
    let of_kind = || match () {
        () if has_unit(&param.unit, PRESSURE) => Some(MODULUS),
        () if has_unit(&param.unit, LENGTH) => Some(spacing),
        _ => None,
    };
    let choices = [
        usual(&param.name, spacing),
        param.default,
        of_kind(),
        Some(1.0),
        Some(0.25),
    ];
    let middle = match (param.lower, param.upper) {
        (Some(a), Some(b)) => 0.5 * (a.value + b.value),
        (Some(a), None) => a.value + a.value.abs().max(1.0),
        (None, Some(b)) => b.value - b.value.abs().max(1.0),
        _ => 1.0,
    };
    let found = choices.into_iter().flatten().find(|v| fits(param, *v));
    found.unwrap_or(middle)
}

/// Bulk and shear modulus [Pa]; Poisson's ratio is 0.322.
pub const MODULUS: f64 = 14.9e9;
pub const SHEAR: f64 = 6.0e9;

/// The value that a parameter of this name usually has in the tests; `spacing` is that of the bodies.
pub fn usual(name: &str, spacing: f64) -> Option<f64> {
    let (k, g) = (MODULUS, SHEAR);
    Some(match name {
        "K" | "kappa" => k,
        "G" | "mu" => g,
        "E" => 9.0 * k * g / (3.0 * k + g),
        "nu" => (3.0 * k - 2.0 * g) / (6.0 * k + 2.0 * g),
        "lambda" => k - 2.0 * g / 3.0,
        // Neither pure matrix nor isotropic: Q12 differs from G12, and Q22 from 3 G12.
        "E1" => 40e9,
        "E2" => 10e9,
        "G12" => 2.5e9,
        "nu12" => 0.3,
        // Resin, and plies at the spacing of the bodies.
        "Em" => 3e9,
        "Gm" => 1.2e9,
        "h" => spacing,
        // Reached by some nodes of a body strained by a percent, and not by others.
        "tauy" => 5e7,
        "share" => 0.6,
        "tau" => 1e-6,
        "k" => 1.4,
        "rho" | "density" => 2200.0,
        // Large enough for heat of deformation and conduction to weigh alike in random states.
        "alpha" => 1e-5,
        "T0" => 293.0,
        "cv" => 840.0,
        _ => return None,
    })
}
