//! From a scene to a simulation: the body is built here, and what only then shows is told.

use super::Scene;
use super::body::Nodes;
use super::problem::{Problem, Problems};
use crate::body::Body;
use crate::carve::carve;
use crate::conditions::nodes_in;
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
            body: self.nodes().map_err(|e| self.problem(e))?,
            law: self.material.law.clone(),
            settings: self.settings(),
            density: self
                .material
                .sets()
                .iter()
                .map(|m| m.0.unwrap_or(0.0))
                .collect(),
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
            materials: self.material.sets().into_iter().map(|m| m.1).collect(),
            influences: self
                .material
                .influences
                .iter()
                .map(|i| (i.function.clone(), i.values.clone()))
                .collect(),
            horizon: self.material.horizons(self.family.horizon),
            partial_volume: self.family.partial_volume,
            lattice_constants: self.material.lattice_constants,
            without: self.material.without.clone(),
            traversal: self.family.traversal,
            isa: self.family.isa,
        }
    }

    /// The nodes, each with its material.
    fn nodes(&self) -> Result<Body, InputError> {
        let mut body = self.body()?;
        for (k, part) in self.material.parts.iter().enumerate() {
            let inside = nodes_in(&body, &part.region);
            if inside.is_empty() {
                return Err(InputError::new(
                    format!("part {} of the material holds no node", k + 1),
                    "move or enlarge its region; nodes on its boundary count",
                ));
            }
            body.regions.push(part.region.clone());
            body.material.resize(body.x.len(), 0);
            for node in inside {
                body.material[node as usize] = (k + 1) as u8;
            }
        }
        Ok(body)
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
