//! The language: text to kernel.
pub mod assemble;
pub mod constants;
pub mod derive;
pub mod direct;
pub mod ir;
pub mod lower;
pub mod oracle;
pub mod plan;
pub mod poly;
pub mod ratio;
pub mod rust;
pub mod schedule;
pub mod span;
pub mod spec;
pub mod sweep;
pub mod tape;
pub mod units;
