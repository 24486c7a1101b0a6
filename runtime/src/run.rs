//! The loop over time.
//!
//! Between two steps the nodes have moved and the forces wait: that is where checkpoints are taken. A step is
//! *accepted* when its forces are known and its velocities complete; then rows, fields and pictures are written.
//!
//! Where a law moves and has fields, a step is the symmetric product `kick/2, drift/2, fields, drift/2, kick/2`: the
//! fields see positions and velocities of the middle of the step, the force sees fields of its end. Every part is of
//! second order, and so is the whole.

use crate::conditions::Balance;
use crate::contact::Target;
use crate::density::Density;
use crate::engine::{Breaking, Need};
use crate::integrate::{drift, kick, kick_and_drift};
use crate::observe::{Observer, Summary};
use crate::simulate::{REMEASURE, Simulation, StepRule, Stopped};
use std::sync::atomic::Ordering;
use std::time::Instant;

/// A run counts as unstable when its energy exceeds what was put in by this factor in [`STRIKES`] rows of the history
/// one after the other. One row may mislead: where a force sets in, kinetic energy is ahead of work by half a step.
pub const ENERGY_FACTOR: f64 = 2.0;
pub const STRIKES: u32 = 3;

/// Keeps the account of [`ENERGY_FACTOR`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Watch {
    /// Works as last seen [J].
    seen: [f64; 3],
    /// Sum of the magnitudes of their changes [J].
    effort: f64,
    strikes: u32,
}

impl Watch {
    fn look(&mut self, energy: f64, initial: f64, put_in: [f64; 3]) {
        self.effort += put_in
            .iter()
            .zip(&self.seen)
            .map(|(now, before)| (now - before).abs())
            .sum::<f64>();
        self.seen = put_in;
        let bound = ENERGY_FACTOR * (initial + self.effort);
        self.strikes = if bound > 0.0 && energy > bound {
            self.strikes + 1
        } else {
            0
        };
    }
}

impl Simulation {
    /// Runs to the end.
    ///
    /// Errors: the run went unstable (a number that is not finite, a node that moved by more than the horizon in one
    /// step, energy beyond [`ENERGY_FACTOR`] times all energy put in), an observer could not write, or the run was
    /// asked to stop: then there is a checkpoint of the step that was reached.
    pub fn run(&mut self, observer: &mut dyn Observer) -> Result<Summary, Stopped> {
        let before = self.timings.setup + self.timings.stable_step;
        let began = Instant::now();
        let outcome = self.go(observer);
        self.timings.total = before + lap(began);
        let stopped = match outcome {
            Ok(()) => {
                let summary = Summary::of(self, None);
                match observer.finish(self, &summary) {
                    Ok(()) => return Ok(summary),
                    Err(why) => self.stopped(None, why),
                }
            }
            Err(stopped) => stopped,
        };
        let summary = Summary::of(self, Some(&stopped));
        observer.stopped(self, &stopped, &summary);
        Err(stopped)
    }

    fn go(&mut self, observer: &mut dyn Observer) -> Result<(), Stopped> {
        observer.start(self).map_err(|e| self.stopped(None, e))?;
        if self.state.step == 0 {
            self.conditions
                .impose_velocities(&self.body, &mut self.state, self.dt);
            self.save(observer)?;
        }
        loop {
            self.accept(observer)?;
            observer.step(self);
            let doubt = self.doubt();
            self.broken += self.engine.commit(&mut self.state) as u64;
            if !self.spec.after_step.is_empty() {
                self.conditions.hold_matched(&mut self.state);
                self.conditions
                    .impose_velocities(&self.body, &mut self.state, self.dt);
            }
            if self.state.step >= self.steps {
                return doubt.map_or(Ok(()), |why| Err(self.stopped(Some(self.fastest()), why)));
            }
            self.remeasure(observer)?;
            self.advance(observer)?;
            if let Some(why) = doubt {
                return Err(self.unstable(observer, why));
            }
            self.save(observer)?;
            if self.interrupt.load(Ordering::Relaxed) {
                return Err(self.interrupted(observer));
            }
        }
    }

