//! Time integration of fields with rates.
//!
//! A rate `drive - damping*field` that the fields of its own kind leave alone is stepped at once by the trapezoidal
//! rule, `((1 - damping dt/2) field + dt drive)/(1 + damping dt/2)`, at any damping that is not negative: fields at full
//! steps from the middle of the step, those at half steps from the full step between. While others need its value, a
//! field that is on its way has the mean of both ends.
//!
//! All other fields share the stabilised Runge-Kutta-Legendre scheme of second order. A step of `s` stages is stable while `dt * rate <= (s^2 + s - 2)/2`, `rate` being the fastest of the fields: its
//! length grows with the square of its cost (Meyer, Balsara and Aslam 2014, J. Comput. Phys. 257, 594-626, RKL2).
//! Two stages are the explicit method of second order with its usual limit. Every pass treats each number on its
//! own, and changes are added to the value at the start: what a law conserves stays to rounding.

use crate::body::Body;
use crate::conditions::Conditions;
use crate::engine::{Breaking, Engine, FieldRate, Need, State};
use crate::spec::Stepped;
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

/// The arrays that a step needs.
#[derive(Debug, Default)]
pub struct Relaxation {
    /// Field components that are stepped at once, at half and at full steps.
    half: Vec<Ahead>,
    alone: Vec<Ahead>,
    /// Positions in [`State::slots`] of those that share the stages.
    slots: Vec<usize>,
    start: Vec<Vec<f64>>,
    first: Vec<Vec<f64>>,
    older: Vec<Vec<f64>>,
}

/// A field component, and its value where it goes.
#[derive(Debug)]
struct Ahead {
    slot: usize,
    next: Vec<f64>,
}

impl Ahead {
    fn of(engine: &Engine, stepped: Stepped) -> Vec<Ahead> {
        let rates = engine.rates().filter(|r| r.stepped == stepped);
        let one = |r: FieldRate| Ahead {
            slot: r.slot,
            next: vec![0.0; engine.stored(r.slot)],
        };
        rates.map(one).collect()
    }

    /// The value at the end of a step of `dt`.
    fn step(&mut self, state: &State, rate: &FieldRate, dt: f64) {
        debug_assert_eq!(self.slot, rate.slot);
        let h = 0.5 * dt;
        let chunks = self.next.par_chunks_mut(CHUNK).enumerate();
        chunks.for_each(|(c, next)| {
            let first = c * CHUNK;
            rate.each(state, first..first + next.len(), |here, damping| {
                let (start, drive) = (
                    &state.slots[rate.slot][here.clone()],
                    &rate.drive[here.clone()],
                );
                let next = &mut next[here.start - first..here.end - first];
                let parts = next.iter_mut().zip(start.iter().zip(drive));
                match damping {
                    None => parts.for_each(|(next, (q, a))| *next = q + dt * a),
                    Some(damping) => {
                        for ((next, (q, a)), c) in parts.zip(damping) {
                            *next = ((1.0 - h * c) * q + dt * a) / (1.0 + h * c);
                        }
                    }
                }
            });
        });
    }

    fn swap(&mut self, state: &mut State) {
        std::mem::swap(&mut state.slots[self.slot], &mut self.next);
    }

    /// The state gets the mean of where the field is and where it goes.
    fn meet(&self, state: &mut State) {
        let values = state.slots[self.slot].par_chunks_mut(CHUNK);
        values
            .zip(self.next.par_chunks(CHUNK))
            .for_each(|(q, next)| {
                q.iter_mut()
                    .zip(next)
                    .for_each(|(q, next)| *q = 0.5 * (*q + next));
            });
    }
}

impl Relaxation {
    pub fn new(engine: &Engine) -> Relaxation {
        let together = engine.rates().filter(|r| r.stepped == Stepped::Together);
        let slots: Vec<usize> = together.map(|r| r.slot).collect();
        let zeros = || -> Vec<Vec<f64>> {
            let lengths = slots.iter().map(|k| engine.stored(*k));
            lengths.map(|n| vec![0.0; n]).collect()
        };
        Relaxation {
            half: Ahead::of(engine, Stepped::Half),
            alone: Ahead::of(engine, Stepped::Alone),
            start: zeros(),
            first: zeros(),
            older: zeros(),
            slots,
        }
    }

