//! The catalogue of laws, and the language as scenes use it.

pub mod accuracy;
pub mod bench;
pub mod constants;
pub mod files;
pub mod language;
pub mod registry;
pub mod verify;
pub mod waves;
