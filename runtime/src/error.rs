//! Wrong input, told once: what is wrong and what to do about it.

use std::fmt;

/// Input that cannot be computed. `Display` prints both sentences.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError {
    pub what: String,
    pub remedy: String,
    /// The key of a scene that it is about, where that is known.
    pub key: Option<&'static str>,
}

impl InputError {
    pub fn new(what: impl Into<String>, remedy: impl Into<String>) -> InputError {
        InputError {
            what: what.into(),
            remedy: remedy.into(),
            key: None,
        }
    }

    pub fn about(self, key: &'static str) -> InputError {
        InputError {
            key: Some(key),
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
