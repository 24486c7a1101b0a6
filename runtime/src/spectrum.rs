//! The stable time step from the largest eigenvalue of the body itself.
//!
//! `M^-1 K` is never formed: Lanczos applies the tangent of the actual body, with its free surfaces and cracks. The
//! start vector is fixed, so the step is the same in every run. Where the operator is not symmetric in the inner
//! product of the masses, power iteration takes over. Where fields follow the motion at once and push back, as heat of
//! deformation does, what they add to the stiffness counts. Fields at half steps that have no motion beside them make
//! waves with those at full steps, which are treated alike.

use crate::density::Density;
use crate::engine::{Breaking, Engine, FieldRate, Need, State};
use crate::integrate::total;
use crate::relax;
use crate::spec::{RateSpec, Spec, Stepped};
use serde::{Deserialize, Serialize};

/// A time step and where it comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StableStep {
    /// Upper estimate of the largest angular frequency, fields and contact included [rad/s]; 0 for a law without
    /// momentum.
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

/// The step of the body in its present state, where forces must have been evaluated: `safety * 2 / omega` where there
/// is motion, to which the fields adapt their stages; for fields alone what [`relax::USUAL`] stages reach.
pub fn stable_step(
    engine: &mut Engine,
    spec: &Spec,
    state: &State,
    density: &Density,
    contact: f64,
    safety: f64,
) -> StableStep {
    // Differences of rates over small changes, and symmetry to nine digits, are for double precision.
    let single = engine.is_single();
    if single {
        engine.pause_single(true);
        engine.forces(&mut state.clone(), Breaking::Held);
    }
    let staggered = spec.rates.iter().any(|r| r.stepped == Stepped::Half);
    let motion = match (spec.force.is_empty(), staggered) {
        (false, _) => stiffness(engine, state, density),
        (true, true) => exchange(engine, state),
        (true, false) => Estimate::default(),
    };
    let together = |r: &RateSpec| r.stepped == Stepped::Together;
    let fields = if !spec.rates.iter().any(together) {
        Estimate::default()
    } else {
        diffusion(engine, state)
    };
    if single {
        engine.pause_single(false);
        engine.forces(&mut state.clone(), Breaking::Held);
    }
    let omega = (motion.value.max(0.0) + contact).sqrt();
    let [moving, most] = [
        (omega, 2.0),
        (fields.value, relax::reach(relax::MOST_CHOSEN)),
    ]
    .map(|(fastest, reach)| {
        if fastest > 0.0 {
            reach / fastest
        } else {
            f64::INFINITY
        }
    });
    let alone = relax::reach(relax::USUAL) / relax::reach(relax::MOST_CHOSEN) * most;
    let limit = if spec.force.is_empty() && !staggered {
        alone
    } else {
        moving.min(most)
    };
    StableStep {
        omega,
        rate: fields.value,
        contact,
        applications: motion.applications + fields.applications,
        dt: safety * limit,
        safety,
    }
}

/// An upper estimate of an eigenvalue.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub applications: usize,
}

/// Largest eigenvalue of `M^-1 K` [rad^2/s^2], the stiffness through the fields included.
fn stiffness(engine: &mut Engine, state: &State, density: &Density) -> Estimate {
    let mass: Vec<f64> = (0..engine.len())
        .map(|s| engine.volume()[s] * density.at(s))
        .collect();
    let mut through = Through::new(engine, state);
    largest(state.u.len(), &mass, |x, y| {
        let df = engine.tangent(state, x);
        for (y, df) in y.iter_mut().zip(df) {
            for (s, (y, df)) in y.iter_mut().zip(df).enumerate() {
                *y = -df / density.at(s);
            }
        }
        if let Some(through) = &mut through {
            through.add(engine, x, y, density);
        }
    })
}

/// The force that a velocity makes through the rates of the fields.
struct Through {
    state: State,
    still: Vec<(usize, Vec<f64>)>,
    force: Field,
}

