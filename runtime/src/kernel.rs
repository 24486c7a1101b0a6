//! The interface file: all that generated code may name.
//!
//! A law reaches the runtime as a [`crate::spec::Spec`] (data: slots, constants, sweeps as tapes) and,
//! when it was compiled, as a [`CompiledLaw`] whose sweeps carry the same straight-line bodies as machine
//! code. Both run in the same traversals: an uncompiled sweep walks its tapes in place of a [`Sweep`].
//!
//! The generated code says what happens on a node or on a bond, generic over the lane type; the runtime
//! owns every loop, mask, load and store. Rules for everything on the hot path: `#[inline(always)]`, no
//! closures, `target_feature` only on the outermost wrapper (see `sweep_entries!`).

/// A register of `W` nodes' values. `f64` itself is the scalar lane.
///
/// `rsqrt` need not be correctly rounded, but it is a pure function of its argument, the same for every
/// lane of one type: an undeformed bond then has exactly no stretch.
///
/// Sealed: the vector types stay inside the runtime, because their safe operators are only sound below a
/// wrapper that has checked for the instruction set.
pub trait Lane: crate::lane::Sealed + Copy + Send + Sync + 'static {
    const W: usize;
    /// One truth value per lane.
    type Mask: Copy;
    fn splat(v: f64) -> Self;
    fn add(self, b: Self) -> Self;
    fn sub(self, b: Self) -> Self;
    fn mul(self, b: Self) -> Self;
    fn div(self, b: Self) -> Self;
    /// `self * b + c`, fused where the instruction set has it.
    fn fma(self, b: Self, c: Self) -> Self;
    fn neg(self) -> Self;
    fn abs(self) -> Self;
    fn min(self, b: Self) -> Self;
    fn max(self, b: Self) -> Self;
    fn sqrt(self) -> Self;
    /// Reciprocal square root, good to a few units in the last place.
    fn rsqrt(self) -> Self;
    fn exp(self) -> Self;
    fn ln(self) -> Self;
    fn sin(self) -> Self;
    fn cos(self) -> Self;
    fn tan(self) -> Self;
    fn pow(self, b: Self) -> Self;
    /// Integer power by repeated multiplication; negative powers divide once.
    fn powi(self, n: i32) -> Self;
    fn lt(self, b: Self) -> Self::Mask;
    fn le(self, b: Self) -> Self::Mask;
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn not(a: Self::Mask) -> Self::Mask;
    fn select(m: Self::Mask, a: Self, b: Self) -> Self;
}

/// What a node prologue or epilogue may read and write: the node slots of the sweep, by position in its
/// `own` and `out` lists, and the constants of the law.
pub trait Node<L: Lane> {
    fn constant(&self, k: usize) -> L;
    fn own(&self, k: usize) -> L;
    fn out(&mut self, k: usize, v: L);
}

/// What a bond body may read and do. Loads happen when asked for, so what is not used costs nothing.
pub trait Bond<L: Lane, const D: usize> {
    /// Component of the reference bond vector [m].
    fn xi(&self, a: usize) -> L;
    /// Component of the relative displacement u_j - u_i [m].
    fn eta(&self, a: usize) -> L;
    /// 1/|xi| as the lane's own `rsqrt` of [`norm_squared`] gives it [1/m].
    fn ix(&self) -> L;
    /// Reference-bond value of this sweep: from a table of its geometry tape, or as [`Sweep::geo`] forms it.
    fn geo(&self, k: usize) -> L;
    /// Node slot of the other end, by position in the sweep's `nbr` list.
    fn nbr(&self, k: usize) -> L;
    /// Committed history of this directed bond, by position in the sweep's `history` list.
    fn history(&self, k: usize) -> L;
    /// The same history of the reverse bond j -> i.
    fn reverse(&self, k: usize) -> L;
    /// Writes the next value of a history (update sweeps only); current reads do not see it.
    fn put_history(&mut self, k: usize, v: L);
    /// Breaks this bond where `m` holds, if the scene lets bonds break here; contributions added
    /// afterwards do not see it any more.
    fn kill(&mut self, m: L::Mask);
    /// `acc += a * b` where the bond counts.
    fn add(&self, acc: &mut L, a: L, b: L);
    /// `acc = max(acc, a)` where the bond counts.
    fn max(&self, acc: &mut L, a: L);
}