    /// Evaluates forces at the present positions and completes the velocities.
    fn accept(&mut self, observer: &mut dyn Observer) -> Result<(), Stopped> {
        let began = Instant::now();
        let need = if self.is_coupled() {
            Need::Motion
        } else {
            Need::All
        };
        self.broken += match self.relaxation.has_half() {
            false => self.engine.evaluate(&mut self.state, Breaking::Armed, need),
            true => self.meet_half_fields(),
        } as u64;
        self.evaluations += 1;
        self.timings.forces += lap(began);
        let first = self.state.step == 0;
        self.press(first);
        let began = Instant::now();
        self.conditions.load(&self.body, self.state.time);
        if !first && !self.spec.force.is_empty() {
            self.complete();
        }
        self.timings.integration += lap(began);
        self.write(observer)
    }

    /// Evaluates in two parts: fields at half steps go on from the middle of the last step to that of the next, and
    /// the force sees the mean. Returns the directed bonds that broke.
    fn meet_half_fields(&mut self) -> usize {
        let (engine, state) = (&mut self.engine, &mut self.state);
        let broken = engine.evaluate(state, Breaking::Armed, Need::Half);
        // The first way is from the start to the middle of the first step.
        let dt = if state.step == 0 { 0.5 } else { 1.0 } * self.dt;
        let act = (&self.conditions, &self.body);
        let middle = state.time + 0.5 * self.dt;
        self.relaxation.meet(engine, state, act, middle, dt);
        broken + engine.evaluate(state, Breaking::Armed, Need::Rest)
    }

    /// Contact forces at the present positions.
    fn press(&mut self, first: bool) {
        let began = Instant::now();
        let target = target(&self.body, &self.engine, &self.density, self.dt);
        self.contact.press(&self.state, &target, first);
        self.timings.contact += lap(began);
    }

    /// The second half of the kick.
    fn complete(&mut self) {
        let half = 0.5 * self.dt;
        let balance = balance(
            &self.body,
            &self.engine,
            &self.contact.loads,
            &self.density,
            self.dt,
        );
        self.conditions.account(&self.state, &balance);
        self.conditions.before_kick(&self.state, self.dt);
        kick(&mut self.state.v, balance.force, &self.density, half);
        self.conditions
            .loads
            .kick(&mut self.state.v, &self.density, half);
        balance.contact.kick(&mut self.state.v, &self.density, half);
        self.conditions.after_kick(&mut self.state, &balance);
    }

    /// The step from one accepted state to where the next is evaluated.
    fn advance(&mut self, observer: &mut dyn Observer) -> Result<(), Stopped> {
        self.relaxation.part(&mut self.state);
        let moved = match self.spec.force.is_empty() {
            false => self.travel(),
            true => self.flow(),
        };
        match moved {
            Some(moved) if moved <= self.horizon => Ok(()),
            _ => {
                let why = self.motion_fault();
                Err(self.unstable(observer, why))
            }
        }
    }

    /// The fields of a law without motion. `None` when a value is not finite.
    fn flow(&mut self) -> Option<f64> {
        // What a commit or a breaking bond changes was not yet so when the rates were evaluated.
        let fresh =
            self.spec.histories.is_empty() && !self.spec.breaks && !self.relaxation.has_half();
        let sound = self.relax(fresh);
        self.state.step += 1;
        self.state.time = self.clock.time(self.state.step);
        let (time, slots) = (self.state.time, &mut self.state.slots);
        self.conditions.impose_fields(&self.body, time, slots);
        sound.then_some(0.0)
    }

    /// The fields over a step from `state.time`. `evaluated`: the engine has their rates.
    fn relax(&mut self, evaluated: bool) -> bool {
        let began = Instant::now();
        let act = (&self.conditions, &self.body);
        let sound = self.relaxation.step(
            &mut self.engine,
            &mut self.state,
            act,
            self.dt,
            self.stages,
            evaluated,
        );
        self.timings.fields += lap(began);
        sound
    }

