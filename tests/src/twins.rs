//! Hand-written twins of generated kernels: the same sums in the same order, to compare with bit by bit.
//!
//! The laws are written three times by hand: as tapes (as the compiler writes them), as bodies of
//! [`Sweep`](pdlang_runtime::kernel::Sweep) (as the generator emits them), and as loops over intrinsics, which live in
//! [`pdlang_models::bench`] because `pdlang bench kernels` measures against them.
pub mod bodies;
pub mod tapes;
