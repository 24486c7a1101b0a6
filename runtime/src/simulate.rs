//! A simulation: a body, a law, and what acts on it. The loop over time is in [`crate::run`].

mod setup;

use setup::{check, contact, cut, damped, fingerprint, layout, no_fail, strayed};

use crate::body::Body;
use crate::checkpoint::{self, Clock, Identity, Snapshot};
use crate::conditions::{Condition, Conditions, set_initial};
use crate::contact::{Contact, Indenter};
use crate::density::Density;
use crate::engine::{Breaking, Engine, Law, Precision, Settings, SetupError, State};
use crate::error::{About, InputError};
use crate::matching::{self, Face, Matching};
use crate::observe::{Outputs, Row, Schedule, Timings, split};
use crate::relax::{self, Relaxation};
use crate::run::Watch;
use crate::shape::{Shape, Surface};
use crate::spec::Spec;
use crate::spectrum::{StableStep, stable_step};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Everything a run needs. A scene file becomes one of these.
pub struct Setup {
    pub title: String,
    pub body: Body,
    pub law: Law,
    pub settings: Settings,
    /// Mass density [kg/m^3]; a law without a force has no use for it.
    pub density: Vec<f64>,
    pub initial: Vec<Condition>,
    pub conditions: Vec<Condition>,
    pub cracks: Vec<Surface>,
    /// Bonds with an end in one of these never break.
    pub no_fail: Vec<Shape>,
    pub indenters: Vec<Indenter>,
    /// Sides that let waves out.
    pub matching: Vec<Matching>,
    pub step: StepRule,
    pub end: End,
    pub outputs: Outputs,
}

/// How the time step is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepRule {
    /// `safety` times the limit of the actual body, cracks cut and initial values set: [`stable_step`].
    ///
    /// Broken bonds of a law whose forces are not pairwise may stiffen what is left, so for such a law the step is
    /// found again whenever another [`REMEASURE`] of all bonds has broken; it may shrink, never grow.
    Stable { safety: f64 },
    /// As given [s].
    Fixed(f64),
}

impl Default for StepRule {
    fn default() -> StepRule {
        StepRule::Stable { safety: 0.8 }
    }
}

/// Share of bonds that break before the stable step is found anew.
pub const REMEASURE: f64 = 0.02;

/// When a run is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// 0 evaluates the forces once.
    Steps(u64),
    /// [s]; a chosen step is shortened so that the last one ends here.
    Time(f64),
}

/// A simulation at a moment of its run. Observers read it.
pub struct Simulation {
    pub title: String,
    pub body: Body,
    pub spec: Spec,
    pub engine: Engine,
    pub state: State,
    pub density: Density,
    /// The smallest and the largest horizon [m].
    pub horizon: f64,
    pub reach: f64,
    pub indenters: Vec<Indenter>,
    /// Matching boundaries, in the order in which they are stepped.
    pub faces: Vec<Face>,
    /// Nodes whose bonds never break, where bonds of others may.
    pub held: usize,
    /// [s]; 0 when the forces are evaluated only once.
    pub dt: f64,
    /// How `dt` was found; `None` when the user gave it.
    pub stable: Option<StableStep>,
    /// Stages of the fields in a step; 0 without fields.
    pub stages: u32,
    pub rule: StepRule,
    pub end: End,
    /// Number of the last step.
    pub steps: u64,
    pub outputs: Outputs,
    /// Whether neighbours near the rim count in part, and the weights that are 1.
    pub partial_volume: bool,
    pub without: Vec<String>,
    /// What the scene allows.
    pub precision: Precision,
    /// The last row of the history.
    pub row: Row,
    pub timings: Timings,
    /// Tells body, law and conditions from others; a checkpoint of other ones is refused.
    pub identity: Identity,
    pub(crate) conditions: Conditions,
    pub(crate) contact: Contact,
    pub(crate) clock: Clock,
    pub(crate) relaxation: Relaxation,
    /// Directed bonds of the reference families, and those broken since the start.
    pub(crate) bonds: u64,
    pub(crate) broken: u64,
    pub(crate) broken_at_measure: u64,
    /// [J]
    pub(crate) initial_energy: f64,
    pub(crate) watch: Watch,
    pub(crate) evaluations: u64,
    pub(crate) last_checkpoint: Option<PathBuf>,
    /// Set it, from any thread, and the run stops at the end of its step with a checkpoint.
    pub interrupt: Arc<AtomicBool>,
}

