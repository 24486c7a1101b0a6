//! Rigid spheres that push nodes away.
//!
//! Each sphere keeps a list of the nodes that may touch it: those within a margin of its surface. The list holds
//! until nodes and sphere together may have moved by the margin, so that a sphere costs nothing while it is apart.
//! Where the dimension is two or one, a sphere is a disc or an interval.

use crate::body::Body;
use crate::conditions::Loads;
use crate::density::Density;
use crate::engine::State;
use crate::error::InputError;
use serde::{Deserialize, Serialize};

/// How a sphere repels a node inside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactLaw {
    /// Force density `stiffness * (R - r)^2` along the outward normal; stiffness in N/m^5.
    /// As LAMMPS `fix indent`; the brittle disc of Parks et al. 2008 uses 1e17.
    Penalty { stiffness: f64 },
    /// A node found inside is moved to the closest point of the surface and its velocity corrected
    /// (Madenci and Oterkus 2014, eq. 10.1-10.4).
    Relocation,
}

/// A rigid sphere in prescribed uniform motion: its centre is at `center + velocity * t`.
#[derive(Clone, Debug, PartialEq)]
pub struct Indenter {
    /// At t = 0 [m].
    pub center: [f64; 3],
    /// [m/s]
    pub velocity: [f64; 3],
    /// [m]
    pub radius: f64,
    pub law: ContactLaw,
}

/// What a sphere felt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reaction {
    /// Force of the body on the sphere, now [N].
    pub force: [f64; 3],
    /// Integral of that force over time [N s].
    pub impulse: [f64; 3],
    /// Work done on the body so far [J].
    pub work: f64,
    /// Deepest penetration seen so far [m].
    pub depth: f64,
    /// Nodes in contact now.
    pub nodes: usize,
}

impl Indenter {
    /// Refuses NaN, radii and stiffnesses that are not positive.
    pub fn check(&self) -> Result<(), InputError> {
        let stiffness = if let ContactLaw::Penalty { stiffness } = self.law {
            stiffness
        } else {
            1.0
        };
        let positive = |v: f64| v > 0.0 && v.is_finite();
        let place = self
            .center
            .iter()
            .chain(&self.velocity)
            .all(|c| c.is_finite());
        if place && positive(self.radius) && positive(stiffness) {
            return Ok(());
        }
        Err(InputError::new(
            "a sphere has a radius or stiffness that is not positive, or no finite centre and velocity",
            "give `radius` and `stiffness` positive values",
        ))
    }

    /// Centre at time `t` [m].
    pub fn center_at(&self, t: f64) -> [f64; 3] {
        [0, 1, 2].map(|d| self.center[d] + t * self.velocity[d])
    }

    /// Bound of the contact stiffness over the density, `df/du / rho` [rad^2/s^2], for penetrations up to `depth`.
    pub fn stiffness_bound(&self, depth: f64, density: f64) -> f64 {
        match self.law {
            ContactLaw::Penalty { stiffness } => 2.0 * stiffness * depth.min(self.radius) / density,
            ContactLaw::Relocation => 0.0,
        }
    }
}

/// The body as contact sees it.
pub struct Target<'a> {
    pub body: &'a Body,
    /// User node -> layout slot.
    pub slots: &'a [u32],
    /// Internal force density at the last evaluation, layout order [N/m^3].
    pub force: &'a [Vec<f64>],
    /// Layout order [m^3].
    pub volume: &'a [f64],
    pub density: &'a Density,
    pub dt: f64,
}

impl Target<'_> {
    /// From the centre to a node in its present position, and the distance [m].
    #[inline]
    fn ray(&self, center: [f64; 3], node: u32, u: &[Vec<f64>]) -> ([f64; 3], f64) {
        let s = self.slots[node as usize] as usize;
        let mut ray = [0.0; 3];
        for (d, u) in u.iter().enumerate() {
            ray[d] = self.body.x[node as usize][d] + u[s] - center[d];
        }
        (ray, ray.iter().map(|c| c * c).sum::<f64>().sqrt())
    }
}

