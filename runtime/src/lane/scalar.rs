//! `f64` as the lane of one node: the reference, and the only lane on other processors than x86-64.
use super::{Memory, Record, Records, Sealed, powi};
use crate::kernel::Lane;

impl Sealed for f64 {}

impl Lane for f64 {
    const W: usize = 1;
    type Mask = bool;
    #[inline(always)]
    fn splat(v: f64) -> f64 {
        v
    }
    #[inline(always)]
    fn add(self, b: f64) -> f64 {
        self + b
    }
    #[inline(always)]
    fn sub(self, b: f64) -> f64 {
        self - b
    }
    #[inline(always)]
    fn mul(self, b: f64) -> f64 {
        self * b
    }
    #[inline(always)]
    fn div(self, b: f64) -> f64 {
        self / b
    }
    /// Fused only where the target always has the instruction; elsewhere it would be a library call.
    #[inline(always)]
    fn fma(self, b: f64, c: f64) -> f64 {
        if cfg!(any(
            target_arch = "aarch64",
            all(target_arch = "x86_64", target_feature = "fma")
        )) {
            self.mul_add(b, c)
        } else {
            self * b + c
        }
    }
    #[inline(always)]
    fn neg(self) -> f64 {
        -self
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    /// Second operand where either is NaN, as the vector instructions do.
    #[inline(always)]
    fn min(self, b: f64) -> f64 {
        if self < b { self } else { b }
    }
    #[inline(always)]
    fn max(self, b: f64) -> f64 {
        if self > b { self } else { b }
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn rsqrt(self) -> f64 {
        1.0 / f64::sqrt(self)
    }
    #[inline(always)]
    fn exp(self) -> f64 {
        f64::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> f64 {
        f64::ln(self)
    }
    #[inline(always)]
    fn sin(self) -> f64 {
        f64::sin(self)
    }
    #[inline(always)]
    fn cos(self) -> f64 {
        f64::cos(self)
    }
    #[inline(always)]
    fn tan(self) -> f64 {
        f64::tan(self)
    }
    #[inline(always)]
    fn pow(self, b: f64) -> f64 {
        f64::powf(self, b)
    }
    #[inline(always)]
    fn powi(self, n: i32) -> f64 {
        powi(self, n)
    }
    #[inline(always)]
    fn lt(self, b: f64) -> bool {
        self < b
    }
    #[inline(always)]
    fn le(self, b: f64) -> bool {
        self <= b
    }
    #[inline(always)]
    fn and(a: bool, b: bool) -> bool {
        a & b
    }
    #[inline(always)]
    fn or(a: bool, b: bool) -> bool {
        a | b
    }
    #[inline(always)]
    fn not(a: bool) -> bool {
        !a
    }
    #[inline(always)]
    fn select(m: bool, a: f64, b: f64) -> f64 {
        if m { a } else { b }
    }
}

impl Memory for f64 {
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
    unsafe fn load(p: *const f64) -> f64 {
        unsafe { *p }
    }
    #[inline(always)]
    unsafe fn store(self, p: *mut f64) {
        unsafe { *p = self }
    }
    #[inline(always)]
    unsafe fn store_where(self, m: bool, p: *mut f64) {
        if m {
            unsafe { *p = self }
        }
    }
    #[inline(always)]
    unsafe fn gather(p: *const f64, index: *const u32) -> f64 {
        unsafe { *p.add(*index as usize) }
    }
    #[inline(always)]
    fn mask(bits: u16) -> bool {
        bits & 1 == 1
    }
    #[inline(always)]
    fn bits(m: bool) -> u16 {
        m.into()
    }
    #[inline(always)]
    fn first(self) -> f64 {
        self
    }
}

impl Records for f64 {
    #[inline(always)]
    unsafe fn gather_records(p: *const Record, index: *const u32) -> [f64; 4] {
        unsafe { (*p.add(*index as usize)).0 }
    }
}