/// A run that could not go on, or was not to.
#[derive(Clone, Debug, PartialEq)]
pub struct Stopped {
    /// Whether it was asked to stop; otherwise something is wrong.
    pub interrupted: bool,
    pub step: u64,
    /// [s]
    pub time: f64,
    /// User number and reference position [m] of the node where it shows.
    pub node: Option<(usize, [f64; 3])>,
    pub reason: String,
    pub checkpoint: Option<PathBuf>,
}

impl std::fmt::Display for Stopped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "stopped at step {} (t = {:.6e} s): {}",
            self.step, self.time, self.reason
        )?;
        if let Some((node, x)) = self.node {
            write!(
                f,
                "; node {node} at ({:.6e}, {:.6e}, {:.6e}) m",
                x[0], x[1], x[2]
            )?;
        }
        match &self.checkpoint {
            Some(path) => write!(f, "; last checkpoint: {}", path.display()),
            None => write!(f, "; there is no checkpoint"),
        }
    }
}

impl std::error::Error for Stopped {}

impl Simulation {
    /// Builds the engine, cuts the cracks, sets the initial values and finds the time step.
    ///
    /// Errors: any input that cannot be computed, with a remedy.
    pub fn new(setup: Setup) -> Result<Simulation, InputError> {
        let began = Instant::now();
        check(&setup)?;
        let spec = setup.law.spec.clone();
        let scene = fingerprint(&setup, &spec)?;
        let faces = matching::faces(
            &setup.matching,
            &setup.body,
            &setup.law,
            &setup.settings,
            &setup.density,
        )?;
        let no_fail = no_fail(&setup, &faces)?;
        let partial_volume = setup.settings.partial_volume;
        let without = setup.settings.without.clone();
        let precision = setup.settings.precision;
        let mut engine =
            Engine::new(&setup.body, setup.law, setup.settings).map_err(|e| match e {
                SetupError::Traversal(what, remedy) => {
                    InputError::new(what, remedy).about(About::Traversal)
                }
                SetupError::Precision(what, remedy) => {
                    InputError::new(what, remedy).about(About::Precision)
                }
                e => InputError::new(e.to_string(), ""),
            })?;
        if !no_fail.is_empty() {
            engine.no_fail(&no_fail);
        }
        let mut state = engine.state();
        cut(&engine, &mut state, &setup.cracks, &setup.body);
        set_initial(&setup.initial, &setup.body, &engine, &mut state)?;
        engine
            .settle(&mut state)
            .map_err(|s| strayed(&s, &setup.body, &setup.initial))?;
        let conditions = Conditions::new(&setup.conditions, &faces, &setup.body, &engine, &state)?;
        conditions.start(&setup.body, &mut state);
        let lists = (&setup.initial[..], &setup.conditions[..]);
        damped(lists, &setup.body, &engine, &state)?;
        let contact = contact(
            &setup.indenters,
            &conditions,
            setup.body.flavour.dim(),
            engine.len(),
        );
        let horizons = &engine.grading().horizons;
        let end = |h: Option<&f64>| h.copied().unwrap_or(0.0);
        let (horizon, reach) = (end(horizons.first()), end(horizons.last()));
        let identity = Identity {
            scene,
            layout: layout(&engine),
        };
        let bonds = engine.report().bonds as u64;
        let relaxation = Relaxation::new(&engine);
        let density = Density::new(&setup.density, &setup.body, &engine);
        let mut simulation = Simulation {
            title: setup.title,
            body: setup.body,
            spec,
            engine,
            state,
            density,
            horizon,
            reach,
            indenters: setup.indenters,
            faces,
            held: no_fail.iter().filter(|held| **held).count(),
            dt: 0.0,
            stable: None,
            stages: 0,
            rule: setup.step,
            end: setup.end,
            steps: 0,
            outputs: setup.outputs,
            partial_volume,
            precision,
            without,
            row: Row::default(),
            timings: Timings::default(),
            identity,
            conditions,
            contact,
            clock: Clock::default(),
            relaxation,
            bonds,
            broken: 0,
            broken_at_measure: 0,
            initial_energy: 0.0,
            watch: Watch::default(),
            evaluations: 0,
            last_checkpoint: None,
            interrupt: Arc::default(),
        };
        crate::observe::check(&simulation)?;
        simulation.timings.setup = began.elapsed().as_secs_f64();
        simulation.choose_step()?;
        simulation.engine.sleep(true);
        Ok(simulation)
    }

