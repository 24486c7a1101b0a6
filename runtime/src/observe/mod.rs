//! What a run leaves behind: histories, fields, pictures, checkpoints, a summary.

use crate::error::InputError;
use crate::shape::Shape;
use crate::simulate::{Simulation, Stopped};
use std::path::PathBuf;

mod color;
mod draw;
mod files;
mod history;
mod inventory;
mod picture;
mod quantity;
mod row;
mod summary;
mod vtu;
pub use color::Rgb;
pub use draw::Canvas;
pub use files::Files;
pub use inventory::{Item, inventory, left_out};
pub(crate) use quantity::split;
pub use quantity::{Values, quantity};
pub use row::{FieldRow, Row};
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

impl Schedule {
    /// Whether something is due at a step that ends at `time` and began `dt` before.
    pub fn due(&self, step: u64, time: f64, dt: f64, end: bool) -> bool {
        let slack = 1e-6 * dt;
        match self {
            Schedule::Never => false,
            _ if step == 0 || end => true,
            Schedule::Ends => false,
            Schedule::Steps(n) => *n > 0 && step.is_multiple_of(*n),
            Schedule::Period(p) => ((time + slack) / p).floor() > ((time - dt + slack) / p).floor(),
            Schedule::Times(times) => times
                .iter()
                .any(|t| *t <= time + slack && *t > time - dt + slack),
        }
    }
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
    fn stopped(&mut self, _sim: &Simulation, _why: &Stopped, _summary: &Summary) {}
}

/// Watches nothing.
impl Observer for () {}

/// Refuses outputs that this simulation cannot give.
pub fn check(sim: &Simulation) -> Result<(), InputError> {
    for name in sim
        .outputs
        .quantities
        .iter()
        .chain(sim.outputs.views.iter().map(|v| &v.quantity))
    {
        quantity::check(sim, name)?;
    }
    for (k, view) in sim.outputs.views.iter().enumerate() {
        picture::check(sim, view)?;
        if sim.outputs.views[..k]
            .iter()
            .any(|other| other.name == view.name)
        {
            return Err(InputError::new(
                format!("two pictures are called `{}`", view.name),
                "give each picture a name of its own: it becomes the file name",
            ));
        }
    }
    let schedules = [
        &sim.outputs.history,
        &sim.outputs.fields,
        &sim.outputs.pictures,
        &sim.outputs.checkpoints,
    ];
    for schedule in schedules {
        let bad = match schedule {
            Schedule::Steps(n) => *n == 0,
            Schedule::Period(p) => p.is_nan() || *p <= 0.0,
            Schedule::Times(times) => times.iter().any(|t| !t.is_finite()),
            _ => false,
        };
        if bad {
            return Err(InputError::new(
                "an output is due every 0 steps or seconds",
                "give a positive interval",
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::Schedule;

    #[test]
    fn periods_and_times_are_met_once() {
        let dt = 0.3;
        let due = |s: &Schedule| {
            (1..20)
                .filter(|&n| s.due(n, n as f64 * dt, dt, false))
                .collect::<Vec<_>>()
        };
        assert_eq!(due(&Schedule::Period(0.9)), [3, 6, 9, 12, 15, 18]);
        assert_eq!(due(&Schedule::Times(vec![0.0, 0.3, 1.0])), [1, 4]);
        assert_eq!(due(&Schedule::Steps(7)), [7, 14]);
        assert!(due(&Schedule::Ends).is_empty() && Schedule::Ends.due(0, 0.0, dt, false));
        assert!(!Schedule::Never.due(0, 0.0, dt, true));
    }
}