/// What a cloud keeps of a bond.
pub trait Streams<L: Lane> {
    /// By position among the streams of the sweep.
    fn stream(&self, k: usize) -> L;
}

/// One sweep: for every node, a prologue, a sum over its bonds, an epilogue.
pub trait Sweep<const D: usize>: Sync {
    type Pre<L: Lane>: Copy;
    type Acc<L: Lane>: Copy;
    /// How many streams it has in a cloud.
    const STREAMS: usize;
    /// How many of the slots at the head of its `nbr` list are formed by other sweeps; a cloud reads them from records.
    const FORMED: usize = 0;
    fn zero<L: Lane>(&self) -> Self::Acc<L>;
    fn pre<L: Lane, N: Node<L>>(&self, node: &N) -> Self::Pre<L>;
    fn bond<L: Lane, B: Bond<L, D>>(
        &self,
        pre: &Self::Pre<L>,
        bond: &mut B,
        acc: &mut Self::Acc<L>,
    );
    fn post<L: Lane, N: Node<L>>(&self, pre: &Self::Pre<L>, acc: &Self::Acc<L>, node: &mut N);
    /// Reference-bond value `k`, from what a cloud keeps of the bond.
    fn geo<L: Lane, B: Bond<L, D> + Streams<L>>(&self, bond: &B, k: usize) -> L;
}

/// |v|^2 in the one order that every path uses.
#[inline(always)]
pub fn norm_squared<L: Lane, const D: usize>(v: [L; D]) -> L {
    let mut s = v[0].mul(v[0]);
    let mut a = 1;
    while a < D {
        s = v[a].fma(v[a], s);
        a += 1;
    }
    s
}

/// A law compiled into the program: at most one kernel per dimension.
pub struct CompiledLaw {
    pub name: &'static str,
    pub kernels: &'static [CompiledKernel],
}

/// A law at one dimension, with machine code for some of its sweeps; the others are interpreted.
pub struct CompiledKernel {
    pub dim: usize,
    /// The [`crate::spec::Spec`] as JSON.
    pub spec: &'static str,
    /// Position in `Spec::sweeps`, and the instances made by [`crate::sweep_entries!`].
    pub sweeps: &'static [(usize, Entries)],
}

/// One instance of a sweep: the chunks `from..to` of a call.
///
/// # Safety
/// The processor has the instruction set of the instance, and the call was made for this traversal.
pub type Run = unsafe fn(&crate::traverse::Call, usize, usize);

/// The instances of one sweep for one instruction set; `[0]` for chunks whose families are whole, `[1]` for any chunk.
#[derive(Clone, Copy)]
pub struct Instances {
    pub lattice: [Run; 2],
    pub cloud: [Run; 2],
}

/// Those of a lattice in single precision: AVX2, and AVX-512 with two chunks at a time; `[0]` and `[1]` as in [`Instances`].
#[derive(Clone, Copy)]
pub struct Singles {
    pub avx2: [Run; 2],
    pub wide: [Run; 2],
}

/// Every instance of one sweep.
#[derive(Clone, Copy)]
pub struct Entries {
    pub single: Option<Singles>,
    pub scalar: Instances,
    #[cfg(target_arch = "x86_64")]
    pub avx2: Instances,
    #[cfg(target_arch = "x86_64")]
    pub avx512: Instances,
}