    /// Goes on from a checkpoint of the same scene. The step stays that of the checkpoint, unless the scene gives one.
    pub fn resume(&mut self, path: &Path) -> Result<(), InputError> {
        let saved = checkpoint::read(path, self.identity)?;
        if !self.engine.fits(&saved.state) {
            return Err(InputError::new(
                "the checkpoint holds a state of another shape",
                "use the scene that wrote it",
            ));
        }
        self.clock = saved.clock;
        self.stages = saved.stages;
        self.state = saved.state;
        self.broken = saved.broken;
        self.broken_at_measure = saved.broken_at_measure;
        self.initial_energy = saved.initial_energy;
        self.conditions.work = saved.work;
        self.conditions.left = saved.left;
        self.contact.restore(&saved.reactions);
        self.last_checkpoint = Some(path.to_path_buf());
        match self.rule {
            StepRule::Fixed(dt) if dt != saved.clock.dt => {
                self.set_step(dt);
                self.engine.forces(&mut self.state, Breaking::Held);
                let rate = self.measure(1.0).rate;
                self.set_stages(rate)?;
            }
            StepRule::Fixed(_) => self.dt = saved.clock.dt,
            StepRule::Stable { .. } => (self.dt, self.stable) = (saved.clock.dt, saved.stable),
        }
        self.steps = self.last_step();
        Ok(())
    }

    /// What this simulation does not need and therefore does not compute.
    pub fn left_out(&self) -> Vec<String> {
        crate::observe::left_out(self)
    }

