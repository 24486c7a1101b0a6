//! What the twins of stabilised correspondence do at a node, eight nodes at a time.
use super::twin::Elastic;
use std::arch::x86_64::*;

/// Components of a tensor, row by row.
pub(super) type Tensor = [__m512d; 9];

/// Inverse of a shape tensor, as (xx, xy, xz, yy, yz, zz).
pub(super) fn inverse([a, b, c, d, e, f]: [f64; 6]) -> [f64; 6] {
    let (xx, xy, xz) = (d * f - e * e, c * e - b * f, b * e - c * d);
    let det = a * xx + b * xy + c * xz;
    let (yy, yz, zz) = (a * f - c * c, b * c - a * e, a * d - b * b);
    [xx, xy, xz, yy, yz, zz].map(|m| m / det)
}

/// B = sigma K^-1 - c H of H = S K^-1, with the inverse shape tensor as six components: bond i -> j is pulled by
/// w ((B_i + B_j) xi + (c_i + c_j) eta).
#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn state(s: &Tensor, k: &[__m512d; 6], c: __m512d, e: &Elastic) -> Tensor {
    let full = [k[0], k[1], k[2], k[1], k[3], k[4], k[2], k[4], k[5]];
    let h = product(s, &full);
    let half = _mm512_set1_pd(0.5);
    let trace = _mm512_add_pd(h[0], _mm512_add_pd(h[4], h[8]));
    let pressure = _mm512_mul_pd(_mm512_set1_pd(e.lambda), trace);
    let twice = _mm512_set1_pd(2.0 * e.mu);
    let mut sigma = h;
    for a in 0..3 {
        for b in 0..3 {
            let share = if a == b {
                pressure
            } else {
                _mm512_setzero_pd()
            };
            let strain = _mm512_mul_pd(half, _mm512_add_pd(h[3 * a + b], h[3 * b + a]));
            sigma[3 * a + b] = _mm512_fmadd_pd(twice, strain, share);
        }
    }
    let p = product(&sigma, &full);
    let mut state = p;
    for (b, (p, h)) in state.iter_mut().zip(p.iter().zip(&h)) {
        *b = _mm512_fnmadd_pd(c, *h, *p);
    }
    state
}

#[inline]
#[target_feature(enable = "avx512f")]
fn product(p: &Tensor, q: &Tensor) -> Tensor {
    let mut out = *p;
    for a in 0..3 {
        for b in 0..3 {
            let first = _mm512_mul_pd(p[3 * a], q[b]);
            let second = _mm512_fmadd_pd(p[3 * a + 1], q[3 + b], first);
            out[3 * a + b] = _mm512_fmadd_pd(p[3 * a + 2], q[6 + b], second);
        }
    }
    out
}
