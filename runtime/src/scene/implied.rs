//! The modulus that a lattice or cloud really has.

use crate::engine::{Breaking, Engine};
use crate::simulate::Simulation;

/// Small enough for a linear answer, large enough for twelve digits of it.
const STRAIN: f64 = 1e-6;

/// The modulus against uniform expansion of the node closest to the middle of the body [Pa]: the K of
/// W = K theta^2/2, which in three dimensions is the bulk modulus. Sums over a lattice differ from the
/// integrals that constants are made of; this is the number to compare with. `None` for a law without energy.
pub fn modulus(simulation: &mut Simulation) -> Option<f64> {
    let Simulation { body, engine, .. } = simulation;
    engine.spec().energy?;
    let dim = body.flavour.dim();
    let middle = middle(&body.x);
    let node = nearest(&body.x, middle)?;
    let energy = expanded(engine, &body.x, middle, dim, node);
    let theta = dim as f64 * STRAIN;
    Some(2.0 * energy / (theta * theta))
}

/// Energy density at `node` when the body expands about `middle` [J/m^3].
fn expanded(engine: &mut Engine, x: &[[f64; 3]], middle: [f64; 3], dim: usize, node: usize) -> f64 {
    let mut state = engine.state();
    for (i, position) in x.iter().enumerate() {
        let slot = engine.slot(i);
        for d in 0..dim {
            state.u[d][slot] = STRAIN * (position[d] - middle[d]);
        }
    }
    engine.forces(&mut state, Breaking::Held);
    let slot = engine.slot(node);
    engine.energy(&state)[slot]
}

fn middle(x: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|d| x.iter().map(|p| p[d]).sum::<f64>() / x.len().max(1) as f64)
}

fn nearest(x: &[[f64; 3]], to: [f64; 3]) -> Option<usize> {
    let distance = |p: &[f64; 3]| (0..3).map(|d| (p[d] - to[d]).powi(2)).sum::<f64>();
    (0..x.len()).min_by(|&a, &b| distance(&x[a]).total_cmp(&distance(&x[b])))
}
