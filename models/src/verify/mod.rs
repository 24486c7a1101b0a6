//! Verification of a law's physics, before any simulation.
//!
//! Input: a checked law, its text and the values that it is verified at. Output: verdicts, in the order of
//! [`pdlang::known::CHECKS`], each about one check, one flavour and one quantity, with what was measured, what was expected
//! and a sentence that names the definition of the law it is about. A check that a law says is `known` to fail is a warning.
//!
//! Nothing needs to be compiled: bodies are small and run in the engine from tapes, and constants of the continuum are
//! asked of the oracle, at one node with a quadrature for its family. One file per group of checks.

pub mod ask;
mod balance;
pub mod bodies;
pub mod constants;
pub mod continuum;
mod derivatives;
mod fracture;
mod limits;
mod modes;
pub mod place;
mod purity;
mod rates;
mod release;
mod repair;
mod statics;
pub mod subject;

use pdlang::ir::{Flavour, Law};

pub use place::Place;
pub use subject::{Options, Subject};

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    Pass,
    /// Not asked: what it is about does not exist in the law.
    Skip,
    Warn,
    Fail,
}

impl Level {
    pub fn word(self) -> &'static str {
        match self {
            Level::Pass => "pass",
            Level::Skip => "skip",
            Level::Warn => "warn",
            Level::Fail => "fail",
        }
    }
}

/// What a check found.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// A name of [`pdlang::known::CHECKS`].
    pub check: &'static str,
    /// `None`: whatever the flavour.
    pub flavour: Option<Flavour>,
    /// What was measured, where a check measures several things: `G`.
    pub quantity: String,
    pub level: Level,
    /// SI, or an error relative to its scale.
    pub measured: Option<f64>,
    /// SI; of an error, the largest that is allowed.
    pub expected: Option<f64>,
    pub sentence: String,
    pub place: Option<Place>,
}

impl Verdict {
    pub(crate) fn new(check: &'static str, flavour: Flavour, level: Level) -> Verdict {
        Verdict {
            check,
            flavour: Some(flavour),
            quantity: String::new(),
            level,
            measured: None,
            expected: None,
            sentence: String::new(),
            place: None,
        }
    }

    pub(crate) fn skip(check: &'static str, flavour: Flavour, why: &str) -> Verdict {
        Verdict::new(check, flavour, Level::Skip).says(why)
    }

    /// An error that should be no larger than `allowed`.
    pub(crate) fn error(
        check: &'static str,
        flavour: Flavour,
        error: f64,
        allowed: f64,
    ) -> Verdict {
        let level = if error <= allowed {
            Level::Pass
        } else {
            Level::Fail
        };
        Verdict {
            measured: Some(error),
            expected: Some(allowed),
            ..Verdict::new(check, flavour, level)
        }
    }

    pub(crate) fn says(mut self, sentence: impl Into<String>) -> Verdict {
        self.sentence = sentence.into();
        self
    }

    /// The sentence of a verdict that is no pass.
    pub(crate) fn blames(
        mut self,
        place: Option<Place>,
        sentence: impl FnOnce(&str) -> String,
    ) -> Verdict {
        if self.level > Level::Skip {
            let name = place.as_ref().map_or("the law".into(), Place::to_string);
            self.sentence = sentence(&name);
            self.place = place;
        }
        self
    }

    pub(crate) fn of(mut self, quantity: impl Into<String>) -> Verdict {
        self.quantity = quantity.into();
        self
    }
}

/// One flavour of a subject, asked by one group of checks.
type Group = fn(&Subject, Flavour) -> Result<Vec<Verdict>, String>;

/// The groups, and the check that says so where one cannot be asked at all.
const GROUPS: [(&str, Group); 10] = [
    ("linear_momentum", balance::check),
    ("gradient", derivatives::check),
    ("purity", purity::check),
    ("constants", constants::check),
    ("fracture_energy", fracture::check),
    ("release", release::check),
    ("zero_energy", modes::check),
    ("limits", limits::check),
    ("conservation", rates::check),
    ("coupling", rates::coupling),
];

/// All verdicts on a law.
///
/// # Errors
/// When the values that were chosen do not fit the law.
pub fn verify(law: &Law, text: &str, options: &Options) -> Result<Vec<Verdict>, String> {
    let subject = Subject::new(law, text, options)?;
    let mut verdicts = statics::check(&subject);
    for &flavour in &law.flavours {
        for (check, group) in GROUPS {
            verdicts.extend(group(&subject, flavour).unwrap_or_else(|error| {
                let failed = Verdict::new(check, flavour, Level::Fail);
                vec![failed.blames(subject.force_place(), |_| {
                    format!("cannot be asked: {error}")
                })]
            }));
        }
    }
    for verdict in &mut verdicts {
        admit(law, verdict);
    }
    let order = |check: &str| {
        pdlang::known::CHECKS
            .iter()
            .position(|(name, _)| *name == check)
    };
    verdicts.sort_by_key(|v| order(v.check));
    Ok(verdicts)
}

/// What is known is a warning with its reason.
fn admit(law: &Law, verdict: &mut Verdict) {
    let known = law.knowns.iter().find(|known| known.check == verdict.check);
    if let Some(known) = known
        && verdict.level >= Level::Warn
    {
        verdict.level = Level::Warn;
        verdict.sentence = format!("known: {}", known.reason);
    }
}
