//! A simulation: a body, a law, what acts on it, and the loop over time.

use crate::body::Body;
use crate::conditions::Condition;
use crate::contact::Indenter;
use crate::engine::{Engine, Law, Settings, State};
use crate::error::InputError;
use crate::observe::{Observer, Outputs, Row, Summary};
use crate::shape::{Shape, Surface};
use crate::spectrum::StableStep;
use std::path::PathBuf;

/// Everything a run needs. A scene file becomes one of these.
pub struct Setup {
    pub title: String,
    pub body: Body,
    pub law: Law,
    pub settings: Settings,
    /// Mass density [kg/m^3].
    pub density: f64,
    pub initial: Vec<Condition>,
    pub conditions: Vec<Condition>,
    pub cracks: Vec<Surface>,
    /// Bonds with an end in one of these never break.
    pub no_fail: Vec<Shape>,
    pub indenters: Vec<Indenter>,
    pub step: StepRule,
    pub end: End,
    pub outputs: Outputs,
}

/// How the time step is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepRule {
    /// `safety * 2 / omega_max` of the actual body.
    Stable { safety: f64 },
    /// As given [s].
    Fixed(f64),
}

impl Default for StepRule {
    fn default() -> StepRule {
        StepRule::Stable { safety: 0.8 }
    }
}

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
    pub engine: Engine,
    pub state: State,
    pub density: f64,
    pub indenters: Vec<Indenter>,
    /// [s]
    pub dt: f64,
    /// How `dt` was found; `None` when the user gave it.
    pub stable: Option<StableStep>,
    /// Number of the last step.
    pub steps: u64,
    pub outputs: Outputs,
    /// The last row of the history.
    pub row: Row,
    /// Identifies body, law and conditions; a checkpoint of another fingerprint is refused.
    pub fingerprint: u64,
}

/// A run that could not go on.
#[derive(Clone, Debug, PartialEq)]
pub struct Stopped {
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
            Some(path) => write!(f, "; checkpoint: {}", path.display()),
            None => write!(f, "; no checkpoint was written"),
        }
    }
}

impl std::error::Error for Stopped {}

impl Simulation {
    /// Builds the engine, cuts the cracks, sets the initial values and finds the time step.
    pub fn new(setup: Setup) -> Result<Simulation, InputError> {
        let _ = setup;
        Err(InputError::new("simulation", ""))
    }

    /// Goes on from a checkpoint of the same scene; see [`crate::checkpoint`].
    pub fn resume(&mut self, path: &std::path::Path) -> Result<(), InputError> {
        let _ = path;
        Err(InputError::new("simulation", ""))
    }

    /// Runs to the end.
    pub fn run(&mut self, observer: &mut dyn Observer) -> Result<Summary, Stopped> {
        let _ = observer;
        Err(Stopped {
            step: 0,
            time: 0.0,
            node: None,
            reason: String::new(),
            checkpoint: None,
        })
    }
}
