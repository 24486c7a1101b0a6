//! Small bodies: boxes of lattices, clouds off any lattice, deformations, turns and sets of broken bonds; the same for the
//! same seed.

use pdlang_runtime::body::{Body, Flavour, Grid};
use std::collections::HashSet;

/// Lattice constant of the bodies [m].
pub const DX: f64 = 5e-4;
/// Thickness of plates [m], cross-section of bars [m^2].
const CROSS: f64 = 1.25e-3;

/// Pseudo-random numbers (SplitMix64: Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.uniform() - 1.0
    }
}

fn cross(flavour: Flavour) -> f64 {
    if flavour == Flavour::Solid {
        1.0
    } else {
        CROSS
    }
}

fn cell_volume(flavour: Flavour) -> f64 {
    DX.powi(flavour.dim() as i32) * cross(flavour)
}

/// Cells of a box that takes about fifty nodes; the first direction exceeds any vector register.
fn cells(flavour: Flavour) -> [u32; 3] {
    match flavour.dim() {
        1 => [37, 1, 1],
        2 => [11, 5, 1],
        _ => [10, 3, 2],
    }
}

fn all_cells(shape: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let [a, b, c] = shape;
    (0..c).flat_map(move |z| (0..b).flat_map(move |y| (0..a).map(move |x| [x, y, z])))
}

/// A box of a regular grid.
pub fn lattice(flavour: Flavour, shape: [u32; 3], periodic: bool) -> Body {
    from_cells(flavour, shape, all_cells(shape).collect(), periodic)
}

/// A box of a regular grid from which a seventh of the cells was carved at random.
pub fn carved(flavour: Flavour, seed: u64) -> Body {
    let (mut random, shape) = (Random(seed), cells(flavour));
    let kept = all_cells(shape)
        .filter(|_| random.uniform() > 1.0 / 7.0)
        .collect();
    from_cells(flavour, shape, kept, false)
}

fn from_cells(flavour: Flavour, shape: [u32; 3], cell: Vec<[u32; 3]>, periodic: bool) -> Body {
    let dim = flavour.dim();
    let origin: [f64; 3] = std::array::from_fn(|a| if a < dim { DX / 2.0 } else { 0.0 });
    let at = |c: &[u32; 3]| std::array::from_fn(|a| origin[a] + DX * f64::from(c[a]));
    let period = |a: usize| (periodic && a < dim).then(|| DX * f64::from(shape[a]));
    Body {
        flavour,
        x: cell.iter().map(at).collect(),
        volume: vec![cell_volume(flavour); cell.len()],
        material: vec![],
        regions: vec![],
        horizon: vec![],
        cross: cross(flavour),
        grid: Some(Grid {
            origin,
            spacing: DX,
            shape,
            cell,
        }),
        spacing: DX,
        periodic: std::array::from_fn(period),
    }
}

/// Nodes off any grid: jittered by up to 0.3 dx, with volumes between half and three halves of a cell.
pub fn cloud(flavour: Flavour, seed: u64) -> Body {
    let mut body = carved(flavour, seed);
    let mut random = Random(seed ^ 0xC10D);
    body.grid = None;
    for (x, volume) in body.x.iter_mut().zip(&mut body.volume) {
        for c in x.iter_mut().take(flavour.dim()) {
            *c += 0.3 * DX * random.signed();
        }
        *volume *= 1.0 + 0.5 * random.signed();
    }
    body
}

/// The same nodes without their grid, so that only the cloud traversal can run them.
pub fn without_grid(body: &Body) -> Body {
    Body {
        grid: None,
        ..body.clone()
    }
}

/// Random displacements that give bonds about the stated strain: a random gradient plus a random share of each
/// node; in a periodic body, where there is no gradient, the nodes alone.
pub fn deformation(body: &Body, strain: f64, seed: u64) -> Vec<[f64; 3]> {
    let (mut random, dim) = (Random(seed ^ 0xDEF0), body.flavour.dim());
    let periodic = body.periodic.iter().any(Option::is_some);
    let (affine, single) = if periodic {
        (0.0, 1.5 * strain)
    } else {
        (strain, 0.5 * strain)
    };
    let gradient: [[f64; 3]; 3] =
        std::array::from_fn(|_| std::array::from_fn(|_| affine * random.signed()));
    let displace = |x: &[f64; 3]| {
        let mut component = |a: usize| {
            let stretched: f64 = (0..dim).map(|b| gradient[a][b] * x[b]).sum();
            stretched + single * body.spacing * random.signed()
        };
        std::array::from_fn(|a| if a < dim { component(a) } else { 0.0 })
    };
    body.x.iter().map(displace).collect()
}

