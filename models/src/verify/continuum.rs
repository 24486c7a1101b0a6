//! The family of a node of an unbounded continuum, as bonds of a quadrature; and that of a lattice.
//!
//! Along the radius the rule of Gauss and Legendre in the root of the length, which bears influence functions like
//! `x^-0.5`; over directions a rule that is exact to degree 9 (in 3D the 12 and 20 vertices of McLaren 1963). Every
//! direction comes with its opposite, so that every bond has a reverse.

use pdlang::oracle::{Body, Bond, Node};
use std::f64::consts::{PI, TAU};

/// A bond vector [m] and its weight [m^3].
pub type Point = ([f64; 3], f64);

/// Unit vectors and their weights, which sum to the measure of all directions.
pub fn directions(dim: usize, fine: bool) -> Vec<Point> {
    match dim {
        1 => vec![([1.0, 0.0, 0.0], 1.0), ([-1.0, 0.0, 0.0], 1.0)],
        2 => {
            let count = if fine { 10 } else { 6 };
            let half = (0..count / 2).map(|k| 0.3 + TAU * f64::from(k) / f64::from(count));
            let pair = |angle: f64| {
                let (sin, cos) = angle.sin_cos();
                [[cos, sin, 0.0], [-cos, -sin, 0.0]]
            };
            half.flat_map(pair)
                .map(|n| (n, TAU / f64::from(count)))
                .collect()
        }
        _ => solid_directions(fine),
    }
}

fn solid_directions(fine: bool) -> Vec<Point> {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    // One of every pair of opposite vertices.
    let mut twelve = Vec::new();
    let mut twenty: Vec<[f64; 3]> = [
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, 1.0],
        [1.0, -1.0, 1.0],
        [1.0, 1.0, -1.0],
    ]
    .to_vec();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let place = |a: f64, b: f64| {
                let mut v = [0.0; 3];
                v[(axis + 1) % 3] = a;
                v[(axis + 2) % 3] = b;
                v
            };
            twelve.push(place(sign, golden));
            twenty.push(place(sign * golden, 1.0 / golden));
        }
    }
    let (a, b) = if fine {
        (5.0 / 168.0, 9.0 / 280.0)
    } else {
        (1.0 / 12.0, 0.0)
    };
    let weighted = |list: Vec<[f64; 3]>, part: f64| {
        list.into_iter().flat_map(move |v| {
            let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
            let n = v.map(|c| c / length);
            [(n, 2.0 * TAU * part), (n.map(|c| -c), 2.0 * TAU * part)]
        })
    };
    let all = weighted(twelve, a).chain(weighted(twenty, b));
    all.filter(|(_, w)| *w > 0.0).collect()
}

/// Places in [0, 1] and weights of the rule of Gauss and Legendre.
pub fn gauss(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let one = |k: usize| {
        let mut x = (PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..100 {
            let (mut p, mut last) = (1.0, 0.0);
            for j in 0..count {
                let j = j as f64;
                (p, last) = (((2.0 * j + 1.0) * x * p - j * last) / (j + 1.0), p);
            }
            slope = n * (x * p - last) / (x * x - 1.0);
            let step = p / slope;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(one).collect()
}

/// A quadrature over the horizon; `cross` is the thickness or cross-section of what has fewer than three dimensions.
pub fn ball(dim: usize, horizon: f64, cross: f64, radial: usize, fine: bool) -> Vec<Point> {
    let directions = directions(dim, fine);
    let mut points = Vec::new();
    for (t, w) in gauss(radial) {
        // r = horizon t^2.
        let (r, dr) = (horizon * t * t, 2.0 * horizon * t * w);
        for (n, part) in &directions {
            points.push((n.map(|c| r * c), part * r.powi(dim as i32 - 1) * dr * cross));
        }
    }
    points
}

/// Bonds along the axes that weigh next to nothing, for families of such bonds alone.
pub fn needles(dim: usize, horizon: f64, volume: f64) -> Vec<Point> {
    let axis = |a: usize, sign: f64| {
        let mut v = [0.0; 3];
        v[a] = 0.5 * sign * horizon;
        (v, 1e-9 * volume)
    };
    (0..dim)
        .flat_map(|a| [axis(a, 1.0), axis(a, -1.0)])
        .collect()
}

/// The family of a lattice.
pub fn lattice(dim: usize, spacing: f64, reach: f64, cross: f64) -> Vec<Point> {
    let last = reach.floor() as i32;
    let range = |a: usize| if a < dim { -last..=last } else { 0..=0 };
    let mut points = Vec::new();
    for i in range(0) {
        for j in range(1) {
            for k in range(2) {
                let squared = i * i + j * j + k * k;
                if squared > 0 && f64::from(squared) <= reach * reach * (1.0 + 1e-9) {
                    let xi = [i, j, k].map(|c| f64::from(c) * spacing);
                    points.push((xi, spacing.powi(dim as i32) * cross));
                }
            }
        }
    }
    points
}

/// One node that stands for all: its bonds lead to itself.
pub fn single(points: &[Point]) -> Body {
    let node = Node {
        position: [0.0; 3],
        volume: 1.0,
    };
    let bond = |(xi, weight): &Point| Bond {
        from: 0,
        to: 0,
        xi: *xi,
        weight: *weight,
    };
    Body {
        nodes: vec![node],
        bonds: points.iter().map(bond).collect(),
    }
}

/// A node with its family, and the families of its neighbours. It is number 0.
pub fn two_rings(points: &[Point]) -> Body {
    let node = |position| Node {
        position,
        volume: 1.0,
    };
    let mut nodes = vec![node([0.0; 3])];
    nodes.extend(points.iter().map(|(xi, _)| node(*xi)));
    let mut bonds = Vec::new();
    for (k, (xi, weight)) in points.iter().enumerate() {
        bonds.push(Bond {
            from: 0,
            to: k + 1,
            xi: *xi,
            weight: *weight,
        });
    }
    for (k, (x, _)) in points.iter().enumerate() {
        for (xi, weight) in points {
            let back = (0..3).all(|a| xi[a] == -x[a]);
            let to = if back { 0 } else { nodes.len() };
            if !back {
                nodes.push(node(std::array::from_fn(|a| x[a] + xi[a])));
            }
            bonds.push(Bond {
                from: k + 1,
                to,
                xi: *xi,
                weight: *weight,
            });
        }
    }
    Body { nodes, bonds }
}
