//! Branches: the eigenvalues of waves along a line in the space of wave vectors, each followed from the longest wave on.

use pdlang::oracle::Complex;

use super::hermitian::{Hermitian, Pair};
use super::stencil::Stencil;

/// Two stiffnesses, over the larger one, that count as one: their vectors are any two of a plane.
const ALIKE: f64 = 1e-9;

/// One wave of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Stiffness over density [rad^2/s^2]; negative where it grows instead of running.
    pub squared: f64,
    /// Angular frequency [rad/s]; 0 where `squared` is negative.
    pub omega: f64,
    /// Group velocity [m/s]; none where there is no frequency.
    pub group: Option<[f64; 3]>,
    /// Share of the motion along the wave vector, from 0 (transverse) to 1 (longitudinal).
    pub longitudinal: f64,
}

/// Follows eigenvectors from one matrix to the next, so that branches that cross keep their order.
pub struct Follower {
    last: Vec<Pair>,
}

impl Follower {
    /// Begins with the matrix of a long wave along `n`: the branch that moves most along it comes first, the others by
    /// falling stiffness.
    pub fn new(long: &Hermitian, n: [f64; 3]) -> Follower {
        let along = n.map(|c| Complex { re: c, im: 0.0 });
        let mut last = long.pairs();
        last.reverse();
        // Of the first ones that move alike the stiffest.
        let mut first = 0;
        for (k, pair) in last.iter().enumerate() {
            if pair.overlap(&along) > last[first].overlap(&along) + 1e-6 {
                first = k;
            }
        }
        let longitudinal = last.remove(first);
        last.insert(0, longitudinal);
        Follower { last }
    }

    /// The eigenpairs of the last matrix, that of long waves at first.
    pub fn last(&self) -> &[Pair] {
        &self.last
    }

    /// The eigenpairs of the next matrix in the order of the branches.
    pub fn next(&mut self, matrix: &Hermitian) -> Vec<Pair> {
        let mut rest = matrix.pairs();
        let top = rest.iter().fold(0.0_f64, |m, p| m.max(p.value.abs()));
        let alike = rest
            .windows(2)
            .any(|w| w[1].value - w[0].value <= ALIKE * top);
        let mut found = Vec::new();
        for old in &self.last {
            let best = (0..rest.len()).max_by(|a, b| {
                rest[*a]
                    .overlap(&old.vector)
                    .total_cmp(&rest[*b].overlap(&old.vector))
            });
            if let Some(best) = best {
                found.push(rest.remove(best));
            }
        }
        // Where two values are one, the vectors of the last matrix say more.
        if alike {
            for (now, old) in found.iter().zip(&mut self.last) {
                old.value = now.value;
            }
        } else {
            self.last.clone_from(&found);
        }
        found
    }
}

/// A wave of the lattice with its group velocity, `v . dM/dk v/(2 rho Omega)`.
pub fn wave(stencil: &Stencil, density: f64, k: [f64; 3], pair: &Pair, scale: f64) -> Wave {
    let squared = pair.value / density;
    let omega = squared.max(0.0).sqrt();
    let group = (omega > scale).then(|| {
        let along = |a: usize| match a < stencil.dim {
            true => pair.expectation(&stencil.slope(k, a)) / (2.0 * density * omega),
            false => 0.0,
        };
        std::array::from_fn(along)
    });
    let length = k.iter().map(|c| c * c).sum::<f64>().sqrt();
    let direction = k.map(|c| Complex {
        re: c / length,
        im: 0.0,
    });
    Wave {
        squared,
        omega,
        group,
        longitudinal: if length > 0.0 {
            pair.overlap(&direction)
        } else {
            0.0
        },
    }
}