/// All spheres of a run.
pub struct Contact {
    spheres: Vec<Sphere>,
    /// Contact force density on the nodes that are inside a sphere.
    pub loads: Loads,
    /// Slots whose motion is imposed: they are not moved out of a sphere.
    driven: Vec<bool>,
}

struct Sphere {
    indenter: Indenter,
    reaction: Reaction,
    /// User numbers, ascending: sums run in their order.
    candidates: Vec<u32>,
    /// Slot and force density [N/m^3] of the nodes inside.
    pressed: Vec<(u32, [f64; 3])>,
    /// Relative motion that the candidates still allow [m].
    slack: f64,
}

impl Contact {
    pub fn new(indenters: &[Indenter], dim: usize, len: usize, driven: Vec<bool>) -> Contact {
        let sphere = |i: &Indenter| Sphere {
            indenter: i.clone(),
            reaction: Reaction::default(),
            candidates: Vec::new(),
            pressed: Vec::new(),
            slack: -1.0,
        };
        let len = if indenters.is_empty() { 0 } else { len };
        Contact {
            spheres: indenters.iter().map(sphere).collect(),
            loads: Loads::new(dim, len),
            driven,
        }
    }

    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty()
    }

    pub fn reactions(&self) -> Vec<Reaction> {
        self.spheres.iter().map(|s| s.reaction).collect()
    }

    /// Puts back what a checkpoint saved.
    pub fn restore(&mut self, reactions: &[Reaction]) {
        self.spheres
            .iter_mut()
            .zip(reactions)
            .for_each(|(s, r)| s.reaction = *r);
    }

    /// Work of all spheres on the body so far [J].
    pub fn work(&self) -> f64 {
        self.spheres.iter().map(|s| s.reaction.work).sum()
    }

    /// Work of whatever holds the spheres' motion so far [J]: what contact took in, at most.
    pub fn drive(&self) -> f64 {
        let power = |s: &Sphere| -> f64 {
            s.reaction
                .impulse
                .iter()
                .zip(&s.indenter.velocity)
                .map(|(p, v)| -p * v)
                .sum()
        };
        self.spheres.iter().map(power).sum()
    }

    /// After the drift to `state.time`: accounts for the forces at the start of the step, and moves nodes out of
    /// spheres that relocate. `largest` bounds the motion of any node in this step [m].
    pub fn after_drift(&mut self, state: &mut State, target: &Target, largest: f64) {
        if self.spheres.is_empty() {
            return;
        }
        self.account(state, target);
        for k in 0..self.spheres.len() {
            let sphere = &mut self.spheres[k];
            let travel = sphere
                .indenter
                .velocity
                .iter()
                .map(|v| v * v)
                .sum::<f64>()
                .sqrt()
                * target.dt;
            // Only a number that is positive counts as slack: NaN asks for a new list.
            sphere.slack -= largest + travel;
            sphere.refresh(state, target);
            let moved = sphere.relocate(state, target, &self.driven);
            self.spheres.iter_mut().for_each(|s| s.slack -= moved);
        }
    }

    /// Penalty forces at `state.time`; then the other half of the account of the step that ended here.
    pub fn press(&mut self, state: &State, target: &Target, first: bool) {
        if self.spheres.is_empty() {
            return;
        }
        for f in &mut self.loads.density {
            self.loads.touched.iter().for_each(|&s| f[s as usize] = 0.0);
        }
        self.loads.touched.clear();
        for sphere in &mut self.spheres {
            sphere.refresh(state, target);
            sphere.press(state, target, &mut self.loads);
        }
        self.loads.touched.sort_unstable();
        self.loads.touched.dedup();
        if !first {
            self.account(state, target);
        }
    }

    /// Half a step's impulse and work, with the forces at one of its ends along the velocity of its middle.
    fn account(&mut self, state: &State, target: &Target) {
        let half = 0.5 * target.dt;
        for sphere in &mut self.spheres {
            let ContactLaw::Penalty { .. } = sphere.indenter.law else {
                continue;
            };
            for d in 0..3 {
                sphere.reaction.impulse[d] += half * sphere.reaction.force[d];
            }
            for (s, f) in &sphere.pressed {
                let s = *s as usize;
                let power: f64 = state.v.iter().zip(f).map(|(v, f)| f * v[s]).sum();
                sphere.reaction.work += half * target.volume[s] * power;
            }
        }
    }
}

