//! From a scene to a simulation: the body is built here, and what only then shows is told.

use super::Scene;
use super::body::Nodes;
use super::problem::{Problem, Problems};
use crate::body::Body;
use crate::carve::carve;
use crate::engine::Settings;
use crate::error::InputError;
use crate::points::{self, Points};
use crate::simulate::{Setup, Simulation};

impl Scene {
    /// Builds the body and puts everything together for [`Simulation::new`].
    ///
    /// # Errors
    /// A body that is empty, does not fit in memory or cannot be read.
    pub fn setup(&self) -> Result<Setup, Problems> {
        Ok(Setup {
            title: self.title.clone(),
            body: self.body().map_err(|e| self.problem(e))?,
            law: self.material.law.clone(),
            settings: self.settings(),
            density: self.material.density.unwrap_or(0.0),
            initial: self.initial.clone(),
            conditions: self.conditions.clone(),
            cracks: self.cracks.clone(),
            no_fail: self.no_fail.clone(),
            indenters: self.indenters.clone(),
            step: self.step,
            end: self.end,
            outputs: self.outputs.clone(),
        })
    }

    /// A ready simulation.
    ///
    /// # Errors
    /// As [`Scene::setup`], and whatever the body and the law do not allow together.
    pub fn simulation(&self) -> Result<Simulation, Problems> {
        Simulation::new(self.setup()?).map_err(|e| self.problem(e))
    }

    /// How the engine is to be built.
    pub fn settings(&self) -> Settings {
        Settings {
            materials: vec![self.material.params.clone()],
            influences: self
                .material
                .influences
                .iter()
                .map(|i| (i.function.clone(), i.values.clone()))
                .collect(),
            horizon: self.family.horizon,
            partial_volume: self.family.partial_volume,
            lattice_constants: self.material.lattice_constants,
            traversal: self.family.traversal,
            isa: self.family.isa,
        }
    }

    fn body(&self) -> Result<Body, InputError> {
        match &self.nodes {
            Nodes::Carved(c) => carve(c),
            Nodes::Points {
                file,
                flavour,
                spacing,
                cross,
                period,
            } => points::read(
                file,
                &Points {
                    flavour: *flavour,
                    cross: *cross,
                    spacing: Some(*spacing),
                    length: 1.0,
                    periodic: *period,
                },
            ),
        }
    }

    /// An error of the built body, at the scene's `[body]`.
    fn problem(&self, error: InputError) -> Problems {
        let problem = Problem::new(error.what).at(self.source.body.clone(), "");
        let problem = if error.remedy.is_empty() {
            problem
        } else {
            problem.help(error.remedy)
        };
        Problems::sorted(&self.source.path, &self.source.text, vec![problem])
    }
}
