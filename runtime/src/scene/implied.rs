//! The modulus that a law has on its lattice.

use super::{Nodes, Scene};
use crate::carve::{Anchor, Carve, carve};
use crate::engine::{Breaking, Engine};
use crate::shape::Shape;

/// Small enough for a linear answer, large enough for twelve digits of it.
const STRAIN: f64 = 1e-6;

/// The modulus against uniform expansion of a node with a full family on the scene's lattice [Pa]: the K of
/// W = K theta^2/2, in three dimensions the bulk modulus. Sums over a lattice differ from the integrals that
/// constants are made of; this is the number to compare with. `None` for a cloud, for a law without energy and where nodes have their
/// own horizons.
pub fn modulus(scene: &Scene) -> Option<f64> {
    let Nodes::Carved(carved) = &scene.nodes else {
        return None;
    };
    let law = scene.material.law.clone();
    law.spec.energy?;
    let cells = (scene.family.horizon.constant()? / carved.spacing).floor() + 1.0;
    let mut settings = scene.settings();
    settings.traversal = crate::engine::Traversal::Cloud;
    settings.precision = crate::engine::Precision::Double;
    let body = carve(&block(carved, cells * carved.spacing)).ok()?;
    let mut engine = Engine::new(&body, law, settings).ok()?;
    let middle = body.x.iter().position(|x| *x == [0.0; 3])?;
    let energy = expanded(&mut engine, &body.x, body.flavour.dim(), middle);
    let theta = body.flavour.dim() as f64 * STRAIN;
    Some(2.0 * energy / (theta * theta))
}

/// A block of the scene's lattice about a node at the origin that has all its neighbours.
fn block(carved: &Carve, reach: f64) -> Carve {
    Carve {
        shape: Shape::Box {
            from: [-reach; 3],
            to: [reach; 3],
        },
        anchor: Anchor::Node([0.0; 3]),
        periodic: [false; 3],
        tolerance: None,
        ..carved.clone()
    }
}

/// Energy density at `node` when the body expands [J/m^3].
fn expanded(engine: &mut Engine, x: &[[f64; 3]], dim: usize, node: usize) -> f64 {
    let mut state = engine.state();
    for (i, position) in x.iter().enumerate() {
        let slot = engine.slot(i);
        for (u, position) in state.u.iter_mut().zip(position).take(dim) {
            u[slot] = STRAIN * position;
        }
    }
    engine.forces(&mut state, Breaking::Held);
    let slot = engine.slot(node);
    engine.energy(&state)[slot]
}