impl Through {
    /// `None` where no rate follows a velocity.
    fn new(engine: &mut Engine, state: &State) -> Option<Through> {
        if engine.spec().rates.is_empty() {
            return None;
        }
        let mut state = state.clone();
        state.v.iter_mut().for_each(|v| v.fill(0.0));
        engine.forces(&mut state, Breaking::Held);
        let mut through = Through {
            still: rates(engine, |r| r != Stepped::Half),
            force: engine.force().to_vec(),
            state,
        };
        let weight = engine.volume().to_vec();
        let x = noise(through.state.u.len(), &weight, 3);
        let rates = through.rates_of(engine, &x);
        let follows = through.largest(engine, &rates) > 0.0;
        engine.forces(&mut through.state, Breaking::Held);
        follows.then_some(through)
    }

    /// Change of the rates with the velocity `x`, per field component.
    fn rates_of(&mut self, engine: &mut Engine, x: &Field) -> Field {
        for (v, x) in self.state.v.iter_mut().zip(x) {
            v.copy_from_slice(x);
        }
        engine.evaluate(&mut self.state, Breaking::Held, Need::Rates);
        self.state.v.iter_mut().for_each(|v| v.fill(0.0));
        let full = engine.rates().filter(|r| r.stepped != Stepped::Half);
        let pairs = full.zip(&self.still);
        pairs
            .map(|(now, (_, still))| now.drive.iter().zip(still).map(|(a, b)| a - b).collect())
            .collect()
    }

    /// The largest rate at a node.
    fn largest(&self, engine: &Engine, rates: &Field) -> f64 {
        let one = |((slot, _), rate): (&(usize, Vec<f64>), &Vec<f64>)| {
            let real = |k: usize| engine.volume()[engine.slot_of(*slot, k)] > 0.0;
            let inside = rate.iter().enumerate().filter(|(k, _)| real(*k));
            inside.fold(0.0_f64, |m, (_, r)| m.max(r.abs()))
        };
        self.still.iter().zip(rates).map(one).fold(0.0, f64::max)
    }

    /// Adds to `y` minus the change of the acceleration as the fields go where `x` takes them. Leaves the engine as
    /// [`Engine::tangent`] wants it.
    fn add(&mut self, engine: &mut Engine, x: &Field, y: &mut Field, density: &Density) {
        let rates = self.rates_of(engine, x);
        let size = self.largest(engine, &rates);
        if size > 0.0 {
            let slots: Vec<usize> = self.still.iter().map(|(slot, _)| *slot).collect();
            // A change by one unit in the fastest place.
            let mut moved = self.state.clone();
            for (&slot, rate) in slots.iter().zip(&rates) {
                let add = |(t, r): (&mut f64, &f64)| *t += r / size;
                moved.slots[slot].iter_mut().zip(rate).for_each(add);
            }
            engine.evaluate(&mut moved, Breaking::Held, Need::Motion);
            for ((y, f), f0) in y.iter_mut().zip(engine.force()).zip(&self.force) {
                let change = f.iter().zip(f0).map(|(f, f0)| (f - f0) * size);
                for (s, (y, df)) in y.iter_mut().zip(change).enumerate() {
                    *y -= df / density.at(s);
                }
            }
        }
        engine.forces(&mut self.state, Breaking::Held);
    }
}

/// The rates, without their dampings, of the fields that are stepped so, each stored as its field is.
fn rates(engine: &Engine, chosen: impl Fn(Stepped) -> bool) -> Vec<(usize, Vec<f64>)> {
    let rates = engine.rates().filter(|r| chosen(r.stepped));
    rates.map(|r| (r.slot, r.drive.to_vec())).collect()
}

/// As [`rates`], in layout order.
fn everywhere(engine: &Engine, chosen: impl Fn(Stepped) -> bool) -> Vec<(usize, Vec<f64>)> {
    let rates = engine.rates().filter(|r| chosen(r.stepped));
    let all = |r: FieldRate| (r.slot, engine.spread(r.slot, r.drive).into_owned());
    rates.map(all).collect()
}

