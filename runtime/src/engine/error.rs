//! Why an engine cannot be made.
use std::fmt;

/// Says what is wrong and what to do.
#[derive(Clone, Debug, PartialEq)]
pub enum SetupError {
    /// The law's data is inconsistent, or does not fit the body.
    Law {
        law: String,
        message: String,
    },
    Body(String),
    Settings(String),
    /// The body or the law does not go with the traversal: what is wrong, and what to do.
    Traversal(String, String),
    /// Single precision is asked for and cannot be: what is wrong, and what to do.
    Precision(String, String),
    /// [bytes]
    Memory {
        needed: u64,
        available: u64,
    },
}

impl SetupError {
    pub(crate) fn law(law: &str, message: impl fmt::Display) -> SetupError {
        SetupError::Law {
            law: law.to_string(),
            message: message.to_string(),
        }
    }
}

impl fmt::Display for SetupError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let gb = |b: u64| b as f64 / 1e9;
        match self {
            SetupError::Law { law, message } => write!(f, "law `{law}`: {message}"),
            SetupError::Body(message) | SetupError::Settings(message) => f.write_str(message),
            SetupError::Traversal(message, remedy) | SetupError::Precision(message, remedy) => {
                write!(f, "{message}: {remedy}")
            }
            SetupError::Memory { needed, available } => write!(
                f,
                "the body needs about {:.1} GB, {:.1} GB are free: use a larger spacing, a smaller horizon, or a regular grid",
                gb(*needed),
                gb(*available)
            ),
        }
    }
}

impl std::error::Error for SetupError {}
