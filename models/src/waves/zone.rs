//! What a lattice does over its whole Brillouin zone: the largest stiffness, the least, and modes without energy.
//!
//! A grid over half of the zone (`M(-k)` is the conjugate of `M(k)`), and from its best points a search by halved steps.

use std::f64::consts::PI;

use super::stencil::Stencil;

/// Points of the grid from 0 to `pi/dx` along an axis, by dimension: with halves, thirds and quarters among them.
const POINTS: [i32; 3] = [240, 36, 12];
/// A frequency over the largest that is none.
pub const NOTHING: f64 = 1e-6;
/// Closer to the origin, in units of 1/dx, a mode is a translation.
const ORIGIN: f64 = 0.02;
/// Searches at most by dimension, from points this many steps apart, and places that are listed.
const SEARCHES: [usize; 3] = [64, 48, 24];
const APART: f64 = 1.6;
const LISTED: usize = 12;

/// An extreme of the eigenvalues of `M`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// [N/m^4], or [1/s] of a field.
    pub value: f64,
    /// Wave vector [1/m].
    pub k: [f64; 3],
}

/// A wave vector at which some waves cost nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZeroMode {
    /// Wave vector [1/m].
    pub k: [f64; 3],
    /// How many polarisations.
    pub count: usize,
}

/// The extremes of a stencil, and where it has no stiffness.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    pub largest: Extreme,
    pub least: Extreme,
    /// Up to sign and order of the components each once, and no more than a dozen.
    pub zero: Vec<ZeroMode>,
    /// Points of the grid, and how many of them have a mode without energy: more than a few where a line or all of the
    /// zone has.
    pub points: usize,
    pub zero_points: usize,
}

/// Looks at all of the zone.
pub fn zone(stencil: &Stencil) -> Zone {
    let unit = 1.0 / stencil.spacing;
    let values = |k: [f64; 3]| stencil.matrix(k.map(|c| c * unit)).pairs();
    let least = |k: [f64; 3]| values(k).first().map_or(0.0, |p| p.value);
    let most = |k: [f64; 3]| values(k).last().map_or(0.0, |p| p.value);
    let grid = grid(stencil.dim);
    let mut low: Vec<([f64; 3], f64)> = Vec::new();
    let mut high: Vec<([f64; 3], f64)> = Vec::new();
    for k in &grid {
        let values = values(*k);
        low.push((*k, values.first().map_or(0.0, |p| p.value)));
        high.push((*k, values.last().map_or(0.0, |p| p.value)));
    }
    high.sort_by(|a, b| b.1.total_cmp(&a.1));
    let step = PI / f64::from(POINTS[stencil.dim - 1]);
    let search =
        |from: &([f64; 3], f64), of: &dyn Fn([f64; 3]) -> f64| climb(stencil.dim, from.0, step, of);
    let tops = high.iter().take(4).map(|from| search(from, &most));
    let (at, top) = tops.fold(high[0], |a, b| if b.1 > a.1 { b } else { a });
    let none = NOTHING * NOTHING * top;
    let zero_points = low.iter().filter(|(_, v)| *v <= none).count();
    // The least stiffness over the square of the wave vector has no valley at the origin.
    let flat = |(k, v): &([f64; 3], f64)| v / k.iter().map(|c| 1.0 - c.cos()).sum::<f64>();
    let mut bottom = low.clone();
    bottom.sort_by(|a, b| flat(a).total_cmp(&flat(b)));
    let deepest = low
        .iter()
        .fold(bottom[0], |a, b| if b.1 < a.1 { *b } else { a });
    let mut zero: Vec<ZeroMode> = Vec::new();
    let mut lowest = deepest;
    let mut starts = vec![deepest];
    for from in &bottom {
        let near = |s: &([f64; 3], f64)| (0..3).all(|a| (s.0[a] - from.0[a]).abs() <= APART * step);
        if starts.len() < SEARCHES[stencil.dim - 1] && !starts.iter().any(near) {
            starts.push(*from);
        }
    }
    for from in &starts {
        let (k, minus) = search(from, &|k| -least(k));
        if far(&k) < ORIGIN {
            continue;
        }
        if -minus < lowest.1 {
            lowest = (k, -minus);
        }
        if -minus > none || zero.len() >= LISTED {
            continue;
        }
        let mode = ZeroMode {
            k: k.map(|c| c * unit),
            count: values(k).iter().filter(|p| p.value <= none).count(),
        };
        if !zero.iter().any(|z| same(&z.k, &mode.k, unit)) {
            zero.push(mode);
        }
    }
    zero.sort_by(|a, b| far(&a.k).total_cmp(&far(&b.k)));
    // On most lattices axes are alike: the first of the places that are.
    let extreme = |(k, value): ([f64; 3], f64), of: &dyn Fn([f64; 3]) -> f64| {
        let mut first = k.map(f64::abs);
        first.sort_by(|a, b| b.total_cmp(a));
        let alike = (of(first) - value).abs() <= 1e-12 * top.abs();
        Extreme {
            value,
            k: if alike { first } else { k }.map(|c| c * unit),
        }
    };
    Zone {
        largest: extreme((at, top), &most),
        least: extreme(lowest, &least),
        zero,
        points: grid.len(),
        zero_points,
    }
}

fn far(k: &[f64; 3]) -> f64 {
    k.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Alike up to sign and order of the components, as all are on a cubic lattice.
fn same(a: &[f64; 3], b: &[f64; 3], unit: f64) -> bool {
    let sorted = |k: &[f64; 3]| {
        let mut k = k.map(f64::abs);
        k.sort_by(f64::total_cmp);
        k
    };
    let (a, b) = (sorted(a), sorted(b));
    (0..3).all(|i| (a[i] - b[i]).abs() <= 1e-3 * unit)
}

/// Half of the zone without the origin, times the lattice constant.
fn grid(dim: usize) -> Vec<[f64; 3]> {
    let n = POINTS[dim - 1];
    let range = |a: usize| match a {
        0 => 0..=n,
        a if a < dim => 1 - n..=n,
        _ => 0..=0,
    };
    let mut grid = Vec::new();
    for i in range(0) {
        for j in range(1) {
            for l in range(2) {
                if (i, j, l) != (0, 0, 0) {
                    grid.push([i, j, l].map(|c| PI * f64::from(c) / f64::from(n)));
                }
            }
        }
    }
    grid
}

/// The place of a local maximum: steps along the axes and diagonals, halved where none climbs.
fn climb(dim: usize, from: [f64; 3], step: f64, of: &dyn Fn([f64; 3]) -> f64) -> ([f64; 3], f64) {
    let (mut k, mut best, mut h) = (from, of(from), 0.5 * step);
    let ways: Vec<[f64; 3]> = ways(dim);
    while h > 1e-9 {
        let tried = ways.iter().map(|way| {
            let at: [f64; 3] = std::array::from_fn(|a| (k[a] + h * way[a]).clamp(-PI, PI));
            (at, of(at))
        });
        let (at, value) = tried.fold((k, best), |a, b| if b.1 > a.1 { b } else { a });
        if value > best {
            (k, best) = (at, value);
        } else {
            h *= 0.5;
        }
    }
    (k, best)
}

fn ways(dim: usize) -> Vec<[f64; 3]> {
    let range = |a: usize| if a < dim { -1..=1 } else { 0..=0 };
    let mut ways = Vec::new();
    for i in range(0) {
        for j in range(1) {
            for l in range(2) {
                if (i, j, l) != (0, 0, 0) {
                    ways.push([i, j, l].map(f64::from));
                }
            }
        }
    }
    ways
}
