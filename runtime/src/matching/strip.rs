//! Planes inside of a boundary in which short waves lose their energy.
//!
//! A wave that runs backwards carries its phases out and its energy in: a condition for phases that leave feeds it. What
//! these waves have in common is that they are short. In the strip each node exchanges a share of the difference of
//! velocities with its neighbours on the lattice, as in a viscous fluid, in every component. The wave in which all
//! neighbours go against each other loses the most; one of the length `l` along an axis loses `sin^2(pi h/l)` of that, over the
//! directions that the body has. Between two nodes that move by forces no exchange gives energy; a node of the boundary
//! gives as it moves, and takes nothing.

use super::chain::Chain;

/// What the shortest waves lose of their velocity, per spacing that the fastest wave travels. Short waves run slowly:
/// they are gone before they have crossed the strip.
const SHARE: f64 = 0.3;
/// What they lose in a step at most: they must not overshoot.
const MOST: f64 = 0.5;

/// What damps short waves inside of a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// Planes of nodes, from those of the boundary inwards; 0: none.
    pub planes: usize,
    /// Whether more are usual, and the body has no room for them.
    pub cramped: bool,
    /// Share of the difference of their velocities that two neighbours exchange at the boundary [1/s].
    rate: f64,
    /// The same in a step, at most.
    most: f64,
}

impl Strip {
    /// For a body of `dim` dimensions and the waves along the normal.
    pub fn new(planes: usize, dim: usize, normal: &Chain) -> Strip {
        let per_spacing = normal.series(1).first().copied().unwrap_or(0.0);
        Strip {
            planes,
            cramped: false,
            rate: SHARE * per_spacing * Strip::of_pair(dim),
            most: Strip::most(dim),
        }
    }

    /// What two neighbours exchange at most in a step, of the difference of their velocities.
    pub fn most(dim: usize) -> f64 {
        MOST * Strip::of_pair(dim)
    }

    /// What a pair exchanges for a share of 1 to be lost where all neighbours go against each other: a node has two in
    /// every direction, and each differs by twice its own velocity.
    fn of_pair(dim: usize) -> f64 {
        1.0 / (4.0 * dim as f64)
    }

    /// Of the plane `inside` of the boundary: falls from 1 to nothing, so that no wave meets an edge.
    pub(super) fn share(&self, inside: usize) -> f64 {
        self.planes.saturating_sub(inside) as f64 / self.planes.max(1) as f64
    }

    /// Rate at which a node takes part in the exchange, `inside` of the boundary or, where that is none, in it [1/s].
    pub(super) fn rate(&self, inside: Option<usize>) -> f64 {
        match inside {
            None if self.planes == 0 => 0.0,
            None => self.rate,
            Some(inside) => self.rate * self.share(inside),
        }
    }

    /// What two neighbours exchange of the difference of their velocities in a step of `dt`, where the share is 1.
    pub fn exchanged(&self, dt: f64) -> f64 {
        (self.rate * dt).min(self.most)
    }
}
