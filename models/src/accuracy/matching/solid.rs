//! Energies of a stabilised correspondence solid: kinetic, and of the strains as eq. 1 to 12 of Nicely, Tang and Qian have
//! them, summed here over the lattice without a kernel of the program.

use pdlang_runtime::simulate::Simulation;

/// A stabilised correspondence solid on a lattice of spacing, density, thickness and cross-section 1.
pub(super) struct Solid {
    pub n: f64,
    pub gs: f64,
    pub e: f64,
    pub nu: f64,
}

impl Solid {
    /// Kinetic and strain energy of the nodes that `inside` holds.
    pub fn energy(&self, sim: &Simulation, inside: impl Fn([f64; 3]) -> bool) -> f64 {
        let dim = sim.body.flavour.dim();
        let reach = self.n.floor() as i32;
        let range = |a: usize| if a < dim { -reach..=reach } else { 0..=0 };
        let mut steps = Vec::new();
        for i in range(0) {
            for j in range(1) {
                let r2 = i * i + j * j;
                if r2 > 0 && f64::from(r2) <= self.n * self.n * (1.0 + 1e-9) {
                    steps.push([i, j]);
                }
            }
        }
        let at = Places::of(sim);
        let u = |node: usize| -> [f64; 2] {
            let slot = sim.engine.slot(node);
            std::array::from_fn(|a| if a < dim { sim.state.u[a][slot] } else { 0.0 })
        };
        // All families of the interior are whole: the shape tensor is a multiple of unity.
        let shape: f64 = steps.iter().map(|s| f64::from(s[0] * s[0])).sum();
        let (lambda, g) = match dim {
            1 => (0.0, 0.5 * self.e),
            _ => (
                self.e * self.nu / (1.0 - self.nu * self.nu),
                0.5 * self.e / (1.0 + self.nu),
            ),
        };
        let pi = std::f64::consts::PI;
        let c_bb = match dim {
            1 => 2.0 * self.e / self.n.powi(3),
            _ => 12.0 * self.e / (2.0 * (1.0 - self.nu)) / (pi * self.n.powi(4)),
        };
        let held = self.gs * c_bb / steps.len() as f64;
        let mut total = 0.0;
        for (node, x) in sim.body.x.iter().enumerate() {
            if !inside(*x) {
                continue;
            }
            let own = u(node);
            let etas: Vec<[f64; 2]> = steps
                .iter()
                .map(|s| {
                    let other = u(at.node(sim, node, *s));
                    [other[0] - own[0], other[1] - own[1]]
                })
                .collect();
            let mut h = [[0.0; 2]; 2];
            for (eta, s) in etas.iter().zip(&steps) {
                for a in 0..2 {
                    for b in 0..2 {
                        h[a][b] += eta[a] * f64::from(s[b]) / shape;
                    }
                }
            }
            let trace = h[0][0] + h[1][1];
            let shear = 0.5 * (h[0][1] + h[1][0]);
            let mut w = 0.5 * lambda * trace * trace
                + g * (h[0][0].powi(2) + h[1][1].powi(2) + 2.0 * shear * shear);
            for (eta, s) in etas.iter().zip(&steps) {
                let z: [f64; 2] = std::array::from_fn(|a| {
                    eta[a] - h[a][0] * f64::from(s[0]) - h[a][1] * f64::from(s[1])
                });
                w += 0.5 * held * (z[0] * z[0] + z[1] * z[1]);
            }
            let slot = sim.engine.slot(node);
            let v: f64 = sim.state.v.iter().map(|v| v[slot] * v[slot]).sum();
            total += w + 0.5 * v;
        }
        total
    }
}

/// Finds the node some steps away.
struct Places(Vec<u32>);

impl Places {
    fn of(sim: &Simulation) -> Places {
        let mut nodes = Vec::new();
        if let Some(grid) = &sim.body.grid {
            nodes = vec![0; grid.shape.iter().map(|s| *s as usize).product()];
            for (node, cell) in grid.cell.iter().enumerate() {
                nodes[index(grid.shape, *cell)] = node as u32;
            }
        }
        Places(nodes)
    }

    fn of_step(&self, sim: &Simulation, node: usize, step: [i32; 2]) -> Option<usize> {
        let grid = sim.body.grid.as_ref()?;
        let mut cell = grid.cell[node];
        for a in 0..2 {
            let side = grid.shape[a] as i32;
            cell[a] = (cell[a] as i32 + step[a]).rem_euclid(side) as u32;
        }
        self.0.get(index(grid.shape, cell)).map(|n| *n as usize)
    }

    fn node(&self, sim: &Simulation, node: usize, step: [i32; 2]) -> usize {
        self.of_step(sim, node, step).unwrap_or(node)
    }
}

fn index(shape: [u32; 3], cell: [u32; 3]) -> usize {
    (cell[0] + shape[0] * (cell[1] + shape[1] * cell[2])) as usize
}
