//! Single precision, for the bonds of a lattice: eight nodes in a register of AVX2, sixteen in one of AVX-512.
//!
//! Numbers of nodes and constants are those of double precision, rounded where they are read.
// SAFETY (whole file): as in `avx2`.
use super::{Memory, Record, Sealed, lane_by_lane, powi};
use crate::kernel::Lane;
use std::arch::x86_64::*;

#[derive(Clone, Copy)]
pub(crate) struct Single(__m256);

/// Truth in the sign bit of each lane; the other bits mean nothing.
#[derive(Clone, Copy)]
pub(crate) struct Signs(__m256);

impl Single {
    #[inline(always)]
    fn to_array(self) -> [f32; 8] {
        let mut a = [0.0; 8];
        unsafe { _mm256_storeu_ps(a.as_mut_ptr(), self.0) };
        a
    }
    #[inline(always)]
    fn from_array(a: [f32; 8]) -> Self {
        Self(unsafe { _mm256_loadu_ps(a.as_ptr()) })
    }
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

impl Sealed for Single {}

impl Lane for Single {
    const W: usize = 8;
    type Mask = Signs;
    #[inline(always)]
    fn splat(v: f64) -> Self {
        Self(unsafe { _mm256_set1_ps(v as f32) })
    }
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self(unsafe { _mm256_add_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self(unsafe { _mm256_sub_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        Self(unsafe { _mm256_mul_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        Self(unsafe { _mm256_div_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        Self(unsafe { _mm256_min_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        Self(unsafe { _mm256_max_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm256_fmadd_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        Self(unsafe { _mm256_div_ps(_mm256_set1_ps(1.0), _mm256_sqrt_ps(self.0)) })
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
    #[inline(always)]
    unsafe fn gather(p: *const f64, index: *const u32) -> Self {
        let mut a = [0.0; 8];
        let mut k = 0;
        while k < 8 {
            a[k] = unsafe { *p.add(*index.add(k) as usize) as f32 };
            k += 1;
        }
        Self::from_array(a)
    }
    #[inline(always)]
    unsafe fn gather_records(p: *const Record, index: *const u32) -> [Self; 4] {
        let mut all = [[0.0; 8]; 4];
        let mut k = 0;
        while k < 8 {
            let record = unsafe { (*p.add(*index.add(k) as usize)).0 };
            let mut a = 0;
            while a < 4 {
                all[a][k] = record[a] as f32;
                a += 1;
            }
            k += 1;
        }
        all.map(Self::from_array)
    }
    /// Shifts bit k into the sign of lane k.
    #[inline(always)]
    fn mask(bits: u8) -> Signs {
        unsafe {
            let all = _mm256_set1_epi32(bits as i32);
            let by = _mm256_setr_epi32(31, 30, 29, 28, 27, 26, 25, 24);
            Signs(_mm256_castsi256_ps(_mm256_sllv_epi32(all, by)))
        }
    }
    #[inline(always)]
    fn bits(m: Signs) -> u8 {
        unsafe { _mm256_movemask_ps(m.0) as u8 }
    }
    #[inline(always)]
    fn first(self) -> f64 {
        unsafe { _mm256_cvtss_f32(self.0) as f64 }
    }
    #[inline(always)]
    fn prefetch(p: *const u8) {
        unsafe { _mm_prefetch::<_MM_HINT_T0>(p.cast()) }
    }
}

/// AVX-512 in single precision: the nodes of two chunks.
#[derive(Clone, Copy)]
pub(crate) struct Wide(__m512);

impl Wide {
    #[inline(always)]
    fn to_array(self) -> [f32; 16] {
        let mut a = [0.0; 16];
        unsafe { _mm512_storeu_ps(a.as_mut_ptr(), self.0) };
        a
    }
    #[inline(always)]
    fn from_array(a: [f32; 16]) -> Self {
        Self(unsafe { _mm512_loadu_ps(a.as_ptr()) })
    }
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

impl Sealed for Wide {}

impl Lane for Wide {
    const W: usize = 16;
    type Mask = __mmask16;
    #[inline(always)]
    fn splat(v: f64) -> Self {
        Self(unsafe { _mm512_set1_ps(v as f32) })
    }
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self(unsafe { _mm512_add_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self(unsafe { _mm512_sub_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        Self(unsafe { _mm512_mul_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        Self(unsafe { _mm512_div_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        Self(unsafe { _mm512_min_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        Self(unsafe { _mm512_max_ps(self.0, b.0) })
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        Self(unsafe { _mm512_fmadd_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { _mm512_xor_ps(self.0, _mm512_set1_ps(-0.0)) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_andnot_ps(_mm512_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm512_sqrt_ps(self.0) })
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        Self(unsafe { _mm512_div_ps(_mm512_set1_ps(1.0), _mm512_sqrt_ps(self.0)) })
    }
    lane_by_lane!(exp, ln, sin, cos, tan);
    #[inline(always)]
    fn pow(self, b: Self) -> Self {
        let (mut a, b) = (self.to_array(), b.to_array());
        let mut k = 0;
        while k < 16 {
            a[k] = a[k].powf(b[k]);
            k += 1;
        }
        Self::from_array(a)
    }
    #[inline(always)]
    fn powi(self, n: i32) -> Self {
        powi(self, n)
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
    unsafe fn gather(p: *const f64, index: *const u32) -> Self {
        let mut a = [0.0; 16];
        let mut k = 0;
        while k < 16 {
            a[k] = unsafe { *p.add(*index.add(k) as usize) as f32 };
            k += 1;
        }
        Self::from_array(a)
    }
    #[inline(always)]
    unsafe fn gather_records(p: *const Record, index: *const u32) -> [Self; 4] {
        let mut all = [[0.0; 16]; 4];
        let mut k = 0;
        while k < 16 {
            let record = unsafe { (*p.add(*index.add(k) as usize)).0 };
            let mut a = 0;
            while a < 4 {
                all[a][k] = record[a] as f32;
                a += 1;
            }
            k += 1;
        }
        all.map(Self::from_array)
    }
    /// Alike in both chunks.
    #[inline(always)]
    fn mask(bits: u8) -> __mmask16 {
        Self::mask_of_two([bits; 2])
    }
    #[inline(always)]
    fn bits(m: __mmask16) -> u8 {
        m as u8
    }
    #[inline(always)]
    fn mask_of_two(bits: [u8; 2]) -> __mmask16 {
        u16::from_le_bytes(bits)
    }
    #[inline(always)]
    fn bits_of_two(m: __mmask16) -> [u8; 2] {
        m.to_le_bytes()
    }
    #[inline(always)]
    fn first(self) -> f64 {
        f64::from(self.to_array()[0])
    }
    #[inline(always)]
    fn prefetch(p: *const u8) {
        unsafe { _mm_prefetch::<_MM_HINT_T0>(p.cast()) }
    }
}