/// Moves a field of `state` by `h` times `x`, which is in layout order.
fn move_by(engine: &Engine, slot: usize, state: &State, h: f64, x: &[f64], to: &mut State) {
    let pairs = to.slots[slot].iter_mut().zip(&state.slots[slot]);
    for (k, (to, from)) in pairs.enumerate() {
        *to = from + h * x[engine.slot_of(slot, k)];
    }
}

/// Largest eigenvalue of minus the derivative of the rates along the fields [1/s], by differences of rates.
fn diffusion(engine: &mut Engine, state: &State) -> Estimate {
    let volume = engine.volume().to_vec();
    let evaluated = |engine: &mut Engine, state: &mut State| {
        engine.evaluate(state, Breaking::Held, Need::Rates);
        everywhere(engine, |r| r == Stepped::Together)
    };
    let mut probe = state.clone();
    let base = evaluated(engine, &mut probe);
    // A step of the size of the field keeps differences exact for linear laws and sensible for others.
    let size = base
        .iter()
        .flat_map(|(s, _)| &state.slots[*s])
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    let h = if size > 0.0 { 1e-3 * size } else { 1.0 };
    let found = largest(base.len(), &volume, |x, y| {
        for ((s, _), x) in base.iter().zip(x) {
            move_by(engine, *s, state, h, x, &mut probe);
        }
        let moved = evaluated(engine, &mut probe);
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

/// Largest eigenvalue of the waves that fields at full steps and at half steps make of each other [rad^2/s^2], by
/// differences of rates.
fn exchange(engine: &mut Engine, state: &State) -> Estimate {
    let volume = engine.volume().to_vec();
    let mut probe = state.clone();
    engine.forces(&mut probe, Breaking::Held);
    let [full, half] =
        [Stepped::Alone, Stepped::Half].map(|kind| everywhere(engine, |r| r == kind));
    let found = largest(full.len(), &volume, |x, y| {
        let pushed = respond(engine, &mut probe, state, &full, x, (Need::Half, &half));
        let back = respond(
            engine,
            &mut probe,
            state,
            &half,
            &pushed,
            (Need::Rates, &full),
        );
        for (y, back) in y.iter_mut().zip(&back) {
            y.iter_mut().zip(back).for_each(|(y, b)| *y = -b);
        }
    });
    engine.forces(&mut state.clone(), Breaking::Held);
    found
}

/// Change of the rates in `to` per change of the fields in `from` by `x`. Leaves `probe` as `state` is.
fn respond(
    engine: &mut Engine,
    probe: &mut State,
    state: &State,
    from: &[(usize, Vec<f64>)],
    x: &Field,
    (need, to): (Need, &[(usize, Vec<f64>)]),
) -> Field {
    let size = x.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let values = from.iter().flat_map(|(slot, _)| &state.slots[*slot]);
    let large = values.fold(0.0_f64, |m, v| m.max(v.abs()));
    // Of the size of the fields: exact for linear laws and sensible for others.
    let (step, unit) = (
        if large > 0.0 { 1e-3 * large } else { 1.0 },
        if size > 0.0 { size } else { 1.0 },
    );
    let h = step / unit;
    for ((slot, _), x) in from.iter().zip(x) {
        move_by(engine, *slot, state, h, x, probe);
    }
    engine.evaluate(probe, Breaking::Held, need);
    let now = everywhere(engine, |_| true);
    for (slot, _) in from {
        probe.slots[*slot].copy_from_slice(&state.slots[*slot]);
    }
    let change = |(slot, still): &(usize, Vec<f64>)| {
        let moved = now.iter().find(|(k, _)| k == slot).map(|(_, r)| r);
        let pairs = moved.into_iter().flatten().zip(still);
        pairs.map(|(r, r0)| (r - r0) / h).collect()
    };
    to.iter().map(change).collect()
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
