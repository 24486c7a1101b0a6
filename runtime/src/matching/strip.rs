//! Planes inside of a boundary in which short waves lose their energy.
//!
//! A wave that runs backwards carries its phases out and its energy in: a condition for phases that leave feeds it. What
//! these waves have in common is that they are short. In the strip each node exchanges a share of the difference of
//! velocities with its neighbours on the lattice, as in a viscous fluid, in every component: a wave of the length `l` loses
//! `(pi h/l)^2` of the share that the shortest one loses. Between two nodes that move by forces no exchange gives
//! energy; a node of the boundary gives as it moves, and takes nothing.

use super::chain::Chain;

/// What the shortest waves lose of their velocity, per spacing that the fastest wave travels. Short waves run slowly:
/// they are gone before they have crossed the strip.
const SHARE: f64 = 0.3;
/// Of what the shortest waves have, in a step: they must not overshoot.
const MOST: f64 = 0.5;

/// What damps short waves inside of a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// Planes of nodes, from those of the boundary inwards; 0: none.
    pub planes: usize,
    /// How often the shortest waves lose their energy [1/s].
    rate: f64,
    /// Pairs of neighbours that a node is in.
    pairs: f64,
}

impl Strip {
    /// For a body of `dim` dimensions and the waves along the normal.
    pub fn new(planes: usize, dim: usize, normal: &Chain) -> Strip {
        let per_spacing = normal.series(1).first().copied().unwrap_or(0.0);
        Strip {
            planes,
            rate: SHARE * per_spacing,
            pairs: 2.0 * dim as f64,
        }
    }

    /// Of the plane `inside` of the boundary: falls from 1 to nothing, so that no wave meets an edge.
    pub(super) fn share(&self, inside: usize) -> f64 {
        self.planes.saturating_sub(inside) as f64 / self.planes.max(1) as f64
    }

    /// What two neighbours exchange of the difference of their velocities in a step of `dt`, where the share is 1.
    pub fn exchanged(&self, dt: f64) -> f64 {
        (self.rate * dt).min(MOST) / (2.0 * self.pairs)
    }
}
