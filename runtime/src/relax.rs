//! Time integration of fields with rates: the stabilised Runge-Kutta-Legendre scheme of second order.
//!
//! A step of `s` stages is stable while `dt * rate <= (s^2 + s - 2)/2`, `rate` being the fastest of the fields: its
//! length grows with the square of its cost (Meyer, Balsara and Aslam 2014, J. Comput. Phys. 257, 594-626, RKL2).
//! Two stages are the explicit method of second order with its usual limit. Every pass treats each number on its
//! own, and changes are added to the value at the start: what a law conserves stays to rounding.

use crate::body::Body;
use crate::conditions::Conditions;
use crate::engine::{Breaking, Engine, Need, State};
use rayon::prelude::*;

/// Stages of a step whose length is chosen for the fields alone.
pub const USUAL: u32 = 5;
/// Beyond these, a chosen step is shortened, and a given one refused.
pub const MOST_CHOSEN: u32 = 25;
pub const MOST: u32 = 101;

/// What `dt * rate` may be.
pub fn reach(stages: u32) -> f64 {
    let s = f64::from(stages);
    0.5 * (s * s + s - 2.0)
}

/// The stages that a step needs: two, or an odd number, which damps what is too fast to follow. A few percent remain
/// between the step and its limit.
pub fn stages(dt: f64, rate: f64) -> u32 {
    let enough = |s: &u32| 0.95 * reach(*s) >= dt * rate;
    std::iter::once(2)
        .chain((3..).step_by(2))
        .take_while(|s| *s <= 2 * MOST)
        .find(enough)
        .unwrap_or(2 * MOST)
}

/// The arrays that a step needs, one per field component with a rate.
#[derive(Debug, Default)]
pub struct Relaxation {
    /// Positions in [`State::slots`].
    slots: Vec<usize>,
    start: Vec<Vec<f64>>,
    first: Vec<Vec<f64>>,
    older: Vec<Vec<f64>>,
}

impl Relaxation {
    pub fn new(engine: &Engine) -> Relaxation {
        let slots: Vec<usize> = engine.rates().map(|(slot, _)| slot).collect();
        let zeros = || vec![vec![0.0; engine.len()]; slots.len()];
        Relaxation {
            start: zeros(),
            first: zeros(),
            older: zeros(),
            slots,
        }
    }

    /// Advances the fields from `state.time` by `dt`; everything else in the state stands still. Conditions on fields
    /// hold at every stage. `evaluated` says that the engine has the rates of this very state.
    ///
    /// Returns whether all values are finite.
    pub fn step(
        &mut self,
        engine: &mut Engine,
        state: &mut State,
        act: (&Conditions, &Body),
        dt: f64,
        stages: u32,
        evaluated: bool,
    ) -> bool {
        let (conditions, body) = act;
        let w = 2.0 / reach(stages);
        // c_1 is w b_1, and c_j = (j^2 + j - 2)/(s^2 + s - 2).
        let place = |j: u32| match j {
            1 => w / 3.0,
            _ => reach(j) / reach(stages),
        };
        let time = state.time;
        if !evaluated {
            engine.evaluate(state, Breaking::Held, Need::Rates);
        }
        for (k, (slot, rate)) in engine.rates().enumerate() {
            debug_assert_eq!(slot, self.slots[k]);
            self.first[k].copy_from_slice(rate);
            self.start[k].copy_from_slice(&state.slots[slot]);
            self.older[k].copy_from_slice(&state.slots[slot]);
            let add = |(y, r): (&mut f64, &f64)| *y += w / 3.0 * dt * r;
            state.slots[slot].iter_mut().zip(rate).for_each(add);
        }
        conditions.impose_fields(body, time + place(1) * dt, &mut state.slots);
        for j in 2..=stages {
            engine.evaluate(state, Breaking::Held, Need::Rates);
            let weights = Weights::of(j, w * dt);
            for (k, (slot, rate)) in engine.rates().enumerate() {
                let arrays = (&self.start[k][..], &self.first[k][..], rate);
                weights.apply(&mut state.slots[slot], &mut self.older[k], arrays);
            }
            conditions.impose_fields(body, time + place(j) * dt, &mut state.slots);
        }
        self.finite(engine, state)
    }

