//! Single precision, for the bonds of a lattice: eight nodes in a register of AVX2, sixteen in one of AVX-512.
//!
//! Numbers of nodes and constants are those of double precision, rounded where they are read.
// SAFETY (whole file): as in `avx2`.
use super::vector::{arithmetic, vector};
use super::{Memory, Sealed, powi};
use crate::kernel::Lane;
use std::arch::x86_64::*;

vector! {
    Single(__m256), [f32; 8], _mm256_loadu_ps, _mm256_storeu_ps
}

/// Truth in the sign bit of each lane; the other bits mean nothing.
#[derive(Clone, Copy)]
pub(crate) struct Signs(__m256);

impl Single {
    #[inline(always)]
    fn halves(low: __m128, high: __m128) -> Self {
        Self(unsafe { _mm256_set_m128(high, low) })
    }
    /// Lanes 0 to 3, and 4 to 7.
    #[inline(always)]
    fn doubles(self) -> [__m256d; 2] {
        unsafe {
            [
                _mm256_cvtps_pd(_mm256_castps256_ps128(self.0)),
                _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(self.0)),
            ]
        }
    }
}

impl Lane for Single {
    const W: usize = 8;
    type Mask = Signs;
    arithmetic! {
        add: _mm256_add_ps, sub: _mm256_sub_ps, mul: _mm256_mul_ps, div: _mm256_div_ps, min: _mm256_min_ps, max: _mm256_max_ps;
        fma: _mm256_fmadd_ps, sqrt: _mm256_sqrt_ps, xor: _mm256_xor_ps, andnot: _mm256_andnot_ps,
        splat: _mm256_set1_ps of f32
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        Self(unsafe { _mm256_div_ps(_mm256_set1_ps(1.0), _mm256_sqrt_ps(self.0)) })
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Signs {
        Signs(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, b.0) })
    }
    #[inline(always)]
    fn le(self, b: Self) -> Signs {
        Signs(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, b.0) })
    }
    #[inline(always)]
    fn and(a: Signs, b: Signs) -> Signs {
        Signs(unsafe { _mm256_and_ps(a.0, b.0) })
    }
    #[inline(always)]
    fn or(a: Signs, b: Signs) -> Signs {
        Signs(unsafe { _mm256_or_ps(a.0, b.0) })
    }
    #[inline(always)]
    fn not(a: Signs) -> Signs {
        Signs(unsafe { _mm256_xor_ps(a.0, _mm256_set1_ps(-0.0)) })
    }
    #[inline(always)]
    fn select(m: Signs, a: Self, b: Self) -> Self {
        Self(unsafe { _mm256_blendv_ps(b.0, a.0, m.0) })
    }
}

impl Memory for Single {
    type Near = f32;
    #[inline(always)]
    unsafe fn near(p: *const f32) -> Self {
        Self(unsafe { _mm256_loadu_ps(p) })
    }
    #[inline(always)]
    fn spread(v: f32) -> Self {
        Self(unsafe { _mm256_set1_ps(v) })
    }
    #[inline(always)]
    unsafe fn load(p: *const f64) -> Self {
        unsafe {
            Self::halves(
                _mm256_cvtpd_ps(_mm256_loadu_pd(p)),
                _mm256_cvtpd_ps(_mm256_loadu_pd(p.add(4))),
            )
        }
    }
    #[inline(always)]
    unsafe fn store(self, p: *mut f64) {
        let [low, high] = self.doubles();
        unsafe {
            _mm256_storeu_pd(p, low);
            _mm256_storeu_pd(p.add(4), high);
        }
    }
    #[inline(always)]
    unsafe fn store_where(self, m: Signs, p: *mut f64) {
        let [low, high] = self.doubles();
        unsafe {
            let m = _mm256_castps_si256(m.0);
            let first = _mm256_cvtepi32_epi64(_mm256_castsi256_si128(m));
            let last = _mm256_cvtepi32_epi64(_mm256_extracti128_si256::<1>(m));
            _mm256_maskstore_pd(p, first, low);
            _mm256_maskstore_pd(p.add(4), last, high);
        }
    }
    /// Shifts bit k into the sign of lane k.
    #[inline(always)]
    fn mask(bits: u16) -> Signs {
        unsafe {
            let all = _mm256_set1_epi32(bits as i32);
            let by = _mm256_setr_epi32(31, 30, 29, 28, 27, 26, 25, 24);
            Signs(_mm256_castsi256_ps(_mm256_sllv_epi32(all, by)))
        }
    }
    #[inline(always)]
    fn bits(m: Signs) -> u16 {
        unsafe { _mm256_movemask_ps(m.0) as u16 }
    }
    #[inline(always)]
    fn first(self) -> f64 {
        unsafe { _mm256_cvtss_f32(self.0) as f64 }
    }
}

