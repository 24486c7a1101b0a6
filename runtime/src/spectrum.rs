//! The stable time step from the largest eigenvalue of the body itself.
//!
//! `M^-1 K` is never formed: Lanczos applies the tangent of the actual body, with its free surfaces and cracks. The
//! start vector is fixed, so the step is the same in every run. Where the operator is not symmetric in the inner
//! product of the masses, power iteration takes over.

use crate::engine::{Breaking, Engine, State};
use crate::integrate::total;
use crate::spec::Spec;
use serde::{Deserialize, Serialize};

/// A time step and where it comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StableStep {
    /// Upper estimate of the largest angular frequency, contact included [rad/s]; 0 for a law without momentum.
    pub omega: f64,
    /// Upper estimate of the fastest rate of a field [1/s]; 0 without fields.
    pub rate: f64,
    /// Share of `omega` squared that contact may add [rad^2/s^2].
    pub contact: f64,
    /// Applications of the tangent that it took.
    pub applications: usize,
    /// `safety` times the limit [s]; infinite for a body without stiffness.
    pub dt: f64,
    pub safety: f64,
}

/// The step `safety * 2 / max(omega, rate)` of the body in its present state. Forces must have been evaluated there.
pub fn stable_step(
    engine: &mut Engine,
    spec: &Spec,
    state: &State,
    density: f64,
    contact: f64,
    safety: f64,
) -> StableStep {
    let motion = if spec.force.is_empty() {
        Estimate::default()
    } else {
        stiffness(engine, state, density)
    };
    let fields = if spec.rates.is_empty() {
        Estimate::default()
    } else {
        diffusion(engine, state)
    };
    let omega = (motion.value.max(0.0) + contact).sqrt();
    let fastest = omega.max(fields.value);
    StableStep {
        omega,
        rate: fields.value,
        contact,
        applications: motion.applications + fields.applications,
        dt: if fastest > 0.0 {
            safety * 2.0 / fastest
        } else {
            f64::INFINITY
        },
        safety,
    }
}

/// An upper estimate of an eigenvalue.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub applications: usize,
}

/// Largest eigenvalue of `M^-1 K` [rad^2/s^2].
fn stiffness(engine: &mut Engine, state: &State, density: f64) -> Estimate {
    let volume = engine.volume().to_vec();
    largest(state.u.len(), &volume, |x, y| {
        let df = engine.tangent(state, x);
        for (y, df) in y.iter_mut().zip(df) {
            y.iter_mut().zip(df).for_each(|(y, df)| *y = -df / density);
        }
    })
}

/// Largest eigenvalue of minus the derivative of the rates along the fields [1/s], by differences of rates.
fn diffusion(engine: &mut Engine, state: &State) -> Estimate {
    let volume = engine.volume().to_vec();
    let rates = |engine: &mut Engine, state: &mut State| -> Vec<(usize, Vec<f64>)> {
        engine.forces(state, Breaking::Held);
        engine.rates().map(|(s, r)| (s, r.to_vec())).collect()
    };
    let mut probe = state.clone();
    let base = rates(engine, &mut probe);
    // A step of the size of the field keeps differences exact for linear laws and sensible for others.
    let size = base
        .iter()
        .flat_map(|(s, _)| &state.slots[*s])
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    let h = if size > 0.0 { 1e-3 * size } else { 1.0 };
    let found = largest(base.len(), &volume, |x, y| {
        for ((s, _), x) in base.iter().zip(x) {
            probe.slots[*s]
                .iter_mut()
                .zip(&state.slots[*s])
                .zip(x)
                .for_each(|((p, t), x)| *p = t + h * x);
        }
        let moved = rates(engine, &mut probe);
        for ((y, (_, r1)), (_, r0)) in y.iter_mut().zip(&moved).zip(&base) {
            y.iter_mut()
                .zip(r1)
                .zip(r0)
                .for_each(|((y, r1), r0)| *y = -(r1 - r0) / h);
        }
    });
    engine.forces(&mut state.clone(), Breaking::Held);
    found
}

/// Vectors with one array per component, layout order.
type Field = Vec<Vec<f64>>;

/// Relative width at which the search ends, and what is added to a result of power iteration.
const ACCURACY: f64 = 0.01;
const LANCZOS_STEPS: usize = 120;
const POWER_STEPS: usize = 400;