/// Displacements of a rigid rotation about an axis off all planes [rad].
pub fn rotation(body: &Body, angle: f64) -> Vec<[f64; 3]> {
    let axis = match body.flavour.dim() {
        3 => [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0],
        _ => [0.0, 0.0, 1.0],
    };
    let (sin, cos) = (angle.sin(), angle.cos());
    let turn = |x: &[f64; 3]| {
        let along: f64 = (0..3).map(|a| axis[a] * x[a]).sum();
        std::array::from_fn(|a| {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            let around = axis[b] * x[c] - axis[c] * x[b];
            (cos - 1.0) * (x[a] - along * axis[a]) + sin * around
        })
    };
    body.x.iter().map(turn).collect()
}

/// Pairs of nodes whose bond is to be broken: each with probability `share`; symmetric.
pub fn broken_pairs(body: &Body, share: f64, seed: u64) -> HashSet<(usize, usize)> {
    let mut random = Random(seed ^ 0xB40E);
    let pairs = (0..body.x.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs
        .filter(|_| random.uniform() < share)
        .flat_map(|(i, j)| [(i, j), (j, i)])
        .collect()
}

/// About half of the bonds, so that every node keeps some in all directions: three per direction at least.
pub fn half_broken(body: &Body, horizon: f64, seed: u64) -> HashSet<(usize, usize)> {
    let far = |i: usize, j: usize| {
        let squared: f64 = (0..3).map(|a| (body.x[i][a] - body.x[j][a]).powi(2)).sum();
        squared.sqrt() <= horizon * (1.0 + 1e-9)
    };
    let nodes = 0..body.x.len();
    let mut left: Vec<usize> = nodes
        .clone()
        .map(|i| nodes.clone().filter(|j| i != *j && far(i, *j)).count())
        .collect();
    let least = 3 * body.flavour.dim();
    let mut pairs: Vec<(usize, usize)> = broken_pairs(body, 0.5, seed)
        .into_iter()
        .filter(|(i, j)| i < j && far(*i, *j))
        .collect();
    pairs.sort_unstable();
    let mut broken = HashSet::new();
    for (i, j) in pairs {
        if left[i] > least && left[j] > least {
            (left[i], left[j]) = (left[i] - 1, left[j] - 1);
            broken.extend([(i, j), (j, i)]);
        }
    }
    broken
}

/// The node at a position, or at the image of a position in a periodic body.
pub fn node_at(body: &Body, position: [f64; 3]) -> usize {
    let gap = |a: usize, b: f64| {
        let d = position[a] - b;
        match body.periodic[a] {
            Some(period) => (d - period * (d / period).round()).abs(),
            None => d.abs(),
        }
    };
    let distance = |x: &[f64; 3]| (0..3).map(|a| gap(a, x[a])).fold(0.0, f64::max);
    let (mut nearest, mut least) = (0, f64::INFINITY);
    for (k, x) in body.x.iter().enumerate() {
        if distance(x) < least {
            (nearest, least) = (k, distance(x));
        }
    }
    nearest
}

/// The same body at another size, all lengths in its directions times `factor`.
pub fn scaled(mut body: Body, factor: f64) -> Body {
    let dim = body.flavour.dim();
    body.x.iter_mut().flatten().for_each(|c| *c *= factor);
    let volume = factor.powi(dim as i32);
    body.volume.iter_mut().for_each(|v| *v *= volume);
    body.spacing *= factor;
    if let Some(grid) = &mut body.grid {
        grid.spacing *= factor;
        grid.origin.iter_mut().for_each(|c| *c *= factor);
    }
    for period in body.periodic.iter_mut().flatten() {
        *period *= factor;
    }
    body
}

/// The same nodes in another order.
pub fn shuffled(body: &Body, seed: u64) -> (Body, Vec<usize>) {
    let mut random = Random(seed ^ 0x5AFF);
    let mut order: Vec<usize> = (0..body.x.len()).collect();
    for k in (1..order.len()).rev() {
        order.swap(k, (random.uniform() * (k + 1) as f64) as usize);
    }
    let mut other = body.clone();
    for (to, &from) in order.iter().enumerate() {
        other.x[to] = body.x[from];
        other.volume[to] = body.volume[from];
        if let (Some(grid), Some(old)) = (&mut other.grid, &body.grid) {
            grid.cell[to] = old.cell[from];
        }
        if !body.material.is_empty() {
            other.material[to] = body.material[from];
        }
    }
    (other, order)
}
