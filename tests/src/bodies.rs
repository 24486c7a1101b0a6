//! The small bodies that `pdlang verify` uses too.

pub use pdlang_models::verify::bodies::*;