/// The [`Entries`] of a unit struct that implements `Sweep<D>`: `sweep_entries!(Force, 3)`. With `rare` in front,
/// for a sweep that does not run at every step: whole families then take the instance for any. With `single`, for one that
/// may run in single precision.
///
/// Every instance is a function of its own, not generic, so that they compile in parallel; each enables
/// the instruction set for everything that is inlined into it.
#[macro_export]
macro_rules! sweep_entries {
    (rare $sweep:path, $dim:literal) => {{
        $crate::sweep_entries!(@scalar ls lattice_scalar true, $sweep, $dim);
        $crate::sweep_entries!(@scalar cs cloud_scalar true, $sweep, $dim);
        $crate::sweep_entries!(@avx2 l2 lattice_avx2 true, $sweep, $dim);
        $crate::sweep_entries!(@avx2 c2 cloud_avx2 true, $sweep, $dim);
        $crate::sweep_entries!(@avx512 l5 lattice_avx512 true, $sweep, $dim);
        $crate::sweep_entries!(@avx512 c5 cloud_avx512 true, $sweep, $dim);
        $crate::sweep_entries!(@entries None, [ls, ls] [cs, cs] [l2, l2] [c2, c2] [l5, l5] [c5, c5])
    }};
    (single $sweep:path, $dim:literal) => {{
        $crate::sweep_entries!(@avx2 single_whole lattice_single false, $sweep, $dim);
        $crate::sweep_entries!(@avx2 single_any lattice_single true, $sweep, $dim);
        $crate::sweep_entries!(@avx512 wide_whole lattice_wide false, $sweep, $dim);
        $crate::sweep_entries!(@avx512 wide_any lattice_wide true, $sweep, $dim);
        #[cfg(target_arch = "x86_64")]
        const SINGLE: Option<$crate::kernel::Singles> = Some($crate::kernel::Singles {
            avx2: [single_whole, single_any],
            wide: [wide_whole, wide_any],
        });
        #[cfg(not(target_arch = "x86_64"))]
        const SINGLE: Option<$crate::kernel::Singles> = None;
        $crate::sweep_entries!(@every SINGLE, $sweep, $dim)
    }};
    ($sweep:path, $dim:literal) => {
        $crate::sweep_entries!(@every None, $sweep, $dim)
    };
    (@every $single:expr, $sweep:path, $dim:literal) => {{
        $crate::sweep_entries!(@scalar ls_whole lattice_scalar false, $sweep, $dim);
        $crate::sweep_entries!(@scalar ls_any lattice_scalar true, $sweep, $dim);
        $crate::sweep_entries!(@scalar cs_whole cloud_scalar false, $sweep, $dim);
        $crate::sweep_entries!(@scalar cs_any cloud_scalar true, $sweep, $dim);
        $crate::sweep_entries!(@avx2 l2_whole lattice_avx2 false, $sweep, $dim);
        $crate::sweep_entries!(@avx2 l2_any lattice_avx2 true, $sweep, $dim);
        $crate::sweep_entries!(@avx2 c2_whole cloud_avx2 false, $sweep, $dim);
        $crate::sweep_entries!(@avx2 c2_any cloud_avx2 true, $sweep, $dim);
        $crate::sweep_entries!(@avx512 l5_whole lattice_avx512 false, $sweep, $dim);
        $crate::sweep_entries!(@avx512 l5_any lattice_avx512 true, $sweep, $dim);
        $crate::sweep_entries!(@avx512 c5_whole cloud_avx512 false, $sweep, $dim);
        $crate::sweep_entries!(@avx512 c5_any cloud_avx512 true, $sweep, $dim);
        $crate::sweep_entries!(@entries $single,
            [ls_whole, ls_any] [cs_whole, cs_any] [l2_whole, l2_any] [c2_whole, c2_any] [l5_whole, l5_any] [c5_whole, c5_any])
    }};
    (@entries $single:expr, $ls:tt $cs:tt $l2:tt $c2:tt $l5:tt $c5:tt) => {
        $crate::kernel::Entries {
            single: $single,
            scalar: $crate::kernel::Instances { lattice: $ls, cloud: $cs },
            #[cfg(target_arch = "x86_64")]
            avx2: $crate::kernel::Instances { lattice: $l2, cloud: $c2 },
            #[cfg(target_arch = "x86_64")]
            avx512: $crate::kernel::Instances { lattice: $l5, cloud: $c5 },
        }
    };
    (@scalar $($instance:tt)*) => {
        $crate::sweep_entries!(@function [] $($instance)*);
    };
    (@avx2 $($instance:tt)*) => {
        $crate::sweep_entries!(@function [#[cfg(target_arch = "x86_64")] #[target_feature(enable = "avx2,fma")]] $($instance)*);
    };
    (@avx512 $($instance:tt)*) => {
        $crate::sweep_entries!(@function
            [#[cfg(target_arch = "x86_64")] #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]] $($instance)*);
    };
    (@function [$($attribute:tt)*] $name:ident $run:ident $masked:literal, $sweep:path, $dim:literal) => {
        $($attribute)*
        unsafe fn $name(call: &$crate::traverse::Call, from: usize, to: usize) {
            unsafe { $crate::traverse::$run::<$sweep, $dim, $masked>(&$sweep, call, from, to) }
        }
    };
}
