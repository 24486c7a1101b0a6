//! Hand-written twins of generated kernels: the best plain code for the same sums in the same order, to
//! measure the generated ones against and to compare with bit by bit.
//!
//! The laws here are written three times by hand: as tapes (as the compiler writes them), as bodies of
//! [`Sweep`](pdlang_runtime::kernel::Sweep) (as the generator emits them), and as loops over intrinsics.
pub mod bodies;
#[cfg(target_arch = "x86_64")]
pub mod cloud;
#[cfg(target_arch = "x86_64")]
pub mod lattice;
pub mod scene;
pub mod tapes;
