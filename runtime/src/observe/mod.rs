//! What a run leaves behind: histories, fields, pictures, checkpoints, a summary.

use crate::shape::Shape;
use crate::simulate::{Simulation, Stopped};
use std::path::PathBuf;

mod row;
mod summary;
pub use row::Row;
pub use summary::{Summary, Timings};

/// When something is written. Whatever is not `Never` is also written at the start and at the end.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Schedule {
    #[default]
    Never,
    /// At the start and at the end only.
    Ends,
    Steps(u64),
    /// Every so many seconds of simulated time.
    Period(f64),
    /// At these times [s] (the first step at or after each).
    Times(Vec<f64>),
}

/// What a run writes and when.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    pub history: Schedule,
    pub fields: Schedule,
    /// Names: `displacement`, `velocity`, `force`, `damage`, `energy`, `position`, `volume`, a field of the
    /// law, or a named node quantity of the law.
    pub quantities: Vec<String>,
    pub pictures: Schedule,
    pub views: Vec<Picture>,
    pub checkpoints: Schedule,
}

/// A picture of one quantity along an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// First part of the file name.
    pub name: String,
    /// A name as in [`Outputs::quantities`]; vectors show their magnitude, or a component: `velocity.z`.
    pub quantity: String,
    pub view: View,
    /// Ends of the colour scale; `None` takes the smallest and largest value (damage: 0 to 1).
    pub range: Option<(f64, f64)>,
    /// Width of the drawing [pixels].
    pub width: u32,
    /// Nodes at their present positions instead of the reference ones.
    pub deformed: bool,
    /// Shows only these nodes: a slice.
    pub region: Option<Shape>,
}

/// Direction of view. The node nearest to the eye wins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// From +z down: x to the right, y up.
    #[default]
    Top,
    /// From -z up.
    Bottom,
    /// From -y: x to the right, z up.
    Front,
    /// From +x: y to the right, z up.
    Side,
    /// From +y down: x to the right, z down; the top view of a body whose axis is y.
    Above,
}

/// Watches a run. Every method may stay as it is.
pub trait Observer {
    /// Before the first step (after a resume: `sim.state.step` > 0).
    fn start(&mut self, _sim: &mut Simulation) -> Result<(), String> {
        Ok(())
    }
    /// After every step; keep it cheap.
    fn step(&mut self, _sim: &Simulation) {}
    /// When a row of the history is due.
    fn row(&mut self, _sim: &Simulation, _row: &Row) -> Result<(), String> {
        Ok(())
    }
    /// When fields are due.
    fn fields(&mut self, _sim: &mut Simulation) -> Result<(), String> {
        Ok(())
    }
    /// When pictures are due.
    fn pictures(&mut self, _sim: &mut Simulation) -> Result<(), String> {
        Ok(())
    }
    /// When a checkpoint is due; returns where it went.
    fn checkpoint(&mut self, _sim: &Simulation) -> Result<Option<PathBuf>, String> {
        Ok(None)
    }
    /// At the end.
    fn finish(&mut self, _sim: &Simulation, _summary: &Summary) -> Result<(), String> {
        Ok(())
    }
    /// When the run was stopped.
    fn stopped(&mut self, _sim: &Simulation, _why: &Stopped) {}
}

/// Watches nothing.
impl Observer for () {}