/// Upper estimate of the largest eigenvalue of `apply`, self-adjoint in the inner product weighted with `weight`;
/// entries without weight are padding and stay 0.
pub fn largest(
    components: usize,
    weight: &[f64],
    mut apply: impl FnMut(&Field, &mut Field),
) -> Estimate {
    let x = noise(components, weight, 1);
    let y = noise(components, weight, 2);
    let (mut ax, mut ay) = (zeros(&x), zeros(&x));
    masked(&mut apply, weight, &x, &mut ax);
    masked(&mut apply, weight, &y, &mut ay);
    let scale = (inner(weight, &ax, &ax) * inner(weight, &y, &y)).sqrt();
    let skew = (inner(weight, &ax, &y) - inner(weight, &x, &ay)).abs();
    let mut estimate = if skew <= 1e-9 * scale {
        lanczos(x, weight, &mut apply)
    } else {
        power(x, weight, &mut apply)
    };
    estimate.applications += 2;
    estimate
}

/// Three-term recurrence without reorthogonalisation, which the largest value does not need. Ends when the largest
/// Ritz value's residual is below [`ACCURACY`]; the residual is added.
fn lanczos(mut q: Field, weight: &[f64], apply: &mut impl FnMut(&Field, &mut Field)) -> Estimate {
    let mut old = zeros(&q);
    let mut w = zeros(&q);
    let (mut alpha, mut beta) = (Vec::new(), Vec::new());
    let length = inner(weight, &q, &q).sqrt();
    scale(&mut q, 1.0 / length);
    let mut best = Estimate::default();
    for k in 0..LANCZOS_STEPS {
        masked(apply, weight, &q, &mut w);
        let a = inner(weight, &w, &q);
        let b0 = beta.last().copied().unwrap_or(0.0);
        combine(&mut w, a, &q, b0, &old);
        let b = inner(weight, &w, &w).sqrt();
        alpha.push(a);
        let (ritz, tail) = top(&alpha, &beta);
        best = Estimate {
            value: ritz + b * tail,
            applications: k + 1,
        };
        if !(b > 0.0 && b.is_finite()) || (k > 8 && b * tail < ACCURACY * ritz) {
            break;
        }
        beta.push(b);
        scale(&mut w, 1.0 / b);
        std::mem::swap(&mut old, &mut q);
        std::mem::swap(&mut q, &mut w);
    }
    best
}

/// Repeated application, for operators that are not symmetric.
fn power(mut q: Field, weight: &[f64], apply: &mut impl FnMut(&Field, &mut Field)) -> Estimate {
    let mut w = zeros(&q);
    let mut last = 0.0;
    for k in 0..POWER_STEPS {
        let length = inner(weight, &q, &q).sqrt();
        scale(&mut q, 1.0 / length);
        masked(apply, weight, &q, &mut w);
        let growth = inner(weight, &w, &w).sqrt();
        // Growth per application approaches the largest magnitude slowly: demand ten times less change than accuracy.
        if growth.is_nan()
            || growth <= 0.0
            || (k > 20 && (growth - last).abs() < 0.1 * ACCURACY / 20.0 * growth)
        {
            return Estimate {
                value: growth * (1.0 + 2.0 * ACCURACY),
                applications: k + 1,
            };
        }
        last = growth;
        std::mem::swap(&mut q, &mut w);
    }
    Estimate {
        value: last * (1.0 + 5.0 * ACCURACY),
        applications: POWER_STEPS,
    }
}

/// Largest eigenvalue of a symmetric tridiagonal matrix and the last entry of its unit eigenvector.
fn top(alpha: &[f64], beta: &[f64]) -> (f64, f64) {
    let row = |k: usize| {
        beta.get(k).copied().unwrap_or(0.0).abs() + if k > 0 { beta[k - 1].abs() } else { 0.0 }
    };
    let mut high = (0..alpha.len())
        .map(|k| alpha[k] + row(k))
        .fold(f64::NEG_INFINITY, f64::max);
    let mut low = alpha.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if all_below(alpha, beta, middle) {
            high = middle
        } else {
            low = middle
        }
    }
    (high, last_entry(alpha, beta, high))
}

/// Whether every eigenvalue is below `x` (all pivots of T - x are negative).
fn all_below(alpha: &[f64], beta: &[f64], x: f64) -> bool {
    let mut pivot = alpha[0] - x;
    for k in 1..alpha.len() {
        if pivot.is_nan() || pivot >= 0.0 {
            return false;
        }
        pivot = alpha[k] - x - beta[k - 1] * beta[k - 1] / pivot;
    }
    pivot < 0.0
}

