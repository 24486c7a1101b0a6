//! A scene of `examples/` or a variation of one, looked at while it runs. Nothing is written.

use std::path::Path;

use pdlang_runtime::observe::{Observer, Outputs, Schedule, quantity};
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;

use crate::language::Pdlang;

/// The text of a scene.
#[derive(Clone)]
pub struct Case {
    name: String,
    text: String,
}

impl Case {
    pub fn new(name: &str, text: &str) -> Case {
        Case {
            name: name.into(),
            text: text.into(),
        }
    }

    /// The same with other text in the place of one passage.
    ///
    /// # Errors
    /// When the passage is not there exactly once: the scene has changed and the study does not know.
    pub fn with(&self, passage: &str, other: &str) -> Result<Case, String> {
        match self.text.matches(passage).count() {
            1 => Ok(Case::new(&self.name, &self.text.replace(passage, other))),
            n => Err(format!(
                "{} has {n} times `{passage}`, expected one",
                self.name
            )),
        }
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// # Errors
    /// What is wrong with the scene.
    pub fn simulation(&self) -> Result<Simulation, String> {
        let path = format!("examples/{}.toml", self.name);
        let scene = Scene::parse(&self.text, Path::new(&path), &Pdlang);
        let simulation = scene.and_then(|scene| scene.simulation());
        simulation.map_err(|problems| problems.render(false))
    }

    /// Runs it and looks at the simulation at the start, at the end, and whenever it is due.
    ///
    /// # Errors
    /// What is wrong with the scene, why the run stopped, and what `look` says.
    pub fn watch<T>(
        &self,
        when: Schedule,
        look: impl FnMut(&mut Simulation) -> Result<T, String>,
    ) -> Result<Vec<T>, String> {
        let mut simulation = self.simulation()?;
        simulation.outputs = Outputs {
            fields: when,
            ..Outputs::default()
        };
        let mut eye = Eye {
            look,
            seen: Vec::new(),
        };
        let outcome = simulation.run(&mut eye);
        outcome.map_err(|stopped| format!("{}: {stopped}", self.name))?;
        Ok(eye.seen)
    }

    /// A number at each of some times, which are whole steps, in rising order.
    ///
    /// # Errors
    /// As of [`Case::watch`], and times that no step meets.
    pub fn at<T>(
        &self,
        times: &[f64],
        mut look: impl FnMut(&mut Simulation) -> Result<T, String>,
    ) -> Result<Vec<T>, String> {
        let found = self.watch(Schedule::Times(times.to_vec()), |sim| {
            let time = sim.state.time;
            let asked = times.iter().any(|t| (t - time).abs() <= 1e-6 * sim.dt);
            asked.then(|| look(sim)).transpose()
        })?;
        let found: Vec<T> = found.into_iter().flatten().collect();
        match found.len() == times.len() {
            true => Ok(found),
            false => Err(format!("{}: steps miss some of {times:?}", self.name)),
        }
    }
}

struct Eye<T, F> {
    look: F,
    seen: Vec<T>,
}

impl<T, F: FnMut(&mut Simulation) -> Result<T, String>> Observer for Eye<T, F> {
    fn fields(&mut self, sim: &mut Simulation) -> Result<(), String> {
        self.seen.push((self.look)(sim)?);
        Ok(())
    }
}

/// The integral of a quantity over the body.
///
/// # Errors
/// A name that the law does not know.
pub fn total(sim: &mut Simulation, name: &str) -> Result<f64, String> {
    let values = quantity(sim, name).map_err(|e| e.to_string())?.scalar();
    Ok(values
        .iter()
        .zip(&sim.body.volume)
        .map(|(w, v)| w * v)
        .sum())
}

/// The nodes at some places, in the order of the body.
///
/// # Errors
/// A place without a node.
pub fn nodes_at(sim: &Simulation, places: &[[f64; 3]]) -> Result<Vec<usize>, String> {
    let near = 1e-6 * sim.body.spacing;
    let node = |place: &[f64; 3]| {
        let here = |x: &[f64; 3]| x.iter().zip(place).all(|(x, p)| (x - p).abs() <= near);
        let found = sim.body.x.iter().position(here);
        found.ok_or_else(|| format!("there is no node at {place:?}"))
    };
    places.iter().map(node).collect()
}

/// A component of the displacement of a node.
pub fn displacement(sim: &Simulation, node: usize, axis: usize) -> f64 {
    sim.state.u[axis][sim.engine.slot(node)]
}