    /// Padding may hold anything.
    fn finite(&self, engine: &Engine, state: &State) -> bool {
        let sound = |values: &Vec<f64>| {
            let chunks = values
                .par_chunks(CHUNK)
                .zip(engine.volume().par_chunks(CHUNK));
            chunks.all(|(values, volume)| {
                let real = values.iter().zip(volume).filter(|(_, v)| **v > 0.0);
                real.map(|(x, _)| x).sum::<f64>().is_finite()
            })
        };
        self.slots.iter().all(|&slot| sound(&state.slots[slot]))
    }
}

/// Numbers per task.
const CHUNK: usize = 8192;

/// The recursion of stage j: y = y0 + mu (y' - y0) + nu (y'' - y0) + now F(y') + then F(y0).
struct Weights {
    mu: f64,
    nu: f64,
    now: f64,
    then: f64,
}

impl Weights {
    fn of(j: u32, w: f64) -> Weights {
        let b = |j: u32| match j {
            0..=2 => 1.0 / 3.0,
            _ => {
                let j = f64::from(j);
                (j * j + j - 2.0) / (2.0 * j * (j + 1.0))
            }
        };
        let n = f64::from(j);
        let mu = (2.0 * n - 1.0) / n * b(j) / b(j - 1);
        Weights {
            mu,
            nu: -(n - 1.0) / n * b(j) / b(j - 2),
            now: mu * w,
            then: -(1.0 - b(j - 1)) * mu * w,
        }
    }

    fn apply(
        &self,
        y: &mut [f64],
        older: &mut [f64],
        (start, first, rate): (&[f64], &[f64], &[f64]),
    ) {
        let Weights { mu, nu, now, then } = *self;
        y.par_chunks_mut(CHUNK)
            .zip(older.par_chunks_mut(CHUNK))
            .zip(start.par_chunks(CHUNK))
            .zip(first.par_chunks(CHUNK))
            .zip(rate.par_chunks(CHUNK))
            .for_each(|((((y, older), y0), f0), f)| {
                for k in 0..y.len() {
                    let change = mu * (y[k] - y0[k]) + nu * (older[k] - y0[k]);
                    older[k] = y[k];
                    y[k] = y0[k] + (change + now * f[k] + then * f0[k]);
                }
            });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step of y' = -rate y from 1.
    fn decay(stages: u32, z: f64) -> f64 {
        let w = 2.0 / reach(stages);
        let (y0, f0) = ([1.0], [-z]);
        let (mut y, mut older) = ([1.0 - w / 3.0 * z], [1.0]);
        for j in 2..=stages {
            let f = [-z * y[0]];
            Weights::of(j, w).apply(&mut y, &mut older, (&y0, &f0, &f));
        }
        y[0]
    }

    #[test]
    fn of_second_order_and_stable_up_to_its_reach() {
        for stages in [2, 3, 5, 7, 25, 101] {
            for z in [1e-2_f64, 2e-2] {
                let error = decay(stages, z) - (-z).exp();
                assert!(
                    error.abs() < z.powi(3) / 6.0 * 1.01,
                    "{stages} {z} {error:e}"
                );
            }
            for k in 0..=1000 {
                let z = reach(stages) * f64::from(k) / 1000.0;
                let y = decay(stages, z);
                assert!(y.abs() <= 1.0 + 1e-12, "{stages} {z} {y}");
            }
            assert!(decay(stages, 2.0 * reach(stages)).abs() > 1.0);
        }
    }

    #[test]
    fn a_longer_step_has_more_stages() {
        assert_eq!(stages(0.0, 1.0), 2);
        assert_eq!(stages(1.9, 1.0), 2);
        assert_eq!(stages(1.91, 1.0), 3);
        assert_eq!(stages(11.2, 1.0), USUAL);
        assert_eq!(stages(reach(MOST_CHOSEN) * 0.9, 1.0), MOST_CHOSEN);
        assert!(stages(1e9, 1.0) > MOST);
    }
}