vector! {
    /// AVX-512 in single precision: the nodes of two chunks.
    Wide(__m512), [f32; 16], _mm512_loadu_ps, _mm512_storeu_ps
}

impl Wide {
    /// The nodes of the first chunk, and of the second.
    #[inline(always)]
    fn chunks(self) -> [__m256; 2] {
        unsafe {
            [
                _mm512_castps512_ps256(self.0),
                _mm512_extractf32x8_ps::<1>(self.0),
            ]
        }
    }
}

impl Lane for Wide {
    const W: usize = 16;
    type Mask = __mmask16;
    arithmetic! {
        add: _mm512_add_ps, sub: _mm512_sub_ps, mul: _mm512_mul_ps, div: _mm512_div_ps, min: _mm512_min_ps, max: _mm512_max_ps;
        fma: _mm512_fmadd_ps, sqrt: _mm512_sqrt_ps, xor: _mm512_xor_ps, andnot: _mm512_andnot_ps,
        splat: _mm512_set1_ps of f32
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        Self(unsafe { _mm512_div_ps(_mm512_set1_ps(1.0), _mm512_sqrt_ps(self.0)) })
    }
    #[inline(always)]
    fn lt(self, b: Self) -> __mmask16 {
        unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, b.0) }
    }
    #[inline(always)]
    fn le(self, b: Self) -> __mmask16 {
        unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, b.0) }
    }
    #[inline(always)]
    fn and(a: __mmask16, b: __mmask16) -> __mmask16 {
        a & b
    }
    #[inline(always)]
    fn or(a: __mmask16, b: __mmask16) -> __mmask16 {
        a | b
    }
    #[inline(always)]
    fn not(a: __mmask16) -> __mmask16 {
        !a
    }
    #[inline(always)]
    fn select(m: __mmask16, a: Self, b: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_ps(m, b.0, a.0) })
    }
}

impl Memory for Wide {
    type Near = f32;
    #[inline(always)]
    unsafe fn near(p: *const f32) -> Self {
        Self(unsafe { _mm512_loadu_ps(p) })
    }
    #[inline(always)]
    fn spread(v: f32) -> Self {
        Self(unsafe { _mm512_set1_ps(v) })
    }
    #[inline(always)]
    unsafe fn load(p: *const f64) -> Self {
        unsafe {
            let first = _mm512_cvtpd_ps(_mm512_loadu_pd(p));
            let second = _mm512_cvtpd_ps(_mm512_loadu_pd(p.add(8)));
            Self(_mm512_insertf32x8::<1>(
                _mm512_castps256_ps512(first),
                second,
            ))
        }
    }
    #[inline(always)]
    unsafe fn store(self, p: *mut f64) {
        let [first, second] = self.chunks();
        unsafe {
            _mm512_storeu_pd(p, _mm512_cvtps_pd(first));
            _mm512_storeu_pd(p.add(8), _mm512_cvtps_pd(second));
        }
    }
    #[inline(always)]
    unsafe fn store_where(self, m: __mmask16, p: *mut f64) {
        let [first, second] = self.chunks();
        unsafe {
            _mm512_mask_storeu_pd(p, m as u8, _mm512_cvtps_pd(first));
            _mm512_mask_storeu_pd(p.add(8), (m >> 8) as u8, _mm512_cvtps_pd(second));
        }
    }
    #[inline(always)]
    fn mask(bits: u16) -> __mmask16 {
        bits
    }
    #[inline(always)]
    fn bits(m: __mmask16) -> u16 {
        m
    }
    #[inline(always)]
    fn first(self) -> f64 {
        f64::from(self.to_array()[0])
    }
}
