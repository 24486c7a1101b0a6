//! What a scene needs to know about the language: expressions, laws and influence functions as data.
//!
//! The runtime does not know the compiler. Whoever reads a scene hands in a [`Language`]; `models` has
//! the one that compiles.

use std::ops::Range;
use std::path::Path;

use crate::engine::Law;
use crate::spec::{InfluenceFn, Tape};

/// Seven SI exponents (m, kg, s, A, K, mol, cd), doubled, as in [`crate::spec::ParamSpec`].
pub type Exponents = [i16; 7];

/// The dimensions that scenes ask for.
pub mod dimension {
    use super::Exponents;

    pub const NUMBER: Exponents = [0; 7];
    pub const LENGTH: Exponents = [2, 0, 0, 0, 0, 0, 0];
    pub const AREA: Exponents = [4, 0, 0, 0, 0, 0, 0];
    pub const VOLUME: Exponents = [6, 0, 0, 0, 0, 0, 0];
    pub const TIME: Exponents = [0, 0, 2, 0, 0, 0, 0];
    pub const VELOCITY: Exponents = [2, 0, -2, 0, 0, 0, 0];
    pub const DENSITY: Exponents = [-6, 2, 0, 0, 0, 0, 0];
    pub const FORCE_DENSITY: Exponents = [-4, 2, -4, 0, 0, 0, 0];
    pub const POWER_DENSITY: Exponents = [-2, 2, -6, 0, 0, 0, 0];
    /// Force density per square of the penetration, N m^-5.
    pub const CONTACT_STIFFNESS: Exponents = [-8, 2, -4, 0, 0, 0, 0];
}

/// A variable of a scene expression: a coordinate, the time, or a named constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    pub name: String,
    pub unit: Exponents,
}

/// A name for a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    pub name: String,
    /// In SI units.
    pub value: f64,
    pub unit: Exponents,
}

/// What an expression must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// A scalar of any unit.
    Scalar,
    /// A scalar of this unit. An expression in which no unit appears at all is taken to be in SI units.
    Unit(Exponents),
    /// A truth value.
    Condition,
}

/// An expression that reads `Var(k)`, the k-th variable; one output.
#[derive(Clone, Debug, PartialEq)]
pub struct Compiled {
    pub tape: Tape,
    pub unit: Exponents,
}

/// What is wrong with a text: byte range in that text, message, label at the place, remedy.
#[derive(Clone, Debug, PartialEq)]
pub struct Complaint {
    pub span: Range<usize>,
    pub message: String,
    pub label: String,
    pub help: Option<String>,
}

/// Why a law cannot be had.
#[derive(Clone, Debug, PartialEq)]
pub struct LawError {
    pub message: String,
    pub help: Option<String>,
    /// Rendered diagnostics of the law's own text, where it has errors.
    pub report: Option<String>,
}

/// The language, as a scene sees it.
pub trait Language: Sync {
    /// Compiles an expression in `variables`.
    ///
    /// # Errors
    /// Everything that is wrong with the text, in the order of its places.
    fn expression(
        &self,
        text: &str,
        variables: &[Variable],
        expected: Expected,
    ) -> Result<Compiled, Vec<Complaint>>;

    /// A law at dimension `dim` by the name of the catalogue, or by the path of a `.pd` file relative to `directory`.
    ///
    /// # Errors
    /// When there is no such law, or when its text has errors.
    fn law(&self, name: &str, directory: &Path, dim: usize) -> Result<Law, LawError>;

    /// A law as [`Language::law`] gives it, for small displacements: its force is the slope of the law's at rest.
    ///
    /// # Errors
    /// When the law has no such form, and as for [`Language::law`].
    fn linearised(&self, name: &str, directory: &Path, dim: usize) -> Result<Law, LawError>;

    /// An influence function with the values of its parameters in SI units, from a call such as
    /// `softened(p = 0, eps = 0.5 mm)` or an expression in `x` such as `1/x`; `constants` may stand for numbers.
    ///
    /// # Errors
    /// Everything that is wrong with the text.
    fn influence(
        &self,
        text: &str,
        constants: &[Constant],
    ) -> Result<(InfluenceFn, Vec<f64>), Vec<Complaint>>;

    /// A unit as a user writes it: `Pa`, `kg m^-3`; `1` for a number.
    fn unit_name(&self, unit: Exponents) -> String;
}
