//! The nodes whose values a mirror makes: for every node of a condition the one behind the plane.

use super::{Condition, Mirror, Parity, Quantity, name};
use crate::body::Body;
use crate::error::InputError;
use crate::shape::tolerance;
use std::collections::HashMap;

/// The nodes' images, by user number, and where the expression is evaluated for each.
pub(super) struct Reflected {
    pub nodes: Vec<u32>,
    pub places: Vec<[f64; 3]>,
    pub parity: Parity,
}

pub(super) fn images(
    mirror: &Mirror,
    condition: &Condition,
    nodes: &[u32],
    body: &Body,
) -> Result<Reflected, InputError> {
    let length = mirror.normal.iter().map(|n| n * n).sum::<f64>().sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return Err(InputError::new(
            "the normal of a mirror has no direction",
            "give the direction across the mirror, such as [1, 0, 0]",
        ));
    }
    if !matches!(
        condition.quantity,
        Quantity::Displacement | Quantity::Field(_)
    ) {
        return Err(InputError::new(
            format!("a mirror continues a {}", name(&condition.quantity)),
            "a mirror goes with displacements and fields; velocities follow",
        ));
    }
    let n = mirror.normal.map(|n| n / length);
    let near = Near::of(body);
    let mut found = Reflected {
        nodes: Vec::with_capacity(nodes.len()),
        places: Vec::with_capacity(nodes.len()),
        parity: mirror.parity,
    };
    for &node in nodes {
        let x = body.x[node as usize];
        let along: f64 = (0..3).map(|d| (x[d] - mirror.point[d]) * n[d]).sum();
        let moved = |by: f64| [0, 1, 2].map(|d| x[d] - by * along * n[d]);
        let image = near.at(moved(2.0), body).filter(|i| {
            *i != node
                && !condition
                    .region
                    .contains(body.x[*i as usize], tolerance(body.spacing))
        });
        let Some(image) = image else {
            let y = moved(2.0);
            return Err(InputError::new(
                format!(
                    "node {node} at ({:e}, {:e}, {:e}) m has no mirror image: there is no node of the body outside \
                     of the region at ({:e}, {:e}, {:e}) m",
                    x[0], x[1], x[2], y[0], y[1], y[2]
                ),
                "put the mirror half way between two rows of nodes or on one, and the region on one side of it only",
            ));
        };
        found.nodes.push(image);
        found.places.push(match mirror.parity {
            Parity::Odd => moved(1.0),
            Parity::Even => x,
        });
    }
    Ok(found)
}

/// Finds the node at a position.
struct Near(HashMap<[i64; 3], Vec<u32>>);

impl Near {
    fn of(body: &Body) -> Near {
        let mut cells: HashMap<_, Vec<u32>> = HashMap::new();
        for (node, x) in body.x.iter().enumerate() {
            cells.entry(cell(*x, body)).or_default().push(node as u32);
        }
        Near(cells)
    }

    /// The node within a thousandth of the spacing.
    fn at(&self, x: [f64; 3], body: &Body) -> Option<u32> {
        let c = cell(x, body);
        let around = (0..27).map(|k| [c[0] + k % 3 - 1, c[1] + k / 3 % 3 - 1, c[2] + k / 9 - 1]);
        let close = |n: &u32| {
            let y = body.x[*n as usize];
            (0..3).map(|d| (x[d] - y[d]).powi(2)).sum::<f64>() <= (1e-3 * body.spacing).powi(2)
        };
        around
            .filter_map(|c| self.0.get(&c))
            .flatten()
            .copied()
            .find(close)
    }
}

fn cell(x: [f64; 3], body: &Body) -> [i64; 3] {
    x.map(|c| (c / body.spacing).floor() as i64)
}
