//! PMB and LPS written down plainly from their published formulas: loops over a bond list, no
//! derivation, no symmetry, no tricks. What the engine and the peers are compared with.

use std::f64::consts::PI;

/// A directed bond.
#[derive(Clone, Copy, Debug)]
pub struct Bond {
    pub i: usize,
    pub j: usize,
    /// Reference bond vector [m].
    pub xi: [f64; 3],
    /// Reference length [m].
    pub x: f64,
    /// Volume of j times the partial-volume factor [m^3].
    pub weight: f64,
    pub intact: bool,
}

/// All bonds with x <= delta, grouped by their first node.
pub fn bonds(
    positions: &[[f64; 3]],
    volume: impl Fn(usize) -> f64,
    delta: f64,
    partial: Option<f64>,
) -> Vec<Bond> {
    let mut bonds = Vec::new();
    for (i, a) in positions.iter().enumerate() {
        for (j, b) in positions.iter().enumerate() {
            let xi = std::array::from_fn(|k| b[k] - a[k]);
            let x = norm(xi);
            if i != j && x <= delta {
                let weight = volume(j) * partial.map_or(1.0, |dx| partial_volume(x, delta, dx));
                bonds.push(Bond {
                    i,
                    j,
                    xi,
                    x,
                    weight,
                    intact: true,
                });
            }
        }
    }
    bonds
}

/// Share of a node's cell that counts: 1 up to delta - dx/2, then falling linearly to 1/2 at delta.
pub fn partial_volume(x: f64, delta: f64, dx: f64) -> f64 {
    if x <= delta - dx / 2.0 {
        1.0
    } else {
        (delta + dx / 2.0 - x) / dx
    }
}

pub fn norm(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// Deformed bond direction and extension.
pub fn kinematics(bond: &Bond, u: &[[f64; 3]]) -> ([f64; 3], f64) {
    let y: [f64; 3] = std::array::from_fn(|k| bond.xi[k] + u[bond.j][k] - u[bond.i][k]);
    let length = norm(y);
    (y.map(|c| c / length), length - bond.x)
}

/// c of PMB in 3D [N/m^6]: 18 K/(pi delta^4).
pub fn pmb_constant(k: f64, delta: f64) -> f64 {
    18.0 * k / (PI * delta.powi(4))
}

/// Sums `magnitude(bond, e) M w` over the intact bonds of each node [N/m^3].
pub fn pairwise(
    bonds: &[Bond],
    u: &[[f64; 3]],
    magnitude: impl Fn(&Bond, f64) -> f64,
) -> Vec<[f64; 3]> {
    let mut force = vec![[0.0; 3]; u.len()];
    for bond in bonds.iter().filter(|bond| bond.intact) {
        let (direction, e) = kinematics(bond, u);
        let size = magnitude(bond, e) * bond.weight;
        for k in 0..3 {
            force[bond.i][k] += size * direction[k];
        }
    }
    force
}

/// PMB: f_i = sum c s M w.
pub fn pmb_force(bonds: &[Bond], u: &[[f64; 3]], c: f64) -> Vec<[f64; 3]> {
    pairwise(bonds, u, |bond, e| c * e / bond.x)
}

/// PMB: W_i = sum c s e w / 4.
pub fn pmb_energy(bonds: &[Bond], u: &[[f64; 3]], c: f64) -> Vec<f64> {
    node_sum(bonds, u.len(), |bond| {
        let (_, e) = kinematics(bond, u);
        c * e * e / bond.x / 4.0
    })
}

/// Sum over the intact bonds of each node.
pub fn node_sum(bonds: &[Bond], nodes: usize, value: impl Fn(&Bond) -> f64) -> Vec<f64> {
    let mut sum = vec![0.0; nodes];
    for bond in bonds.iter().filter(|bond| bond.intact) {
        sum[bond.i] += value(bond) * bond.weight;
    }
    sum
}

/// The linear peridynamic solid in 3D with bulk modulus `k`, shear modulus `g` and influence `omega`.
pub struct Lps<F> {
    pub k: f64,
    pub g: f64,
    pub omega: F,
    /// Weighted volume of every node [m^2 m^3 times the unit of omega].
    pub m: Vec<f64>,
}

impl<F: Fn(f64) -> f64> Lps<F> {
    /// With the weighted volume of the bonds that are intact now.
    pub fn new(k: f64, g: f64, omega: F, bonds: &[Bond], nodes: usize) -> Self {
        let m = node_sum(bonds, nodes, |bond| omega(bond.x) * bond.x * bond.x);
        Lps { k, g, omega, m }
    }

    /// theta_i = 3/m_i sum omega x e w.
    pub fn theta(&self, bonds: &[Bond], u: &[[f64; 3]]) -> Vec<f64> {
        let sum = node_sum(bonds, u.len(), |bond| {
            let (_, e) = kinematics(bond, u);
            (self.omega)(bond.x) * bond.x * e
        });
        sum.iter()
            .zip(&self.m)
            .map(|(s, m)| if *m > 0.0 { 3.0 * s / m } else { 0.0 })
            .collect()
    }

    /// f_i = sum [(3K-5G)(theta_i/m_i + theta_j/m_j) omega x + 15 G (1/m_i + 1/m_j) omega e] M w.
    pub fn force(&self, bonds: &[Bond], u: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let theta = self.theta(bonds, u);
        pairwise(bonds, u, |bond, e| {
            let (i, j, omega) = (bond.i, bond.j, (self.omega)(bond.x));
            let volumetric = theta[i] / self.m[i] + theta[j] / self.m[j];
            let inverse = 1.0 / self.m[i] + 1.0 / self.m[j];
            ((3.0 * self.k - 5.0 * self.g) * volumetric * bond.x + 15.0 * self.g * inverse * e)
                * omega
        })
    }

    /// W_i = (3K-5G) theta_i^2/6 + 15 G/(2 m_i) sum omega e^2 w.
    pub fn energy(&self, bonds: &[Bond], u: &[[f64; 3]]) -> Vec<f64> {
        let theta = self.theta(bonds, u);
        let stretch = node_sum(bonds, u.len(), |bond| {
            let (_, e) = kinematics(bond, u);
            (self.omega)(bond.x) * e * e
        });
        let density = |i: usize| {
            let shear = if self.m[i] > 0.0 {
                7.5 * self.g / self.m[i] * stretch[i]
            } else {
                0.0
            };
            (3.0 * self.k - 5.0 * self.g) * theta[i] * theta[i] / 6.0 + shear
        };
        (0..u.len()).map(density).collect()
    }
}

/// Velocity Verlet from rest: half kick, drift, force, half kick.
pub fn verlet(
    u: &mut [[f64; 3]],
    rho: f64,
    dt: f64,
    steps: usize,
    mut force: impl FnMut(&[[f64; 3]]) -> Vec<[f64; 3]>,
) {
    let mut v = vec![[0.0; 3]; u.len()];
    let mut f = force(u);
    for _ in 0..steps {
        for i in 0..u.len() {
            for k in 0..3 {
                v[i][k] += 0.5 * dt * f[i][k] / rho;
                u[i][k] += dt * v[i][k];
            }
        }
        f = force(u);
        for (v, f) in v.iter_mut().zip(&f) {
            *v = std::array::from_fn(|k| v[k] + 0.5 * dt * f[k] / rho);
        }
    }
}
