//! AVX2 and FMA: four nodes in a register.
// SAFETY (whole file): every intrinsic needs only instructions of this set, and values of the type exist
// only below a wrapper that runs on processors which have it (see the module above).
use super::vector::{arithmetic, vector};
use super::{Memory, Record, Records, Sealed, powi};
use crate::kernel::Lane;
use std::arch::x86_64::*;

vector! {
    Avx2(__m256d), [f64; 4], _mm256_loadu_pd, _mm256_storeu_pd
}

/// Truth in the sign bit of each lane; the other bits mean nothing.
#[derive(Clone, Copy)]
pub(crate) struct Signs(__m256d);

impl Lane for Avx2 {
    const W: usize = 4;
    type Mask = Signs;
    arithmetic! {
        add: _mm256_add_pd, sub: _mm256_sub_pd, mul: _mm256_mul_pd, div: _mm256_div_pd, min: _mm256_min_pd, max: _mm256_max_pd;
        fma: _mm256_fmadd_pd, sqrt: _mm256_sqrt_pd, xor: _mm256_xor_pd, andnot: _mm256_andnot_pd,
        splat: _mm256_set1_pd of f64
    }
    /// Root and division: with this instruction set the estimate is no faster.
    #[inline(always)]
    fn rsqrt(self) -> Self {
        Self(unsafe { _mm256_div_pd(_mm256_set1_pd(1.0), _mm256_sqrt_pd(self.0)) })
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Signs {
        Signs(unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, b.0) })
    }
    #[inline(always)]
    fn le(self, b: Self) -> Signs {
        Signs(unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, b.0) })
    }
    #[inline(always)]
    fn and(a: Signs, b: Signs) -> Signs {
        Signs(unsafe { _mm256_and_pd(a.0, b.0) })
    }
    #[inline(always)]
    fn or(a: Signs, b: Signs) -> Signs {
        Signs(unsafe { _mm256_or_pd(a.0, b.0) })
    }
    #[inline(always)]
    fn not(a: Signs) -> Signs {
        Signs(unsafe { _mm256_xor_pd(a.0, _mm256_set1_pd(-0.0)) })
    }
    #[inline(always)]
    fn select(m: Signs, a: Self, b: Self) -> Self {
        Self(unsafe { _mm256_blendv_pd(b.0, a.0, m.0) })
    }
}

impl Memory for Avx2 {
    type Near = f64;
    #[inline(always)]
    unsafe fn near(p: *const f64) -> Self {
        unsafe { Self::load(p) }
    }
    #[inline(always)]
    fn spread(v: f64) -> Self {
        Self::splat(v)
    }
    #[inline(always)]
    unsafe fn load(p: *const f64) -> Self {
        Self(unsafe { _mm256_loadu_pd(p) })
    }
    #[inline(always)]
    unsafe fn store(self, p: *mut f64) {
        unsafe { _mm256_storeu_pd(p, self.0) }
    }
    #[inline(always)]
    unsafe fn store_where(self, m: Signs, p: *mut f64) {
        unsafe { _mm256_maskstore_pd(p, _mm256_castpd_si256(m.0), self.0) }
    }
    #[inline(always)]
    unsafe fn gather(p: *const f64, index: *const u32) -> Self {
        unsafe {
            let low = pair(p, index, 0);
            Self(_mm256_insertf128_pd::<1>(
                _mm256_castpd128_pd256(low),
                pair(p, index, 2),
            ))
        }
    }
    /// Shifts bit k into the sign of lane k.
    #[inline(always)]
    fn mask(bits: u16) -> Signs {
        unsafe {
            let all = _mm256_set1_epi64x(bits as i64);
            Signs(_mm256_castsi256_pd(_mm256_sllv_epi64(
                all,
                _mm256_setr_epi64x(63, 62, 61, 60),
            )))
        }
    }
    #[inline(always)]
    fn bits(m: Signs) -> u16 {
        unsafe { _mm256_movemask_pd(m.0) as u16 }
    }
    #[inline(always)]
    fn first(self) -> f64 {
        unsafe { _mm256_cvtsd_f64(self.0) }
    }
}

impl Records for Avx2 {
    #[inline(always)]
    unsafe fn gather_records(p: *const Record, index: *const u32) -> [Self; 4] {
        unsafe {
            let (a, b) = (record(p, index, 0), record(p, index, 1));
            let (c, d) = (record(p, index, 2), record(p, index, 3));
            let (even, odd) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
            let (even2, odd2) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
            [
                Self(_mm256_permute2f128_pd::<0x20>(even, even2)),
                Self(_mm256_permute2f128_pd::<0x20>(odd, odd2)),
                Self(_mm256_permute2f128_pd::<0x31>(even, even2)),
                Self(_mm256_permute2f128_pd::<0x31>(odd, odd2)),
            ]
        }
    }
}

/// Values at two places.
#[inline(always)]
pub(super) unsafe fn pair(p: *const f64, index: *const u32, k: usize) -> __m128d {
    unsafe {
        let low = _mm_load_sd(p.add(*index.add(k) as usize));
        _mm_loadh_pd(low, p.add(*index.add(k + 1) as usize))
    }
}

#[inline(always)]
pub(super) unsafe fn record(p: *const Record, index: *const u32, k: usize) -> __m256d {
    unsafe { _mm256_load_pd(p.add(*index.add(k) as usize).cast()) }
}
