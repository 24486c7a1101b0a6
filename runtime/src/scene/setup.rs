//! From a scene to a simulation: the body is built here, and what only then shows is told.

use std::ops::Range;

use super::Scene;
use super::absorbing;
use super::body::Nodes;
use super::family::Horizon;
use super::problem::{Problem, Problems};
use crate::body::Body;
use crate::carve::carve;
use crate::conditions::nodes_in;
use crate::engine::Settings;
use crate::error::{About, InputError};
use crate::points::{self, Points};
use crate::simulate::{Setup, Simulation};

impl Scene {
    /// Builds the body and puts everything together for [`Simulation::new`].
    ///
    /// # Errors
    /// A body that is empty, does not fit in memory or cannot be read.
    pub fn setup(&self) -> Result<Setup, Problems> {
        let mut body = self.nodes().map_err(|e| self.problem(e))?;
        let mut settings = self.settings();
        self.grade(&mut body, &mut settings.horizon)?;
        let rim = absorbing::rim(&self.absorbing, &body)
            .map_err(|(k, e)| self.problem_at(self.absorbing[k].span.clone(), e))?;
        Ok(Setup {
            title: self.title.clone(),
            body,
            law: self.material.law.clone(),
            settings,
            density: self
                .material
                .sets()
                .iter()
                .map(|m| m.0.unwrap_or(0.0))
                .collect(),
            initial: self.initial.iter().cloned().chain(rim.rates).collect(),
            conditions: self.conditions.clone(),
            cracks: self.cracks.clone(),
            no_fail: self.no_fail.iter().cloned().chain(rim.holds).collect(),
            indenters: self.indenters.clone(),
            matching: self.matching.clone(),
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
        let mut simulation = Simulation::new(self.setup()?).map_err(|e| self.problem(e))?;
        simulation.engine.sleep(self.sleep);
        Ok(simulation)
    }

    /// How the engine is to be built. Where nodes have their own horizon, that of their material is the spacing.
    pub fn settings(&self) -> Settings {
        Settings {
            materials: self.material.sets().into_iter().map(|m| m.1).collect(),
            influences: self
                .material
                .influences
                .iter()
                .map(|i| (i.function.clone(), i.values.clone()))
                .collect(),
            horizon: (self.material.horizons(&self.family.horizon).iter())
                .map(|h| h.constant().unwrap_or(self.nodes.spacing()))
                .collect(),
            horizon_levels: self.family.horizon_levels,
            partial_volume: self.family.partial_volume,
            lattice_constants: self.material.lattice_constants,
            without: self.material.without.clone(),
            traversal: self.family.traversal,
            isa: self.family.isa,
            precision: self.family.precision,
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

    /// Horizons of the nodes that have their own; the largest is that of their material. None reaches beyond the body.
    fn grade(&self, body: &mut Body, largest: &mut [f64]) -> Result<(), Problems> {
        let reach = longest_bond(body);
        for (m, horizon) in self
            .material
            .horizons(&self.family.horizon)
            .iter()
            .enumerate()
        {
            if horizon.constant().is_some() {
                if let Some(error) = too_large(reach, largest[m]) {
                    return Err(self.problem_at(horizon.span(), error));
                }
                continue;
            }
            let own = self.own_horizons(body, horizon);
            let own = own.map_err(|e| self.problem_at(horizon.span(), e))?;
            body.horizon.resize(body.x.len(), 0.0);
            for (node, own) in own.into_iter().enumerate() {
                if body.material.get(node).copied().unwrap_or(0) as usize != m {
                    continue;
                }
                let error = self.too_small(body.x[node], own);
                if let Some(error) = error.or_else(|| too_large(reach, own)) {
                    return Err(self.problem_at(horizon.span(), error));
                }
                body.horizon[node] = own;
                largest[m] = largest[m].max(own);
            }
        }
        Ok(())
    }

    /// Of all nodes, whatever their material.
    fn own_horizons(&self, body: &Body, horizon: &Horizon) -> Result<Vec<f64>, InputError> {
        match (horizon, &self.nodes) {
            (Horizon::Constant(h, _), _) => Ok(vec![*h; body.x.len()]),
            (Horizon::Expression(e, _), _) => {
                let function = e.function()?;
                Ok(body.x.iter().map(|x| function.call(x)).collect())
            }
            (Horizon::Column(name, _), Nodes::Points { file, .. }) => points::column(file, name),
            (Horizon::Column(..), Nodes::Carved(_)) => Err(InputError::new(
                "a body that is carved out of a shape has no columns",
                "give the horizon as an expression in x, y and z, or the body as `points`",
            )),
        }
    }

    /// What is wrong with the horizon of a node.
    fn too_small(&self, x: [f64; 3], horizon: f64) -> Option<InputError> {
        let at: Vec<String> = x[..self.nodes.flavour().dim()]
            .iter()
            .map(|c| short(*c))
            .collect();
        let what = format!(
            "the horizon of the node at ({}) m is {} m",
            at.join(", "),
            short(horizon)
        );
        if !(horizon > 0.0 && horizon.is_finite()) {
            let remedy = "a horizon is a positive, finite length at every node";
            return Some(InputError::new(what, remedy));
        }
        match &self.nodes {
            Nodes::Carved(carved) if horizon < carved.spacing => Some(InputError::new(
                format!(
                    "{what}, less than the spacing of {} m",
                    short(carved.spacing)
                ),
                "such a node has no neighbour of its kind: three times the spacing is usual",
            )),
            _ => None,
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

    /// An error of the built body, at what it is about or at the scene's `[body]`.
    fn problem(&self, error: InputError) -> Problems {
        let source = &self.source;
        let place = match error.about {
            Some(About::Traversal) => self.family.traversal_place.as_ref(),
            Some(About::Precision) => self.family.precision_place.as_ref(),
            // Of two boundaries of one side the second is one too many.
            Some(About::Matching(side)) => (self.matching.iter().zip(&source.matching))
                .rfind(|(m, _)| m.sides.contains(&side))
                .map(|(_, place)| place),
            Some(About::Initial(k)) => source.initial.get(k),
            Some(About::Condition(k)) => source.conditions.get(k),
            None => None,
        };
        self.problem_at(place.unwrap_or(&source.body).clone(), error)
    }

    fn problem_at(&self, place: Range<usize>, error: InputError) -> Problems {
        let problem = Problem::new(error.what).at(place, "");
        let problem = if error.remedy.is_empty() {
            problem
        } else {
            problem.help(error.remedy)
        };
        Problems::sorted(&self.source.path, &self.source.text, vec![problem])
    }
}

/// A bound of the distance between any two nodes [m]; none for a body so small that all its nodes may be one family.
fn longest_bond(body: &Body) -> f64 {
    let side = |a: usize| {
        let along = || body.x.iter().map(|x| x[a]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    match body.x.len() {
        0..=SMALL => f64::INFINITY,
        _ => (0..3).map(|a| side(a).powi(2)).sum::<f64>().sqrt(),
    }
}

/// Nodes.
const SMALL: usize = 4096;

fn too_large(reach: f64, horizon: f64) -> Option<InputError> {
    (horizon > reach).then(|| {
        InputError::new(
            format!(
                "a horizon of {} m reaches beyond the whole body, which measures {} m across",
                short(horizon),
                short(reach)
            ),
            "three times the spacing is usual: horizon = \"3 dx\"; a length without a unit is in metres",
        )
    })
}

/// Six digits.
fn short(value: f64) -> String {
    let rounded = format!("{value:.5e}").parse::<f64>();
    rounded.map_or_else(|_| value.to_string(), |v| v.to_string())
}