    /// What a checkpoint holds; meaningful in the middle of a step only, which is when observers are asked for one.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            state: self.state.clone(),
            clock: self.clock,
            stable: self.stable.clone(),
            stages: self.stages,
            broken: self.broken,
            broken_at_measure: self.broken_at_measure,
            initial_energy: self.initial_energy,
            work: self.conditions.work,
            left: self.conditions.left,
            reactions: self.contact.reactions(),
        }
    }

    /// Memory beside that of the engine and its state: the body as it was given, densities, loads, and what fields need
    /// while they are stepped.
    pub fn other_bytes(&self) -> usize {
        let body = &self.body;
        let grid = body.grid.as_ref().map_or(0, |g| 12 * g.cell.len());
        let densities = self.density.slots().map_or(0, <[f64]>::len);
        24 * body.x.len()
            + 8 * (body.volume.len() + body.horizon.len() + densities)
            + body.material.len()
            + grid
            + self.conditions.loads.bytes()
            + self.contact.loads.bytes()
            + self.relaxation.bytes()
    }

    fn choose_step(&mut self) -> Result<(), InputError> {
        if self.end == End::Steps(0) || self.end == End::Time(0.0) {
            return Ok(());
        }
        let mut rate = 0.0;
        let dt = match self.rule {
            StepRule::Fixed(dt) => {
                if !self.spec.rates.is_empty() {
                    self.engine.forces(&mut self.state, Breaking::Held);
                    rate = self.measure(1.0).rate;
                }
                dt
            }
            StepRule::Stable { safety } => {
                self.engine.forces(&mut self.state, Breaking::Held);
                let stable = self.measure(safety);
                rate = stable.rate;
                let dt = stable.dt;
                self.stable = Some(stable);
                dt
            }
        };
        if !dt.is_finite() {
            return Err(match self.relaxation.is_free() {
                true => InputError::new(
                    "the fields of the law bear any time step, so that none follows from the body",
                    "give the time step",
                ),
                false => InputError::new(
                    "nothing in the body moves or flows, so that no step follows from it",
                    "give the time step, or a horizon that reaches the neighbours",
                ),
            });
        }
        let dt = match self.rule {
            StepRule::Stable { .. } => self.fitted(dt),
            StepRule::Fixed(_) => dt,
        };
        self.set_step(dt);
        self.set_stages(rate)?;
        self.steps = self.last_step();
        Ok(())
    }

    /// The largest step up to `dt` of which a whole number leads from here to the end.
    pub(crate) fn fitted(&self, dt: f64) -> f64 {
        match self.end {
            End::Steps(_) => dt,
            End::Time(end) => {
                let rest = end - self.state.time;
                rest / (rest / dt - 1e-9).ceil().max(1.0)
            }
        }
    }

    /// Whether the law moves and has fields with rates.
    pub(crate) fn is_coupled(&self) -> bool {
        !self.spec.force.is_empty() && !self.spec.rates.is_empty()
    }

    /// Stages of the fields for the present step, from their fastest rate [1/s].
    pub(crate) fn set_stages(&mut self, rate: f64) -> Result<(), InputError> {
        if !self.relaxation.has_stages() {
            return Ok(());
        }
        self.stages = relax::stages(self.dt, rate);
        if self.stages <= relax::MOST {
            return Ok(());
        }
        let most = 0.9 * relax::reach(relax::MOST) / rate;
        Err(InputError::new(
            format!(
                "a time step of {:e} s is too long for the fields, whose fastest rate is {rate:.3e} 1/s",
                self.dt
            ),
            format!("give a step of at most {most:.2e} s, or none: a stable one is then found"),
        ))
    }

    /// The largest stable step of what moves at the present state [s]; infinite where nothing does: fields take as many
    /// stages as a step needs.
    pub fn limit(&mut self) -> f64 {
        self.engine.forces(&mut self.state, Breaking::Held);
        let omega = self.measure(1.0).omega;
        if omega > 0.0 {
            2.0 / omega
        } else {
            f64::INFINITY
        }
    }

    /// The stable step of the present state, where forces have just been evaluated.
    pub(crate) fn measure(&mut self, safety: f64) -> StableStep {
        let began = Instant::now();
        // Inside a sphere a node deeper than the horizon has left its family: contact has failed before.
        let bound = |i: &Indenter| i.stiffness_bound(self.reach, self.density.least());
        let contact = self.indenters.iter().map(bound).sum();
        // What is asked of the engine here is no motion of the body.
        let sleeps = self.engine.sleeps();
        self.engine.sleep(false);
        let stable = stable_step(
            &mut self.engine,
            &self.spec,
            &self.state,
            &self.density,
            contact,
            safety,
        );
        self.engine.sleep(sleeps);
        self.timings.stable_step += began.elapsed().as_secs_f64();
        stable
    }

    /// From the present step on, time advances by `dt`.
    pub(crate) fn set_step(&mut self, dt: f64) {
        self.clock = Clock {
            base_step: self.state.step,
            base_time: self.state.time,
            dt,
        };
        self.dt = dt;
        self.state.dt = dt;
    }

    /// Leaves out the named quantities of the law that no file or picture of [`Simulation::outputs`] is to show. For who
    /// does not ask for others: [`crate::observe::quantity`] refuses them from then on.
    pub fn keep_outputs(&mut self) {
        let o = &self.outputs;
        let fields = o.quantities.iter();
        let fields = fields.filter(|_| o.fields != Schedule::Never);
        let views = o.views.iter().map(|v| &v.quantity);
        let shown = fields.chain(views.filter(|_| o.pictures != Schedule::Never));
        let shown: Vec<&str> = shown.map(|name| split(name).0).collect();
        self.engine.keep_named(&|name| shown.contains(&name));
    }

    pub(crate) fn last_step(&self) -> u64 {
        match self.end {
            End::Steps(n) => n,
            End::Time(_) if self.dt <= 0.0 => 0,
            End::Time(end) => {
                let rest = (end - self.clock.base_time) / self.dt;
                self.clock.base_step + (rest - 1e-6).ceil().max(0.0) as u64
            }
        }
    }
}