    /// First half of the kick, drift with the fields in its middle, imposed motion, contact by relocation. Returns
    /// the largest motion [m], `None` when a field is not finite.
    fn travel(&mut self) -> Option<f64> {
        let began = Instant::now();
        let half = 0.5 * self.dt;
        let balance = balance(
            &self.body,
            &self.engine,
            &self.contact.loads,
            &self.density,
            self.dt,
        );
        self.conditions.before_drift(&self.state, &balance);
        self.conditions
            .loads
            .kick(&mut self.state.v, &self.density, half);
        balance.contact.kick(&mut self.state.v, &self.density, half);
        let mut sound = true;
        let moved = if self.is_coupled() {
            kick(&mut self.state.v, balance.force, &self.density, half);
            self.conditions.steer(&mut self.state, &balance);
            let one = drift(&mut self.state.u, &self.state.v, 0.5 * self.dt);
            let before = self.timings.fields;
            sound = self.relax(false);
            self.timings.integration -= self.timings.fields - before;
            one + drift(&mut self.state.u, &self.state.v, 0.5 * self.dt)
        } else {
            kick_and_drift(
                &mut self.state.u,
                &mut self.state.v,
                balance.force,
                &self.density,
                self.dt,
            )
        };
        self.state.step += 1;
        self.state.time = self.clock.time(self.state.step);
        let balance = crate::run::balance(
            &self.body,
            &self.engine,
            &self.contact.loads,
            &self.density,
            self.dt,
        );
        let imposed = self.conditions.after_drift(&mut self.state, &balance);
        self.timings.integration += lap(began);
        let began = Instant::now();
        let target = target(&self.body, &self.engine, &self.density, self.dt);
        self.contact
            .after_drift(&mut self.state, &target, moved.max(imposed));
        self.timings.contact += lap(began);
        let largest = if moved <= imposed { imposed } else { moved };
        sound.then_some(largest)
    }

    /// For laws that may stiffen when bonds break: a new step, or other stages of the fields, after a share of the
    /// bonds has gone.
    fn remeasure(&mut self, observer: &mut dyn Observer) -> Result<(), Stopped> {
        let safety = match self.rule {
            StepRule::Stable { safety } => safety,
            StepRule::Fixed(_) if self.spec.rates.is_empty() => return Ok(()),
            StepRule::Fixed(_) => 1.0,
        };
        let enough = REMEASURE * self.bonds as f64;
        if !self.spec.breaks
            || (self.spec.pairwise && self.spec.rates.is_empty())
            || ((self.broken - self.broken_at_measure) as f64) < enough
        {
            return Ok(());
        }
        self.broken_at_measure = self.broken;
        let stable = self.measure(safety);
        let rate = stable.rate;
        if self.stable.is_some() && stable.dt < self.dt {
            self.set_step(self.fitted(stable.dt));
            self.stable = Some(stable);
            self.steps = self.last_step();
        }
        self.set_stages(rate)
            .map_err(|why| self.unstable(observer, why.to_string()))
    }

    /// Rows, fields and pictures that are due at the accepted step.
    fn write(&mut self, observer: &mut dyn Observer) -> Result<(), Stopped> {
        let (step, end) = (self.state.step, self.state.step >= self.steps);
        let due = |s: &crate::observe::Schedule| s.due(step, self.state.time, self.dt, end);
        let (row, fields, pictures) = (
            due(&self.outputs.history),
            due(&self.outputs.fields),
            due(&self.outputs.pictures),
        );
        if row || step == 0 || end {
            let began = Instant::now();
            self.take_row();
            self.timings.energy += lap(began);
        }
        let began = Instant::now();
        let mut result = Ok(());
        if row {
            let row = self.row.clone();
            result = observer.row(self, &row);
        }
        if fields && result.is_ok() {
            result = observer.fields(self);
        }
        if pictures && result.is_ok() {
            result = observer.pictures(self);
        }
        self.timings.output += lap(began);
        result.map_err(|why| self.stopped(None, why))
    }

    fn save(&mut self, observer: &mut dyn Observer) -> Result<(), Stopped> {
        let end = self.state.step >= self.steps;
        if self
            .outputs
            .checkpoints
            .due(self.state.step, self.state.time, self.dt, end)
        {
            let began = Instant::now();
            let path = observer
                .checkpoint(self)
                .map_err(|why| self.stopped(None, why))?;
            self.last_checkpoint = path.or(self.last_checkpoint.take());
            self.timings.output += lap(began);
        }
        Ok(())
    }

    fn take_row(&mut self) {
        let mut row = crate::observe::Row::of(self);
        let energy = row.energy();
        if self.state.step == 0 {
            self.initial_energy = energy;
        }
        if self.spec.energy.is_some() && self.spec.rates.is_empty() {
            row.lost =
                self.initial_energy + row.work_conditions + row.work_contact - row.left - energy;
        }
        let put_in = [row.work_conditions, row.work_contact, self.contact.drive()];
        self.watch.look(energy, self.initial_energy, put_in);
        self.row = row;
    }

