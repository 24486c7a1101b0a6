//! The catalogue of laws, and the language as scenes use it.

pub mod accuracy;
pub mod bench;
pub mod constants;
pub mod files;
pub mod language;
pub mod page;
pub mod registry;
pub mod relations;
pub mod verify;
pub mod waves;