    pub fn bytes(&self) -> usize {
        let ahead = self.half.iter().chain(&self.alone).map(|a| &a.next);
        let stages = self.start.iter().chain(&self.first).chain(&self.older);
        8 * ahead.chain(stages).map(Vec::len).sum::<usize>()
    }

    /// Whether there are fields at half steps.
    pub fn has_half(&self) -> bool {
        !self.half.is_empty()
    }

    /// Whether fields share the stages.
    pub fn has_stages(&self) -> bool {
        !self.slots.is_empty()
    }

    /// Whether there are fields, and all of them are stepped at once.
    pub fn is_free(&self) -> bool {
        let ahead = self.half.iter().chain(&self.alone).count();
        ahead > 0 && !self.has_stages()
    }

    /// Fields at half steps, whose rates the engine has, go on by `dt` to time `middle`; the state gets their means.
    pub fn meet(
        &mut self,
        engine: &Engine,
        state: &mut State,
        (conditions, body): (&Conditions, &Body),
        middle: f64,
        dt: f64,
    ) {
        let rates = engine.rates().filter(|r| r.stepped == Stepped::Half);
        for (ahead, rate) in self.half.iter_mut().zip(rates) {
            ahead.step(state, &rate, dt);
        }
        self.half.iter_mut().for_each(|a| a.swap(state));
        conditions.impose_half_fields(body, middle, &mut state.slots);
        self.half.iter_mut().for_each(|a| a.swap(state));
        self.half.iter().for_each(|a| a.meet(state));
    }

    /// After [`Relaxation::meet`]: the state gets the values that the fields at half steps went to.
    pub fn part(&mut self, state: &mut State) {
        self.half.iter_mut().for_each(|a| a.swap(state));
    }

    /// Advances the fields at full steps from `state.time` by `dt`; everything else in the state stands still.
    /// Conditions on fields hold at every stage. `evaluated` says that the engine has the rates of this very state.
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
        if self.slots.is_empty() && self.alone.is_empty() {
            return true;
        }
        let mut evaluated = evaluated;
        if !self.alone.is_empty() {
            if !evaluated {
                engine.evaluate(state, Breaking::Held, Need::Rates);
            }
            let rates = engine.rates().filter(|r| r.stepped == Stepped::Alone);
            for (ahead, rate) in self.alone.iter_mut().zip(rates) {
                ahead.step(state, &rate, dt);
            }
            self.alone.iter().for_each(|a| a.meet(state));
            evaluated = false;
        }
        if self.has_stages() {
            self.stage(engine, state, act, dt, stages, evaluated);
        }
        self.alone.iter_mut().for_each(|a| a.swap(state));
        conditions.impose_fields(body, state.time + dt, &mut state.slots);
        self.finite(engine, state)
    }

    /// The fields that share the stages.
    fn stage(
        &mut self,
        engine: &mut Engine,
        state: &mut State,
        (conditions, body): (&Conditions, &Body),
        dt: f64,
        stages: u32,
        evaluated: bool,
    ) {
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
        let together = |r: &FieldRate| r.stepped == Stepped::Together;
        for (k, rate) in engine.rates().filter(together).enumerate() {
            let (slot, rate) = (rate.slot, rate.drive);
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
            for (k, rate) in engine.rates().filter(together).enumerate() {
                let (slot, rate) = (rate.slot, rate.drive);
                let arrays = (&self.start[k][..], &self.first[k][..], rate);
                weights.apply(&mut state.slots[slot], &mut self.older[k], arrays);
            }
            conditions.impose_fields(body, time + place(j) * dt, &mut state.slots);
        }
    }

    /// Padding may hold anything, but for what is stored on a part of the body.
    fn finite(&self, engine: &Engine, state: &State) -> bool {
        let sound = |values: &Vec<f64>| {
            if values.len() != engine.len() {
                let mut chunks = values.chunks(CHUNK);
                return chunks.all(|values| values.iter().sum::<f64>().is_finite());
            }
            let chunks = values
                .par_chunks(CHUNK)
                .zip(engine.volume().par_chunks(CHUNK));
            chunks.all(|(values, volume)| {
                let real = values.iter().zip(volume).filter(|(_, v)| **v > 0.0);
                real.map(|(x, _)| x).sum::<f64>().is_finite()
            })
        };
        let ahead = self.half.iter().chain(&self.alone).map(|a| &a.slot);
        let mut slots = self.slots.iter().chain(ahead);
        slots.all(|&slot| sound(&state.slots[slot]))
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
