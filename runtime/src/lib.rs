//! Bodies, families, traversals, time: everything but the law.
pub mod body;
pub mod carve;
pub mod conditions;
pub mod contact;
#[path = "mock.rs"]
pub mod engine;
pub mod error;
pub mod kernel;
pub mod observe;
pub mod points;
pub mod shape;
pub mod simulate;
pub mod spec;
pub mod spectrum;