    /// Whether the last rows show energy from nowhere; only where the law has an energy and nothing else feeds it.
    fn doubt(&self) -> Option<String> {
        let energy = self.row.energy();
        let known = self.spec.energy.is_some()
            && self.spec.rates.is_empty()
            && self.spec.histories.is_empty();
        let grown = known && self.watch.strikes >= STRIKES;
        (self.row.step == self.state.step && (grown || !energy.is_finite())).then(|| {
            let put_in = self.initial_energy + self.watch.effort;
            let why = if self.row.left < 0.0 {
                "waves grow at the matching boundaries, or the step is too large"
            } else {
                "the step is too large"
            };
            format!("the energy is {energy:.3e} J, of which only {put_in:.3e} J were put in: {why}")
        })
    }

    fn motion_fault(&self) -> String {
        let s = self.engine.slots()[self.fastest()] as usize;
        let moved = self
            .state
            .v
            .iter()
            .map(|v| (v[s] * self.dt).powi(2))
            .sum::<f64>()
            .sqrt();
        if moved.is_finite() && moved > self.horizon {
            format!(
                "a node moved by {moved:.3e} m in one step, more than the horizon of {:.3e} m",
                self.horizon
            )
        } else {
            "a value is not finite any more".to_string()
        }
    }

    fn unstable(&mut self, observer: &mut dyn Observer, reason: String) -> Stopped {
        let mut stopped = self.stopped(Some(self.fastest()), reason);
        stopped.checkpoint = self.rescue(observer);
        stopped
    }

    /// Stops here, as was asked for.
    fn interrupted(&self, observer: &mut dyn Observer) -> Stopped {
        let mut stopped = self.stopped(None, "interrupted".into());
        match observer.checkpoint(self) {
            Ok(path) => stopped.checkpoint = path.or(stopped.checkpoint),
            Err(why) => stopped.reason = format!("interrupted, and {why}"),
        }
        Stopped {
            interrupted: true,
            ..stopped
        }
    }

    /// A last checkpoint where all numbers are still finite; else the one before.
    fn rescue(&mut self, observer: &mut dyn Observer) -> Option<std::path::PathBuf> {
        let finite = self
            .state
            .u
            .iter()
            .chain(&self.state.v)
            .chain(&self.state.slots)
            .flatten()
            .all(|x| x.is_finite());
        let written = if finite {
            observer.checkpoint(self).ok().flatten()
        } else {
            None
        };
        written.or(self.last_checkpoint.clone())
    }

    /// User number of the node that is not finite, or else the fastest.
    fn fastest(&self) -> usize {
        let speed = |node: usize| {
            let s = self.engine.slots()[node] as usize;
            let v: f64 = self.state.v.iter().map(|v| v[s] * v[s]).sum();
            let slots = 0..self.state.slots.len();
            let other: f64 = slots.map(|k| self.engine.value(&self.state, k, s)).sum();
            if v.is_nan() || !other.is_finite() {
                f64::INFINITY
            } else {
                v
            }
        };
        let mut worst = (0, f64::NEG_INFINITY);
        for node in 0..self.body.x.len() {
            let v = speed(node);
            if v > worst.1 {
                worst = (node, v);
            }
        }
        worst.0
    }

    fn stopped(&self, node: Option<usize>, reason: String) -> Stopped {
        Stopped {
            interrupted: false,
            step: self.state.step,
            time: self.state.time,
            node: node.map(|n| (n, self.body.x[n])),
            reason,
            checkpoint: self.last_checkpoint.clone(),
        }
    }
}

fn target<'a>(
    body: &'a crate::body::Body,
    engine: &'a crate::engine::Engine,
    density: &'a Density,
    dt: f64,
) -> Target<'a> {
    Target {
        body,
        slots: engine.slots(),
        force: engine.force(),
        volume: engine.volume(),
        density,
        dt,
    }
}

fn balance<'a>(
    body: &'a crate::body::Body,
    engine: &'a crate::engine::Engine,
    contact: &'a crate::conditions::Loads,
    density: &'a Density,
    dt: f64,
) -> Balance<'a> {
    Balance {
        body,
        force: engine.force(),
        contact,
        volume: engine.volume(),
        density,
        dt,
    }
}

fn lap(began: Instant) -> f64 {
    began.elapsed().as_secs_f64()
}

#[cfg(test)]
#[path = "run_tests.rs"]
pub(crate) mod tests;