/// One step of inverse iteration beside the eigenvalue; the matrix shifted there is negative definite.
fn last_entry(alpha: &[f64], beta: &[f64], eigenvalue: f64) -> f64 {
    let n = alpha.len();
    let shift = eigenvalue + 1e-10 * eigenvalue.abs().max(f64::MIN_POSITIVE);
    let mut pivot = vec![0.0; n];
    let mut x = vec![1.0; n];
    pivot[0] = alpha[0] - shift;
    for k in 1..n {
        let factor = beta[k - 1] / pivot[k - 1];
        pivot[k] = alpha[k] - shift - factor * beta[k - 1];
        x[k] -= factor * x[k - 1];
    }
    x[n - 1] /= pivot[n - 1];
    for k in (0..n - 1).rev() {
        x[k] = (x[k] - beta[k] * x[k + 1]) / pivot[k];
    }
    let length = x.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length.is_finite() && length > 0.0 {
        (x[n - 1] / length).abs()
    } else {
        1.0
    }
}

/// A fixed vector without structure: signs and sizes from a mixing of the index (splitmix64).
fn noise(components: usize, weight: &[f64], seed: u64) -> Field {
    let value = |d: usize, s: usize| {
        let mut z = (s as u64 * 3 + d as u64 + 1)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add(seed << 32);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let entry = |d, s: usize| if weight[s] > 0.0 { value(d, s) } else { 0.0 };
    (0..components)
        .map(|d| (0..weight.len()).map(|s| entry(d, s)).collect())
        .collect()
}

fn masked(apply: &mut impl FnMut(&Field, &mut Field), weight: &[f64], x: &Field, y: &mut Field) {
    apply(x, y);
    for y in y {
        y.iter_mut()
            .zip(weight)
            .filter(|(_, w)| **w == 0.0)
            .for_each(|(y, _)| *y = 0.0);
    }
}

fn zeros(like: &Field) -> Field {
    like.iter().map(|x| vec![0.0; x.len()]).collect()
}

fn inner(weight: &[f64], a: &Field, b: &Field) -> f64 {
    total(weight.len(), |s| {
        [weight[s] * a.iter().zip(b).map(|(a, b)| a[s] * b[s]).sum::<f64>()]
    })[0]
}

fn scale(x: &mut Field, factor: f64) {
    x.iter_mut().flatten().for_each(|x| *x *= factor);
}

/// `w -= a q + b old`.
fn combine(w: &mut Field, a: f64, q: &Field, b: f64, old: &Field) {
    for ((w, q), old) in w.iter_mut().zip(q).zip(old) {
        w.iter_mut()
            .zip(q)
            .zip(old)
            .for_each(|((w, q), old)| *w -= a * q + b * old);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eigenvalues of a chain with fixed ends are 2 - 2 cos(k pi / (n + 1)).
    fn chain(x: &Field, y: &mut Field, skew: f64) {
        let x = &x[0];
        for i in 0..x.len() {
            let at = |k: usize| x.get(k).copied().unwrap_or(0.0);
            y[0][i] = 2.0 * x[i] - (1.0 + skew) * at(i + 1) - at(i.wrapping_sub(1));
        }
    }

    #[test]
    fn the_largest_value_of_a_chain() {
        let exact = 2.0 + 2.0 * (std::f64::consts::PI / 501.0).cos();
        let found = largest(1, &[1.0; 500], |x, y| chain(x, y, 0.0));
        assert!(
            found.value >= exact * 0.9999 && found.value < exact * 1.02,
            "{found:?}"
        );
        assert!(found.applications < 100, "{found:?}");
    }

    #[test]
    fn an_unsymmetric_operator_falls_back_to_powers() {
        // Similar to a symmetric chain with off-diagonals sqrt(1.2): largest value 2 + 2 sqrt(1.2) cos(pi / 21).
        let exact = 2.0 + 2.0 * 1.2_f64.sqrt() * (std::f64::consts::PI / 21.0).cos();
        let found = largest(1, &[1.0; 20], |x, y| chain(x, y, 0.2));
        assert!(
            (found.value / exact - 1.0).abs() < 0.04,
            "{found:?} {exact}"
        );
    }

    #[test]
    fn padding_and_weights_are_respected() {
        // Two masses on a spring: eigenvalues 0 and k (1/m1 + 1/m2); a padded entry in the middle.
        let weight = [2.0, 0.0, 0.5];
        let found = largest(1, &weight, |x, y| {
            let pull = x[0][2] - x[0][0];
            y[0] = vec![-pull / 2.0, f64::NAN, pull / 0.5];
        });
        assert!((found.value - 2.5).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn no_stiffness_is_no_limit() {
        assert_eq!(
            largest(2, &[1.0; 10], |_, y| y.iter_mut().for_each(|y| y.fill(0.0))).value,
            0.0
        );
    }
}
