//! Hand-written laws on small bodies, against double loops.
pub(crate) mod laws;
mod other;
mod pmb;

use super::*;
use crate::body::{Body, Flavour, Grid};

/// A block of lattice nodes with unit-free sizes.
pub(super) fn block(flavour: Flavour, shape: [u32; 3], dx: f64) -> Body {
    let mut cell = vec![];
    for k in 0..shape[2] {
        for j in 0..shape[1] {
            for i in 0..shape[0] {
                cell.push([i, j, k]);
            }
        }
    }
    let n = cell.len();
    let cross = if flavour.dim() == 3 { 1.0 } else { 0.7 };
    Body {
        flavour,
        x: cell.iter().map(|c| c.map(|c| c as f64 * dx)).collect(),
        volume: vec![dx.powi(flavour.dim() as i32) * cross; n],
        material: vec![],
        regions: vec![],
        horizon: vec![],
        cross,
        grid: Some(Grid {
            origin: [0.0; 3],
            spacing: dx,
            shape,
            cell,
        }),
        spacing: dx,
        periodic: [None; 3],
    }
}

/// Keeps the nodes for which `keep` holds, in a shuffled order.
pub(super) fn carve(b: &Body, keep: impl Fn([f64; 3]) -> bool) -> Body {
    let mut nodes: Vec<usize> = (0..b.x.len()).filter(|&i| keep(b.x[i])).collect();
    nodes.sort_by_key(|&i| (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let mut c = b.clone();
    c.x = nodes.iter().map(|&i| b.x[i]).collect();
    c.volume = nodes.iter().map(|&i| b.volume[i]).collect();
    if let (Some(to), Some(from)) = (&mut c.grid, &b.grid) {
        to.cell = nodes.iter().map(|&i| from.cell[i]).collect();
    }
    c
}

/// Numbers in [-1, 1], the same in every run.
pub(super) fn noise(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

pub(super) fn isas() -> Vec<Isa> {
    Isa::ALL.into_iter().filter(|i| i.available()).collect()
}

/// Displacements of size `size`, by user node.
pub(super) fn displace(e: &Engine, s: &mut State, body: &Body, size: f64) {
    for i in 0..body.x.len() {
        for a in 0..body.flavour.dim() {
            s.u[a][e.slot(i)] = size * noise((3 * i + a) as u64);
        }
    }
}

/// Force of every node in user order.
pub(super) fn forces(e: &Engine) -> Vec<Vec<f64>> {
    let user = |f: &Vec<f64>| e.slots().iter().map(|&s| f[s as usize]).collect();
    e.force().iter().map(user).collect()
}

pub(super) fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let flat = |v: &[Vec<f64>]| v.concat();
    let size = flat(b).iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let miss = flat(a)
        .iter()
        .zip(flat(b))
        .fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(miss.is_finite());
    miss / size.max(f64::MIN_POSITIVE)
}
