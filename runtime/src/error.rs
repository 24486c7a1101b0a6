//! Wrong input, told once: what is wrong and what to do about it.

use crate::matching::Side;
use std::fmt;

/// Input that cannot be computed. `Display` prints both sentences.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError {
    pub what: String,
    pub remedy: String,
    /// What of a scene it is about, where that is known.
    pub about: Option<About>,
}

/// What of a scene is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    Traversal,
    Precision,
    /// The matching boundary of this side.
    Matching(Side),
    /// Positions in the lists of a [`crate::simulate::Setup`].
    Initial(usize),
    Condition(usize),
}

impl InputError {
    pub fn new(what: impl Into<String>, remedy: impl Into<String>) -> InputError {
        InputError {
            what: what.into(),
            remedy: remedy.into(),
            about: None,
        }
    }

    /// Unless it is known better already.
    pub fn about(self, what: About) -> InputError {
        InputError {
            about: self.about.or(Some(what)),
            ..self
        }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.what)?;
        if self.remedy.is_empty() {
            Ok(())
        } else {
            write!(f, "; {}", self.remedy)
        }
    }
}

impl std::error::Error for InputError {}
