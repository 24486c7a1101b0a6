//! AVX-512 (F, DQ, VL): eight nodes in a register, one mask byte.
// SAFETY (whole file): every intrinsic needs only instructions of this set, and values of the type exist
// only below a wrapper that runs on processors which have it (see the module above).
use super::{Memory, Sealed, lane_by_lane, powi};
use crate::kernel::Lane;
use std::arch::x86_64::*;

#[derive(Clone, Copy)]
pub(crate) struct Avx512(__m512d);

impl Avx512 {
    #[inline(always)]
    fn to_array(self) -> [f64; 8] {
        let mut a = [0.0; 8];
        unsafe { _mm512_storeu_pd(a.as_mut_ptr(), self.0) };
        a
    }
    #[inline(always)]
    fn from_array(a: [f64; 8]) -> Self {
        Self(unsafe { _mm512_loadu_pd(a.as_ptr()) })
    }
}

impl Sealed for Avx512 {}

impl Lane for Avx512 {
    const W: usize = 8;
    type Mask = __mmask8;
    #[inline(always)]
    fn splat(v: f64) -> Self {
        Self(unsafe { _mm512_set1_pd(v) })
    }
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self(unsafe { _mm512_add_pd(self.0, b.0) })
    }
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self(unsafe { _mm512_sub_pd(self.0, b.0) })
    }
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        Self(unsafe { _mm512_mul_pd(self.0, b.0) })
    }
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        Self(unsafe { _mm512_div_pd(self.0, b.0) })
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        Self(unsafe { _mm512_min_pd(self.0, b.0) })
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        Self(unsafe { _mm512_max_pd(self.0, b.0) })
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm512_fmadd_pd(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { _mm512_xor_pd(self.0, _mm512_set1_pd(-0.0)) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_andnot_pd(_mm512_set1_pd(-0.0), self.0) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }
    lane_by_lane!(exp, ln, sin, cos, tan);
    #[inline(always)]
    fn pow(self, b: Self) -> Self {
        let (mut a, b) = (self.to_array(), b.to_array());
        let mut k = 0;
        while k < 8 {
            a[k] = a[k].powf(b[k]);
            k += 1;
        }
        Self::from_array(a)
    }
    #[inline(always)]
    fn powi(self, n: i32) -> Self {
        powi(self, n)
    }
    /// Estimate of 14 bits and two Newton steps: a third of the cost of root and division.
    #[inline(always)]
    fn rsqrt(self) -> Self {
        unsafe {
            let half = _mm512_set1_pd(0.5);
            let h = _mm512_mul_pd(self.0, half);
            let y = _mm512_rsqrt14_pd(self.0);
            let y = _mm512_fmadd_pd(y, _mm512_fnmadd_pd(_mm512_mul_pd(h, y), y, half), y);
            Self(_mm512_fmadd_pd(
                y,
                _mm512_fnmadd_pd(_mm512_mul_pd(h, y), y, half),
                y,
            ))
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
    #[inline(always)]
    unsafe fn load(p: *const f64) -> Self {
        Self(unsafe { _mm512_loadu_pd(p) })
    }
    #[inline(always)]
    unsafe fn store(self, p: *mut f64) {
        unsafe { _mm512_storeu_pd(p, self.0) }
    }
    #[inline(always)]
    unsafe fn gather(p: *const f64, index: *const u32) -> Self {
        Self(unsafe { _mm512_i32gather_pd::<8>(_mm256_loadu_si256(index.cast()), p) })
    }
    #[inline(always)]
    fn mask(bits: u8) -> __mmask8 {
        bits
    }
    #[inline(always)]
    fn bits(m: __mmask8) -> u8 {
        m
    }
    #[inline(always)]
    fn first(self) -> f64 {
        unsafe { _mm512_cvtsd_f64(self.0) }
    }
    #[inline(always)]
    fn prefetch(p: *const u8) {
        unsafe { _mm_prefetch::<_MM_HINT_T0>(p.cast()) }
    }
}
