//! What kernels are measured against: a scene, sums over it written by hand as well as they can be, and a clock.
//!
//! `pdlang bench kernels` shows generated kernels beside their twins; `tests/benches/kernels.rs` compares them further.
pub mod clock;
#[cfg(target_arch = "x86_64")]
pub mod cloud;
#[cfg(target_arch = "x86_64")]
mod elastic;
#[cfg(target_arch = "x86_64")]
pub mod lattice;
pub mod scene;
pub mod twin;
