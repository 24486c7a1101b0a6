//! Numbers that carry a derivative.
//!
//! `Dual<f64>` holds a value and its derivative along one direction; `Dual<Dual<f64>>` holds two
//! directions and the mixed second derivative. The oracle is generic over them, so that forces and
//! tangents come from the energy by arithmetic alone. Slopes may be complex, amplitudes of a wave.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// What the interpreter needs of a number.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A number without derivatives.
    fn constant(value: f64) -> Self;
    /// The value, without derivatives.
    fn value(self) -> f64;
    /// True when every derivative is zero.
    fn is_constant(self) -> bool;
    fn sqrt(self) -> Self;
    fn exp(self) -> Self;
    fn ln(self) -> Self;
    fn sin(self) -> Self;
    fn cos(self) -> Self;
    fn pow(self, exponent: Self) -> Self;

    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }
    fn min(self, other: Self) -> Self {
        if other.value() < self.value() {
            other
        } else {
            self
        }
    }
    fn max(self, other: Self) -> Self {
        if other.value() > self.value() {
            other
        } else {
            self
        }
    }
}

impl Real for f64 {
    fn constant(value: f64) -> f64 {
        value
    }
    fn value(self) -> f64 {
        self
    }
    fn is_constant(self) -> bool {
        true
    }
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    fn exp(self) -> f64 {
        f64::exp(self)
    }
    fn ln(self) -> f64 {
        f64::ln(self)
    }
    fn sin(self) -> f64 {
        f64::sin(self)
    }
    fn cos(self) -> f64 {
        f64::cos(self)
    }
    fn pow(self, exponent: f64) -> f64 {
        self.powf(exponent)
    }
}

/// A complex number, for slopes along a wave `exp(i k.x)`. What is not a slope is real, and functions are asked of
/// the real part alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Complex {
    pub re: f64,
    pub im: f64,
}

impl Complex {
    /// `exp(i phase)`.
    pub fn of_phase(phase: f64) -> Complex {
        let (im, re) = phase.sin_cos();
        Complex { re, im }
    }

    #[must_use]
    pub fn conjugate(self) -> Complex {
        Complex {
            re: self.re,
            im: -self.im,
        }
    }

    fn real(re: f64) -> Complex {
        Complex { re, im: 0.0 }
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Complex {
            re: self.re + b.re,
            im: self.im + b.im,
        }
    }
}

impl Sub for Complex {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Complex {
            re: self.re * b.re - self.im * b.im,
            im: self.re * b.im + self.im * b.re,
        }
    }
}

impl Div for Complex {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        // Also by infinity.
        if b.im == 0.0 {
            return Complex {
                re: self.re / b.re,
                im: self.im / b.re,
            };
        }
        let size = b.re * b.re + b.im * b.im;
        let product = self * b.conjugate();
        Complex {
            re: product.re / size,
            im: product.im / size,
        }
    }
}

impl Neg for Complex {
    type Output = Self;
    fn neg(self) -> Self {
        Complex {
            re: -self.re,
            im: -self.im,
        }
    }
}

impl Real for Complex {
    fn constant(value: f64) -> Self {
        Complex::real(value)
    }
    fn value(self) -> f64 {
        self.re
    }
    fn is_constant(self) -> bool {
        self.im == 0.0
    }
    fn sqrt(self) -> Self {
        Complex::real(self.re.sqrt())
    }
    fn exp(self) -> Self {
        Complex::real(self.re.exp())
    }
    fn ln(self) -> Self {
        Complex::real(self.re.ln())
    }
    fn sin(self) -> Self {
        Complex::real(self.re.sin())
    }
    fn cos(self) -> Self {
        Complex::real(self.re.cos())
    }
    fn pow(self, exponent: Self) -> Self {
        Complex::real(self.re.powf(exponent.re))
    }
}

/// A value and its derivative along one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<T> {
    pub value: T,
    pub slope: T,
}

impl<T: Real> Dual<T> {
    pub fn new(value: T, slope: T) -> Dual<T> {
        Dual { value, slope }
    }

    /// f(self), given f and f' at the value.
    fn chain(self, value: T, slope: T) -> Dual<T> {
        Dual {
            value,
            slope: slope * self.slope,
        }
    }
}

