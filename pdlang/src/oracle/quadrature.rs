//! Integrals over the horizon by the double exponential rule.
//!
//! The rule of Takahasi and Mori (1974) bears integrable singularities at both ends, such as the power
//! influence function at r = 0, and shares nothing with the quadrature of the runtime.

use super::Error;
use std::f64::consts::PI;

/// Relative change between two refinements at which the integral counts as found.
const CONVERGED: f64 = 2e-15;
const LEVELS: u32 = 12;
/// Largest |t|: r then comes within 1e-123 of the ends, where r^-2 is still a finite number.
const RANGE: f64 = 5.2;

/// Integral of `f` from 0 to `end`.
///
/// # Errors
/// When `f` fails, is not finite where it counts, or the integral does not settle.
pub fn integrate(end: f64, f: &dyn Fn(f64) -> Result<f64, Error>) -> Result<f64, Error> {
    let mut step = 0.5;
    let mut sum = trapezium(end, step, f)?;
    for _ in 0..LEVELS {
        step *= 0.5;
        let finer = trapezium(end, step, f)?;
        if (finer - sum).abs() <= CONVERGED * finer.abs() {
            return Ok(finer);
        }
        sum = finer;
    }
    Err(Error(
        "an integral over the horizon does not converge".into(),
    ))
}

/// Trapezium rule in t after r = end q/(1 + q), q = exp(pi sinh t).
fn trapezium(end: f64, step: f64, f: &dyn Fn(f64) -> Result<f64, Error>) -> Result<f64, Error> {
    let last = (RANGE / step) as i32;
    let mut sum = 0.0;
    for k in -last..=last {
        sum += term(end, step * f64::from(k), f)?;
    }
    Ok(sum * step)
}

fn term(end: f64, t: f64, f: &dyn Fn(f64) -> Result<f64, Error>) -> Result<f64, Error> {
    let q = (PI * t.sinh()).exp();
    let weight = end * PI * t.cosh() * (q / (1.0 + q)) / (1.0 + q);
    let value = f(end * (q / (1.0 + q)))? * weight;
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Error("an integral over the horizon diverges".into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(end: f64, f: impl Fn(f64) -> f64, exact: f64, tolerance: f64) {
        let got = integrate(end, &|r| Ok(f(r))).unwrap();
        assert!(
            (got / exact - 1.0).abs() < tolerance,
            "{got} is not {exact}"
        );
    }

    #[test]
    fn polynomials_singular_powers_and_narrow_peaks() {
        check(2.0, |r| r * r, 8.0 / 3.0, 4e-15);
        // The power influence function with p = 1.5 in 1D: integral of r^(1-p) to 5 is 5^(1/2)/(1/2).
        check(5.0, |r| r.powf(-0.5), 2.0 * 5.0_f64.sqrt(), 4e-15);
        // The softened one with p = 1000, eps = 1: the closed form of its first moment.
        // A power of 1000 multiplies the rounding of its base by 1000.
        let moment = |d: f64| {
            let p = 1000.0;
            ((d + 1.0).powf(2.0 - p) - 1.0) / (2.0 - p)
                - ((d + 1.0).powf(1.0 - p) - 1.0) / (1.0 - p)
        };
        check(
            5.0,
            |r| r * (1.0 / (r + 1.0)).powf(1000.0),
            moment(5.0),
            1e-12,
        );
    }

    #[test]
    fn a_divergent_integral_is_an_error() {
        assert!(integrate(1.0, &|r| Ok(r.powf(-1.5))).is_err());
    }
}
