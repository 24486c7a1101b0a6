//! Velocity Verlet for the motion: passes over the arrays of the layout.
//!
//! A step is `v += dt/2 a; u += dt v; forces; v += dt/2 a`, as in LAMMPS and CabanaPD. Every pass treats each number
//! on its own, so the bits do not depend on the threads. Stretches where nothing moves and no force acts are left as
//! they are.

use crate::density::Density;
use rayon::prelude::*;

/// Numbers per task: a few pages, so that a task outweighs its start.
const CHUNK: usize = 8192;

/// `v += dt * f / density`.
pub fn kick(v: &mut [Vec<f64>], f: &[Vec<f64>], density: &Density, dt: f64) {
    for (v, f) in v.iter_mut().zip(f) {
        match density.slots() {
            None => add_scaled(v, f, dt / density.least()),
            Some(density) => v
                .par_chunks_mut(CHUNK)
                .zip(f.par_chunks(CHUNK).zip(density.par_chunks(CHUNK)))
                .for_each(|(v, (f, density))| {
                    let parts = f.iter().zip(density);
                    v.iter_mut()
                        .zip(parts)
                        .for_each(|(v, (f, d))| *v += dt / d * f);
                }),
        }
    }
}

/// `u += dt * v`. Returns a bound of the largest |dt v|: NaN when one of them is not finite.
pub fn drift(u: &mut [Vec<f64>], v: &[Vec<f64>], dt: f64) -> f64 {
    bound(u.iter_mut().zip(v).map(|(u, v)| {
        let chunks = u.par_chunks_mut(CHUNK).zip(v.par_chunks(CHUNK));
        chunks.map(|(u, v)| advance(u, v, dt)).reduce(|| 0.0, worse)
    }))
}

/// `v += dt/2 * f / density; u += dt * v`, in one pass over memory where nodes are alike; returns as [`drift`].
pub fn kick_and_drift(
    u: &mut [Vec<f64>],
    v: &mut [Vec<f64>],
    f: &[Vec<f64>],
    density: &Density,
    dt: f64,
) -> f64 {
    if density.slots().is_some() {
        kick(v, f, density, 0.5 * dt);
        return drift(u, v, dt);
    }
    let factor = 0.5 * dt / density.least();
    let step = |u: &mut [f64], v: &mut [f64], f: &[f64]| {
        let mut largest = 0.0;
        // Small enough that the second loop finds the velocities in the nearest cache.
        for ((u, v), f) in u.chunks_mut(512).zip(v.chunks_mut(512)).zip(f.chunks(512)) {
            if is_zero(v) && is_zero(f) {
                continue;
            }
            v.iter_mut().zip(f).for_each(|(v, f)| *v += factor * f);
            largest = worse(largest, advance(u, v, dt));
        }
        largest
    };
    bound(u.iter_mut().zip(v).zip(f).map(|((u, v), f)| {
        let chunks = u
            .par_chunks_mut(CHUNK)
            .zip(v.par_chunks_mut(CHUNK))
            .zip(f.par_chunks(CHUNK));
        chunks
            .map(|((u, v), f)| step(u, v, f))
            .reduce(|| 0.0, worse)
    }))
}

/// Whether all numbers are zero; looks no farther than the first that is not, sixteen at a time.
fn is_zero(values: &[f64]) -> bool {
    let zero = |v: &[f64]| v.iter().fold(0, |bits, v| bits | v.to_bits() << 1) == 0;
    values.chunks(16).all(zero)
}

/// `u += dt * v` and the largest |dt v|. Eight independent maxima and sums let the compiler use vectors; a sum
/// remembers what is not finite, which a maximum of floating-point numbers may forget.
#[inline]
fn advance(u: &mut [f64], v: &[f64], dt: f64) -> f64 {
    let (mut largest, mut sum) = ([0.0_f64; 8], [0.0_f64; 8]);
    let (whole, rest) = (u.len() / 8 * 8, u.len() % 8);
    for (u, v) in u[..whole].chunks_exact_mut(8).zip(v.chunks_exact(8)) {
        for k in 0..8 {
            let moved = dt * v[k];
            u[k] += moved;
            let size = moved.abs();
            largest[k] = if size > largest[k] { size } else { largest[k] };
            sum[k] += moved;
        }
    }
    for k in 0..rest {
        let moved = dt * v[whole + k];
        u[whole + k] += moved;
        largest[k] = worse(largest[k], moved.abs());
        sum[k] += moved;
    }
    let sound = sum.iter().all(|s| s.is_finite());
    if sound {
        largest.into_iter().fold(0.0, worse)
    } else {
        f64::NAN
    }
}

/// `x += factor * y`.
pub fn add_scaled(x: &mut [f64], y: &[f64], factor: f64) {
    let add = |(x, y): (&mut [f64], &[f64])| {
        for (x, y) in x.chunks_mut(512).zip(y.chunks(512)) {
            if !is_zero(y) {
                x.iter_mut().zip(y).for_each(|(x, y)| *x += factor * y);
            }
        }
    };
    let chunks = x.par_chunks_mut(CHUNK).zip(y.par_chunks(CHUNK));
    chunks.for_each(add);
}

/// The larger of two magnitudes; NaN beats everything.
#[inline]
fn worse(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

/// Length of the vector of the components' maxima.
fn bound(components: impl Iterator<Item = f64>) -> f64 {
    components.map(|c| c * c).sum::<f64>().sqrt()
}

/// Sums `K` numbers over `0..n` in one fixed order: within blocks, then over blocks.
pub fn total<const K: usize>(n: usize, term: impl Fn(usize) -> [f64; K] + Sync) -> [f64; K] {
    let block = |b: usize| {
        let mut sum = [0.0; K];
        for i in b * CHUNK..n.min((b + 1) * CHUNK) {
            add(&mut sum, term(i));
        }
        sum
    };
    let blocks: Vec<[f64; K]> = (0..n.div_ceil(CHUNK)).into_par_iter().map(block).collect();
    let mut sum = [0.0; K];
    blocks.into_iter().for_each(|b| add(&mut sum, b));
    sum
}

#[inline]
fn add<const K: usize>(sum: &mut [f64; K], term: [f64; K]) {
    sum.iter_mut().zip(term).for_each(|(s, t)| *s += t);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_is_not_lost_in_a_maximum() {
        let mut u = vec![vec![0.0; 3]];
        assert!(drift(&mut u, &[vec![1.0, f64::NAN, 2.0]], 0.1).is_nan());
        let mut v = vec![1.0; 20];
        v[9] = f64::INFINITY;
        assert!(drift(&mut [vec![0.0; 20]], &[v.clone()], 0.1).is_nan());
        v[9] = -7.0;
        let (mut u, mut v) = (vec![vec![1.0; 20]], vec![v]);
        assert_eq!(
            kick_and_drift(
                &mut u,
                &mut v,
                &[vec![4.0; 20]],
                &Density::uniform(2.0),
                2.0
            ),
            10.0
        );
        assert_eq!((u[0][9], u[0][19], v[0][19]), (-9.0, 7.0, 3.0));
        assert_eq!(
            drift(
                &mut vec![vec![0.0; 2]; 2],
                &[vec![3.0, 0.0], vec![0.0, -4.0]],
                1.0
            ),
            5.0
        );
    }

    #[test]
    fn totals_do_not_depend_on_threads() {
        let sum = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| total(100_000, |i| [(i as f64).sin(), 1.0]))
        };
        assert_eq!(sum(1), sum(3));
        assert_eq!(sum(2)[1], 1e5);
    }
}
