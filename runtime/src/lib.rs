//! Bodies, families, traversals, time: everything but the law.
pub mod body;
pub mod kernel;
pub mod language;
pub mod scene;
pub mod spec;
