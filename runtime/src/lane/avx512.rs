//! AVX-512 (F, DQ, VL): eight nodes in a register, one mask byte.
// SAFETY (whole file): every intrinsic needs only instructions of this set, and values of the type exist
// only below a wrapper that runs on processors which have it (see the module above).
use super::avx2::{pair, record};
use super::vector::{arithmetic, vector};
use super::{Memory, Record, Records, Sealed, powi};
use crate::kernel::Lane;
use std::arch::x86_64::*;

vector! {
    Avx512(__m512d), [f64; 8], _mm512_loadu_pd, _mm512_storeu_pd
}

impl Lane for Avx512 {
    const W: usize = 8;
    type Mask = __mmask8;
    arithmetic! {
        add: _mm512_add_pd, sub: _mm512_sub_pd, mul: _mm512_mul_pd, div: _mm512_div_pd, min: _mm512_min_pd, max: _mm512_max_pd;
        fma: _mm512_fmadd_pd, sqrt: _mm512_sqrt_pd, xor: _mm512_xor_pd, andnot: _mm512_andnot_pd,
        splat: _mm512_set1_pd of f64
    }
    /// Estimate of 14 bits and one step of fourth order: y (1 + e/2 + 3 e^2/8 + 5 e^3/16) with e = 1 - x y^2,
    /// |e| < 2^-13, leaves 2^-54. One operation less than two Newton steps, and a shorter chain.
    #[inline(always)]
    fn rsqrt(self) -> Self {
        unsafe {
            let y = _mm512_rsqrt14_pd(self.0);
            let e = _mm512_fnmadd_pd(_mm512_mul_pd(self.0, y), y, _mm512_set1_pd(1.0));
            let p = _mm512_fmadd_pd(e, _mm512_set1_pd(0.3125), _mm512_set1_pd(0.375));
            let p = _mm512_fmadd_pd(e, p, _mm512_set1_pd(0.5));
            Self(_mm512_fmadd_pd(_mm512_mul_pd(y, e), p, y))
        }
    }
    #[inline(always)]
    fn lt(self, b: Self) -> __mmask8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, b.0) }
    }
    #[inline(always)]
    fn le(self, b: Self) -> __mmask8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, b.0) }
    }
    #[inline(always)]
    fn and(a: __mmask8, b: __mmask8) -> __mmask8 {
        a & b
    }
    #[inline(always)]
    fn or(a: __mmask8, b: __mmask8) -> __mmask8 {
        a | b
    }
    #[inline(always)]
    fn not(a: __mmask8) -> __mmask8 {
        !a
    }
    #[inline(always)]
    fn select(m: __mmask8, a: Self, b: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_pd(m, b.0, a.0) })
    }
}

impl Memory for Avx512 {
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
        Self(unsafe { _mm512_loadu_pd(p) })
    }
    #[inline(always)]
    unsafe fn store(self, p: *mut f64) {
        unsafe { _mm512_storeu_pd(p, self.0) }
    }
    #[inline(always)]
    unsafe fn store_where(self, m: __mmask8, p: *mut f64) {
        unsafe { _mm512_mask_storeu_pd(p, m, self.0) }
    }
    #[inline(always)]
    unsafe fn gather(p: *const f64, index: *const u32) -> Self {
        unsafe {
            let a = _mm256_insertf128_pd::<1>(
                _mm256_castpd128_pd256(pair(p, index, 0)),
                pair(p, index, 2),
            );
            let b = _mm256_insertf128_pd::<1>(
                _mm256_castpd128_pd256(pair(p, index, 4)),
                pair(p, index, 6),
            );
            Self(_mm512_insertf64x4::<1>(_mm512_castpd256_pd512(a), b))
        }
    }
    #[inline(always)]
    fn mask(bits: u16) -> __mmask8 {
        bits as u8
    }
    #[inline(always)]
    fn bits(m: __mmask8) -> u16 {
        m.into()
    }
    #[inline(always)]
    fn first(self) -> f64 {
        unsafe { _mm512_cvtsd_f64(self.0) }
    }
}

impl Records for Avx512 {
    #[inline(always)]
    unsafe fn gather_records(p: *const Record, index: *const u32) -> [Self; 4] {
        unsafe {
            let (a, b) = (records(p, index, 0), records(p, index, 1));
            let (c, d) = (records(p, index, 2), records(p, index, 3));
            let (even, odd) = (_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
            let (even2, odd2) = (_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
            let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
            let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
            [
                Self(_mm512_permutex2var_pd(even, low, even2)),
                Self(_mm512_permutex2var_pd(odd, low, odd2)),
                Self(_mm512_permutex2var_pd(even, high, even2)),
                Self(_mm512_permutex2var_pd(odd, high, odd2)),
            ]
        }
    }
}

/// Records k and k + 4 side by side.
#[inline(always)]
unsafe fn records(p: *const Record, index: *const u32, k: usize) -> __m512d {
    unsafe {
        _mm512_insertf64x4::<1>(
            _mm512_castpd256_pd512(record(p, index, k)),
            record(p, index, k + 4),
        )
    }
}