impl Sphere {
    /// Finds the candidates anew when the old ones may no longer hold all nodes in contact.
    fn refresh(&mut self, state: &State, target: &Target) {
        if self.slack > 0.0 {
            return;
        }
        let center = self.indenter.center_at(state.time);
        let (mut nearest, mut close) = (f64::INFINITY, Vec::new());
        let margin = target.body.spacing;
        for node in 0..target.body.x.len() as u32 {
            let gap = target.ray(center, node, &state.u).1 - self.indenter.radius;
            nearest = nearest.min(gap);
            if gap < margin {
                close.push(node);
            }
        }
        // Without candidates the list holds until the nearest node may arrive.
        self.slack = nearest.max(margin);
        self.candidates = close;
    }

    fn press(&mut self, state: &State, target: &Target, loads: &mut Loads) {
        let ContactLaw::Penalty { stiffness } = self.indenter.law else {
            return;
        };
        let center = self.indenter.center_at(state.time);
        self.reaction.force = [0.0; 3];
        self.pressed.clear();
        for &node in &self.candidates {
            let (ray, r) = target.ray(center, node, &state.u);
            let depth = self.indenter.radius - r;
            // A node at the very centre has no direction in which to leave.
            if depth <= 0.0 || r == 0.0 {
                continue;
            }
            let s = target.slots[node as usize];
            let force = ray.map(|c| stiffness * depth * depth * c / r);
            for (d, f) in loads.density.iter_mut().enumerate() {
                f[s as usize] += force[d];
                self.reaction.force[d] -= force[d] * target.volume[s as usize];
            }
            self.pressed.push((s, force));
            loads.touched.push(s);
            self.reaction.depth = self.reaction.depth.max(depth);
        }
        self.reaction.nodes = self.pressed.len();
    }

    /// Moves nodes to the surface; returns the largest move [m].
    fn relocate(&mut self, state: &mut State, target: &Target, driven: &[bool]) -> f64 {
        let ContactLaw::Relocation = self.indenter.law else {
            return 0.0;
        };
        let center = self.indenter.center_at(state.time);
        let mut largest = 0.0_f64;
        (self.reaction.force, self.reaction.nodes) = ([0.0; 3], 0);
        for &node in &self.candidates {
            let (ray, r) = target.ray(center, node, &state.u);
            let depth = self.indenter.radius - r;
            let s = target.slots[node as usize] as usize;
            if depth <= 0.0 || r == 0.0 || driven.get(s) == Some(&true) {
                continue;
            }
            let density = target.density.at(s);
            let mass = density * target.volume[s];
            for (d, c) in ray.iter().enumerate().take(state.u.len()) {
                let step = depth * c / r;
                let (old, new) = (state.v[d][s], state.v[d][s] + step / target.dt);
                state.u[d][s] += step;
                state.v[d][s] = new;
                self.reaction.force[d] -= mass * (new - old) / target.dt;
                self.reaction.impulse[d] -= mass * (new - old);
                // The forces at the start of the step have acted for half of it: without their share the account of
                // the step, which pairs mean forces with the way made, would not close.
                let mean = 0.5 * (new + old)
                    - 0.5 * target.dt * target.force.get(d).map_or(0.0, |f| f[s]) / density;
                self.reaction.work += mass * (new - old) * mean;
            }
            largest = largest.max(depth);
            self.reaction.nodes += 1;
        }
        self.reaction.depth = self.reaction.depth.max(largest);
        largest
    }
}
