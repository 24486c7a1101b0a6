//! Rigid spheres that push nodes away.

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