impl<T: Real> Add for Dual<T> {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Dual::new(self.value + b.value, self.slope + b.slope)
    }
}

impl<T: Real> Sub for Dual<T> {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Dual::new(self.value - b.value, self.slope - b.slope)
    }
}

impl<T: Real> Mul for Dual<T> {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Dual::new(
            self.value * b.value,
            self.slope * b.value + self.value * b.slope,
        )
    }
}

impl<T: Real> Div for Dual<T> {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        Dual::new(value, (self.slope - value * b.slope) / b.value)
    }
}

impl<T: Real> Neg for Dual<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Dual::new(-self.value, -self.slope)
    }
}

impl<T: Real> Real for Dual<T> {
    fn constant(value: f64) -> Self {
        Dual::new(T::constant(value), T::constant(0.0))
    }
    fn value(self) -> f64 {
        self.value.value()
    }
    fn is_constant(self) -> bool {
        self.value.is_constant() && self.slope.is_constant() && self.slope.value() == 0.0
    }
    /// The root of a constant zero is a constant zero: a length that does not move has no slope.
    fn sqrt(self) -> Self {
        if self.value() == 0.0 && self.is_constant() {
            return self;
        }
        let root = self.value.sqrt();
        self.chain(root, T::constant(0.5) / root)
    }
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }
    fn ln(self) -> Self {
        self.chain(self.value.ln(), T::constant(1.0) / self.value)
    }
    fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }
    fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }
    /// A constant exponent needs no logarithm, so that zero and negative bases stay legal.
    fn pow(self, exponent: Self) -> Self {
        if !exponent.is_constant() {
            return (self.ln() * exponent).exp();
        }
        let n = exponent.value();
        if n == 0.0 {
            return Self::constant(1.0);
        }
        let slope = T::constant(n) * self.value.pow(T::constant(n - 1.0));
        self.chain(self.value.pow(T::constant(n)), slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seed(x: f64) -> Dual<Dual<f64>> {
        Dual::new(Dual::new(x, 1.0), Dual::new(1.0, 0.0))
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-14 * b.abs().max(1.0), "{a} is not {b}");
    }

    #[test]
    fn first_and_second_derivatives_of_a_composed_function() {
        // f = sqrt(x) exp(x) / x^3 at 1.3: log f = x - 2.5 ln x, so f'/f = 1 - 2.5/x, f''/f = (f'/f)^2 + 2.5/x^2.
        let x = 1.3;
        let three = Dual::constant(3.0);
        let f = seed(x).sqrt() * seed(x).exp() / seed(x).pow(three);
        let (value, ratio) = (x.exp() * x.powf(-2.5), 1.0 - 2.5 / x);
        close(f.value.value, value);
        close(f.value.slope, value * ratio);
        close(f.slope.value, value * ratio);
        close(f.slope.slope, value * (ratio * ratio + 2.5 / (x * x)));
    }

    #[test]
    fn trigonometry_and_logarithm() {
        // f = sin(x) cos(x) ln(x): f' = cos(2x) ln x + sin(2x)/(2x).
        let x = 0.7_f64;
        let f = seed(x).sin() * seed(x).cos() * seed(x).ln();
        close(
            f.slope.value,
            (2.0 * x).cos() * x.ln() + (2.0 * x).sin() / (2.0 * x),
        );
    }

    #[test]
    fn powers_at_zero_and_below() {
        let square = seed(0.0).pow(Dual::constant(2.0));
        assert_eq!(
            (square.value.value, square.slope.value, square.slope.slope),
            (0.0, 0.0, 2.0)
        );
        assert_eq!(seed(-2.0).pow(Dual::constant(3.0)).slope.value, 12.0);
        // x^x has the slope x^x (1 + ln x).
        let x = 1.7_f64;
        close(seed(x).pow(seed(x)).slope.value, x.powf(x) * (1.0 + x.ln()));
    }

    #[test]
    fn a_constant_zero_has_a_root() {
        let root = Dual::<f64>::constant(0.0).sqrt();
        assert_eq!((root.value, root.slope), (0.0, 0.0));
    }
}
