//! The language: text to kernel.
pub mod ir;
pub mod span;
pub mod units;
