//! Integrals over the whole horizon: int g(r) S(r) dr with S = 2, 2 pi r, 4 pi r^2 times the cross-section.
//!
//! Tanh-sinh quadrature (Takahasi and Mori 1974): an integrable singularity at r = 0, as of r^-0.9, costs
//! nothing, because the nodes crowd there double exponentially. A panel that does not converge (a kink
//! or a jump inside) is halved.
use std::f64::consts::PI;

/// Nodes run over |t| <= REACH; the outermost lie at a relative distance of 1e-275 from the end.
const REACH: f64 = 6.0;
/// Finest step 2^-LEVELS.
const LEVELS: u32 = 6;
/// Relative to the integral of the absolute value.
const TOLERANCE: f64 = 2e-15;
const PANELS: usize = 2000;

/// Integral of `g(r)` over the ball of radius `delta` [m] in `dim` dimensions; `cross` is the thickness [m] in 2D,
/// the cross-section [m^2] in 1D. None where it does not converge to a finite number.
pub(crate) fn ball(
    g: &mut dyn FnMut(f64) -> f64,
    dim: usize,
    delta: f64,
    cross: f64,
) -> Option<f64> {
    let mut integrand = |r: f64| {
        let surface = match dim {
            1 => 2.0,
            2 => 2.0 * PI * r,
            _ => 4.0 * PI * r * r,
        };
        surface * g(r)
    };
    // Kinks at simple fractions of the horizon are common (piecewise polynomials): split there at once.
    let mut panels = vec![(0.0, 0.5 * delta), (0.5 * delta, delta)];
    let (mut scale, mut total, mut used) = (0.0, 0.0, 0);
    for &p in &panels {
        scale += panel(&mut integrand, p)?.size;
    }
    while let Some((a, b)) = panels.pop() {
        used += 1;
        let p = panel(&mut integrand, (a, b))?;
        let middle = 0.5 * (a + b);
        if p.error <= TOLERANCE * scale || middle <= a || middle >= b {
            total += p.value;
        } else if used < PANELS {
            panels.push((a, middle));
            panels.push((middle, b));
        } else {
            return None;
        }
    }
    Some(total * if dim == 3 { 1.0 } else { cross }).filter(|v| v.is_finite())
}

struct Panel {
    value: f64,
    /// Integral of the absolute value.
    size: f64,
    error: f64,
}

/// Trapezoidal sums in t of r = a + (b - a) / (1 + exp(-pi sinh t)), the step halved until they agree.
/// None where the integrand is not integrable at the lower end, or is not a number.
fn panel(f: &mut dyn FnMut(f64) -> f64, (a, b): (f64, f64)) -> Option<Panel> {
    let (mut sum, mut size, mut h) = (0.0, 0.0, 1.0);
    let mut value = f64::INFINITY;
    for level in 0..=LEVELS {
        let mut k = 0;
        while k as f64 * h <= REACH {
            // After the first level every other node is an old one.
            if level == 0 || k % 2 == 1 {
                let both = [k as f64 * h, -(k as f64) * h];
                for &t in if k == 0 { &both[..1] } else { &both } {
                    let v = node(f, (a, b), t)?;
                    sum += v;
                    size += v.abs();
                }
            }
            k += 1;
        }
        let error = (sum * h - value).abs();
        value = sum * h;
        if level == LEVELS || level >= 3 && error <= 0.1 * TOLERANCE * size * h {
            let end = node(f, (a, b), -REACH)?.abs();
            return (end <= TOLERANCE * size || size == 0.0).then_some(Panel {
                value,
                size: size * h,
                error,
            });
        }
        h *= 0.5;
    }
    None
}

/// Integrand times dr/dt. At the very ends (0 times infinity, beyond the range of numbers) there is nothing to add.
fn node(f: &mut dyn FnMut(f64) -> f64, (a, b): (f64, f64), t: f64) -> Option<f64> {
    let q = (-PI * t.sinh()).exp();
    let (left, right) = (1.0 / (1.0 + q), q / (1.0 + q));
    let v = f(a + (b - a) * left) * (b - a) * (PI * t.cosh() * left * right);
    match v.is_finite() {
        true => Some(v),
        false => (t.abs() > 5.0).then_some(0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_r_including_singular_ones() {
        let delta: f64 = 1.5e-3;
        for dim in 1..=3usize {
            for k in [0.0, 1.0, 2.0, 4.0, -0.5, -0.9] {
                let surface = [2.0, 2.0 * PI, 4.0 * PI][dim - 1];
                let n = dim as f64 + k;
                let exact = surface * delta.powf(n) / n * if dim == 3 { 1.0 } else { 0.25 };
                let found = ball(&mut |r| r.powf(k), dim, delta, 0.25).unwrap();
                assert!(
                    (found / exact - 1.0).abs() < 1e-13,
                    "{dim} {k} {}",
                    found / exact - 1.0
                );
            }
        }
    }

    #[test]
    fn kinks_and_jumps_are_found() {
        let tent = ball(&mut |r| if r < 0.3 { r } else { 0.6 - r }, 1, 1.0, 1.0).unwrap();
        // 2 (0.045 + int_0.3^1 (0.6 - r) dr) = 2 (0.045 + 0.42 - 0.455)
        assert!((tent - 0.02).abs() < 1e-14, "{tent}");
        let jump = ball(&mut |r| if r < 0.3 { 1.0 } else { 0.0 }, 1, 1.0, 1.0).unwrap();
        assert!((jump - 0.6).abs() < 1e-13, "{jump}");
    }

    #[test]
    fn divergent_integrals_are_refused() {
        assert_eq!(ball(&mut |_| f64::INFINITY, 1, 1.0, 1.0), None);
        assert_eq!(ball(&mut |_| f64::NAN, 2, 1.0, 1.0), None);
        for k in [-1.0, -1.5, -4.0] {
            assert_eq!(ball(&mut |r| r.powf(k), 1, 1.0, 1.0), None, "{k}");
        }
    }
}
