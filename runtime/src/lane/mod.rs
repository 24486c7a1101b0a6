//! Lane types: `f64` itself, and the vectors of AVX2 and AVX-512.
//!
//! Operators of the vector types are safe functions over instructions that the processor may lack. They
//! are sound because the types are private to the runtime: only the traversals name them, below wrappers
//! that are reached after [`Isa::available`] said yes.
mod scalar;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod single;
#[cfg(target_arch = "x86_64")]
mod vector;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) use avx512::Avx512;
#[cfg(target_arch = "x86_64")]
pub(crate) use single::{Single, Wide};

use crate::kernel::Lane;

/// Closes [`Lane`] to types of this module.
pub trait Sealed {}

/// What only the traversals do with a lane: memory and mask bits.
///
/// # Safety
/// Pointers must be valid for `W` values (indices: `W` indices, each valid for the array).
pub(crate) trait Memory: Lane {
    /// A number as the bonds of a lattice read it.
    type Near: Copy;
    unsafe fn near(p: *const Self::Near) -> Self;
    fn spread(v: Self::Near) -> Self;
    unsafe fn load(p: *const f64) -> Self;
    unsafe fn store(self, p: *mut f64);
    /// Writes the lanes for which `m` holds, and touches no other.
    unsafe fn store_where(self, m: Self::Mask, p: *mut f64);
    /// Values at `W` places, by scalar loads: since the mitigation of data sampling, the gather instructions of
    /// most processors take two to three times as long (measured: 10.9 ns against 3.7 ns for eight values).
    #[inline(always)]
    unsafe fn gather(p: *const f64, index: *const u32) -> Self {
        let mut a = [0.0; WIDEST];
        let mut k = 0;
        while k < Self::W {
            a[k] = unsafe { *p.add(*index.add(k) as usize) };
            k += 1;
        }
        unsafe { Self::load(a.as_ptr()) }
    }
    /// Lane k is true where bit k is set; higher bits are ignored.
    fn mask(bits: u16) -> Self::Mask;
    fn bits(m: Self::Mask) -> u16;
    fn first(self) -> f64;
    /// Fetches what is read once: what is read again and again stays in the cache.
    #[inline(always)]
    fn prefetch(p: *const u8) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a prefetch never faults, and SSE is part of the x86-64 baseline.
        unsafe {
            use std::arch::x86_64::{_MM_HINT_NTA, _mm_prefetch};
            _mm_prefetch::<_MM_HINT_NTA>(p.cast())
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = p;
    }
}

/// What a cloud does with a lane besides.
///
/// # Safety
/// As of [`Memory`].
pub(crate) trait Records: Memory {
    /// The four components of `W` records: vector loads and a transposition, a third of the work of gathers.
    unsafe fn gather_records(p: *const Record, index: *const u32) -> [Self; 4];
}

/// Most values in a register.
const WIDEST: usize = 16;

/// Up to three components of one node side by side, in one half of a cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Record(pub [f64; 4]);

/// An instruction set with its own instances of every sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Isa {
    Scalar,
    Avx2,
    Avx512,
}

impl Isa {
    pub const ALL: [Isa; 3] = [Isa::Scalar, Isa::Avx2, Isa::Avx512];

    pub fn name(self) -> &'static str {
        match self {
            Isa::Scalar => "scalar",
            Isa::Avx2 => "avx2",
            Isa::Avx512 => "avx512",
        }
    }

    /// True where this processor can run it.
    #[cfg(target_arch = "x86_64")]
    pub fn available(self) -> bool {
        use std::arch::is_x86_feature_detected as has;
        let avx2 = has!("avx2") && has!("fma");
        match self {
            Isa::Scalar => true,
            Isa::Avx2 => avx2,
            Isa::Avx512 => avx2 && has!("avx512f") && has!("avx512dq") && has!("avx512vl"),
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    pub fn available(self) -> bool {
        self == Isa::Scalar
    }

    /// The widest one that this processor can run.
    pub fn best() -> Isa {
        let mut best = Isa::Scalar;
        for isa in Isa::ALL {
            if isa.available() {
                best = isa;
            }
        }
        best
    }
}

/// Integer power by repeated squaring, in the one order that every path uses.
#[inline(always)]
fn powi<L: Lane>(base: L, n: i32) -> L {
    let mut k = n.unsigned_abs();
    let mut square = base;
    let mut result = L::splat(1.0);
    let mut started = false;
    while k > 0 {
        if k & 1 == 1 {
            result = if started { result.mul(square) } else { square };
            started = true;
        }
        k >>= 1;
        if k > 0 {
            square = square.mul(square);
        }
    }
    if n < 0 {
        L::splat(1.0).div(result)
    } else {
        result
    }
}

#[cfg(test)]
mod tests;
