//! What is known of waves, layers and solids, beside what the program computes: a table of studies.
//!
//! A study runs a scene of `examples/`, or a variation of one, and measures; its rows hold the figure, the reference
//! and how near it is to be. References are figures of papers, or of computations that share nothing with this program.
//! A further study is one more entry in [`STUDIES`]. `pdlang bench accuracy` shows the rows, `docs/accuracy.md` has them all.

mod case;
pub mod indentation;
pub mod leaving;
mod matching;
mod pml;

use std::fmt::{self, Display};

pub use case::Case;

/// All studies, in the order of the report.
pub const STUDIES: &[&[Study]] = &[
    pml::STUDIES,
    indentation::STUDIES,
    matching::STUDIES,
    leaving::STUDIES,
];

pub struct Study {
    /// Also that of its rows. Several studies may share one: a quick part and a long one.
    pub id: &'static str,
    /// What is run and where references are from, in a sentence or two.
    pub about: &'static str,
    /// Whether it takes longer than some seconds: then it is no part of the usual tests.
    pub long: bool,
    pub measure: fn() -> Result<Vec<Measure>, String>,
}

/// What a study finds.
pub struct Measure {
    pub quantity: String,
    pub value: f64,
    pub reference: f64,
    pub tolerance: Tolerance,
    /// Where it is one of a curve.
    pub along: Option<Along>,
}

/// A place on a curve, of which `pdlang bench accuracy --plot` draws values and references.
#[derive(Clone, Copy)]
pub struct Along {
    /// What is across and what upwards, with units.
    pub axes: [&'static str; 2],
    pub name: &'static str,
    /// Values are joined by a line, or dots.
    pub line: bool,
    pub at: f64,
}

/// How near a value is to be to its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// A part of the reference.
    Part(f64),
    /// Either way, by this much.
    Off(f64),
    /// Within this factor, either way.
    Factor(f64),
    /// No larger.
    AtMost,
    /// No smaller.
    AtLeast,
}

impl Measure {
    pub fn new(
        quantity: impl Display,
        value: f64,
        reference: f64,
        tolerance: Tolerance,
    ) -> Measure {
        Measure {
            quantity: quantity.to_string(),
            value,
            reference,
            tolerance,
            along: None,
        }
    }

    pub fn along(self, place: Along) -> Measure {
        Measure {
            along: Some(place),
            ..self
        }
    }

    /// A value that is not a number passes nothing.
    pub fn pass(&self) -> bool {
        let (value, reference) = (self.value, self.reference);
        match self.tolerance {
            Tolerance::Part(part) => (value - reference).abs() <= part * reference.abs(),
            Tolerance::Off(off) => (value - reference).abs() <= off,
            Tolerance::Factor(factor) => {
                value / reference <= factor
                    && reference / value <= factor
                    && value / reference > 0.0
            }
            Tolerance::AtMost => value <= reference,
            Tolerance::AtLeast => value >= reference,
        }
    }
}

impl Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Tolerance::Part(part) => write!(f, "{} %", figure(100.0 * part)),
            Tolerance::Off(off) => write!(f, "{}", figure(*off)),
            Tolerance::Factor(factor) => write!(f, "factor {}", figure(*factor)),
            Tolerance::AtMost => write!(f, "at most"),
            Tolerance::AtLeast => write!(f, "at least"),
        }
    }
}

/// Four digits, without superfluous zeros: what is the same on every machine.
pub fn figure(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = format!("{value:.3e}");
    let (mantissa, exponent) = digits.split_once('e').unwrap_or((&digits, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let short = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text.to_string(),
    };
    match exponent {
        -3..=4 => short(&format!("{value:.*}", (3 - exponent).max(0) as usize)),
        _ => format!("{}e{exponent}", short(mantissa)),
    }
}
