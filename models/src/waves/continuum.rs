//! The same waves in the continuum: of the law with an infinitely fine lattice, and of its long waves.
//!
//! The oracle is asked of one node with a quadrature for its family, polar about the wave vector: along the radius, in two
//! pieces, and the polar angle the rule of Gauss and Legendre, with more points the shorter the wave is; about the polar
//! axis, where stiffnesses are polynomials of the fourth degree, five points.

use pdlang::ir::{FieldId, Flavour};
use pdlang::oracle::{Ball, Oracle};
use std::f64::consts::{PI, TAU};

use super::hermitian::Hermitian;
use crate::verify::constants::cross;
use crate::verify::continuum::{Point, gauss, single};
use crate::verify::subject::Subject;

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moving {
    Displacement,
    Field(FieldId),
}

/// Wave numbers times the horizon at which the slope of a long wave is taken.
const LONG: f64 = 0.02;
/// Points about the polar axis.
const AROUND: usize = 5;

/// `M(k)` of the continuum along a unit direction, `k` in 1/m. [N/m^4], of a field [1/s].
///
/// # Errors
/// What the oracle cannot answer.
pub fn matrix(
    subject: &Subject,
    flavour: Flavour,
    moving: Moving,
    n: [f64; 3],
    k: f64,
) -> Result<Hermitian, String> {
    let points = family(flavour, subject.horizon, n, k * subject.horizon);
    let ball = Ball::Integral {
        cross: cross(flavour),
    };
    of_family(
        subject,
        flavour,
        moving,
        (&points, true),
        ball,
        n.map(|c| c * k),
    )
}

/// `M(k)` of a family of the continuum, or of a lattice, `false`: then the same as [`super::Stencil::matrix`], by another
/// way.
///
/// # Errors
/// What the oracle cannot answer.
pub fn of_family(
    subject: &Subject,
    flavour: Flavour,
    moving: Moving,
    (points, dense): (&[Point], bool),
    ball: Ball,
    k: [f64; 3],
) -> Result<Hermitian, String> {
    let text = |error: pdlang::oracle::Error| error.to_string();
    let body = single(points);
    let settings = subject.settings(flavour, ball);
    let oracle = Oracle::new(subject.law, &body, &settings).map_err(text)?;
    let state = oracle.state();
    let (mut re, mut im) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    let size = match moving {
        Moving::Displacement => {
            let matrix = oracle.wave_stiffness(&state, k, dense).map_err(text)?;
            for a in 0..3 {
                for b in 0..3 {
                    (re[a][b], im[a][b]) = (matrix[a][b].re, matrix[a][b].im);
                }
            }
            flavour.dim()
        }
        Moving::Field(field) => {
            let rate = oracle.wave_rate(&state, field, k, dense).map_err(text)?;
            let rate = rate.ok_or("the field has no rate")?;
            (re[0][0], im[0][0]) = (rate.re, rate.im);
            1
        }
    };
    if re.iter().flatten().any(|v| !v.is_finite()) {
        return Err("the law has no finite answer for a wave".into());
    }
    let scale = re.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
    if im.iter().flatten().all(|v| v.abs() <= 1e-12 * scale) {
        im = [[0.0; 3]; 3];
    }
    Ok(Hermitian::part(size, re, im).0)
}

/// `M(k)/k^2` of ever longer waves [N/m^2], of a field [m^2/s]: the local law, whose waves all run at one speed.
///
/// # Errors
/// What the oracle cannot answer.
pub fn local(
    subject: &Subject,
    flavour: Flavour,
    moving: Moving,
    n: [f64; 3],
) -> Result<Hermitian, String> {
    let at = |z: f64| {
        let k = z / subject.horizon;
        let m = matrix(subject, flavour, moving, n, k)?;
        Ok::<Hermitian, String>(Hermitian {
            re: m.re.map(|row| row.map(|v| v / (k * k))),
            ..m
        })
    };
    // The error falls with the square of the wave number: extrapolated.
    let (coarse, fine) = (at(LONG)?, at(0.5 * LONG)?);
    let mut limit = fine;
    for a in 0..3 {
        for b in 0..3 {
            limit.re[a][b] = (4.0 * fine.re[a][b] - coarse.re[a][b]) / 3.0;
        }
    }
    limit.im = [[0.0; 3]; 3];
    Ok(limit)
}

/// A quadrature over the horizon for waves of `z = k delta` along `n`.
fn family(flavour: Flavour, horizon: f64, n: [f64; 3], z: f64) -> Vec<Point> {
    let cross = cross(flavour);
    let radial = radial(z);
    let dim = flavour.dim();
    let directions: Vec<Point> = match dim {
        1 => vec![([1.0, 0.0, 0.0], 1.0), ([-1.0, 0.0, 0.0], 1.0)],
        2 => {
            let half = 12 + (0.6 * z) as usize;
            let turn = |k: usize| PI * k as f64 / half as f64;
            let at = |k: usize| {
                let (sin, cos) = (turn(k) + 0.3).sin_cos();
                (
                    [n[0] * cos - n[1] * sin, n[1] * cos + n[0] * sin, 0.0],
                    PI / half as f64,
                )
            };
            (0..half).map(at).flat_map(both).collect()
        }
        _ => about(n, 7 + (0.6 * z) as usize),
    };
    let mut points = Vec::new();
    for (t, w) in &radial {
        // r = horizon t^2, for influence functions without a bound at 0.
        let (r, dr) = (horizon * t * t, 2.0 * horizon * t * w);
        for (m, part) in &directions {
            let volume = part * r.powi(dim as i32 - 1) * dr * cross;
            points.push((m.map(|c| r * c), volume));
        }
    }
    points
}

/// Places and weights of the root of the length over the horizon: close to the node, where influence functions are
/// steep, and beyond a sixteenth of the horizon.
fn radial(z: f64) -> Vec<(f64, f64)> {
    const CLOSE: f64 = 0.25;
    let near = gauss(9).into_iter().map(|(t, w)| (CLOSE * t, CLOSE * w));
    let far = gauss(14 + (0.6 * z) as usize).into_iter();
    let far = far.map(|(t, w)| (CLOSE + (1.0 - CLOSE) * t, (1.0 - CLOSE) * w));
    near.chain(far).collect()
}

/// A direction and its opposite.
fn both((m, w): Point) -> [Point; 2] {
    [(m, w), (m.map(|c| -c), w)]
}

/// Directions of space about an axis.
fn about(n: [f64; 3], polar: usize) -> Vec<Point> {
    let across = if n[0].abs() < 0.6 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let product = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let first = product(n, across);
    let length = first.iter().map(|c| c * c).sum::<f64>().sqrt();
    let first = first.map(|c| c / length);
    let second = product(n, first);
    let mut half = Vec::new();
    // The upper half of the sphere; `both` adds the lower one.
    for (t, w) in gauss(polar) {
        let (cos, sin) = (t, (1.0 - t * t).max(0.0).sqrt());
        for j in 0..AROUND {
            let (s, c) = (TAU * (j as f64 + 0.3) / AROUND as f64).sin_cos();
            let m = std::array::from_fn(|a| cos * n[a] + sin * (c * first[a] + s * second[a]));
            half.push((m, w * TAU / AROUND as f64));
        }
    }
    half.into_iter().flat_map(both).collect()
}
