//! From the runtime's bodies to the oracle's.

use pdlang::ir;
use pdlang::oracle::{self, Ball};
use pdlang_runtime::body::{Body, Flavour};

use crate::naive::partial_volume;

/// Slack of the test |xi| <= delta, so that a node at exactly the horizon counts.
const INCLUSIVE: f64 = 1.0 + 1e-9;

pub fn flavour(f: Flavour) -> ir::Flavour {
    ir::Flavour::ALL[Flavour::ALL
        .iter()
        .position(|g| *g == f)
        .expect("both lists hold all flavours")]
}

/// The body with its bond list, by comparing all pairs and, in periodic directions, all near images.
pub fn oracle_body(body: &Body, horizon: f64, partial: bool) -> oracle::Body {
    let node = |(x, v): (&[f64; 3], &f64)| oracle::Node {
        position: *x,
        volume: *v,
    };
    let nodes: Vec<oracle::Node> = body.x.iter().zip(&body.volume).map(node).collect();
    let mut bonds = Vec::new();
    for from in 0..nodes.len() {
        for to in 0..nodes.len() {
            for xi in images(body, from, to, horizon) {
                let mut bond = oracle::Bond {
                    from,
                    to,
                    xi,
                    weight: body.volume[to],
                };
                let length = bond.length();
                if length > 0.0 && length <= horizon * INCLUSIVE {
                    bond.weight *= factor(body, length, horizon, partial);
                    bonds.push(bond);
                }
            }
        }
    }
    oracle::Body { nodes, bonds }
}

fn factor(body: &Body, length: f64, horizon: f64, partial: bool) -> f64 {
    if partial {
        partial_volume(length, horizon, body.spacing)
    } else {
        1.0
    }
}

/// Bond vectors from one node to another and to its periodic images that may be near.
fn images(body: &Body, from: usize, to: usize, horizon: f64) -> Vec<[f64; 3]> {
    let direct: [f64; 3] = std::array::from_fn(|a| separation(body, from, to, a));
    let shifts = |a: usize| match body.periodic[a] {
        Some(period) => {
            let reach = (horizon / period).ceil() as i32 + 1;
            (-reach..=reach).map(|k| f64::from(k) * period).collect()
        }
        None => vec![0.0],
    };
    let [sx, sy, sz] = [shifts(0), shifts(1), shifts(2)];
    let mut vectors = Vec::new();
    for x in &sx {
        for y in &sy {
            vectors.extend(
                sz.iter()
                    .map(|z| [direct[0] + x, direct[1] + y, direct[2] + z]),
            );
        }
    }
    vectors
}

/// On a grid the difference of cells, which is free of rounding, times the spacing.
fn separation(body: &Body, from: usize, to: usize, a: usize) -> f64 {
    match &body.grid {
        Some(grid) => (f64::from(grid.cell[to][a]) - f64::from(grid.cell[from][a])) * grid.spacing,
        None => body.x[to][a] - body.x[from][a],
    }
}

/// The integral over the horizon for this body's cross-section.
pub fn integral(body: &Body) -> Ball {
    Ball::Integral { cross: body.cross }
}

/// The sum over a full lattice family of spacing `dx`.
pub fn lattice_sum(body: &Body, horizon: f64, partial: bool) -> Ball {
    let (dx, dim) = (body.spacing, body.flavour.dim());
    let reach = (horizon / dx).floor() as i32 + 1;
    let volume = dx.powi(dim as i32) * body.cross;
    let range = |a: usize| if a < dim { -reach..=reach } else { 0..=0 };
    let mut family = Vec::new();
    for x in range(0) {
        for y in range(1) {
            for z in range(2) {
                let xi = [x, y, z].map(|c| f64::from(c) * dx);
                let length = crate::naive::norm(xi);
                if length > 0.0 && length <= horizon * INCLUSIVE {
                    family.push((xi, volume * factor(body, length, horizon, partial)));
                }
            }
        }
    }
    Ball::Lattice(family)
}
