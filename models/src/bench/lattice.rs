//! Lattice kernels in AVX-512 intrinsics: rows of eight nodes, a stencil table, one mask byte per row.
use super::elastic;
use super::scene::{DX, HORIZON};
use super::twin::Elastic;
use std::arch::x86_64::*;

/// Slots before the first row: eight nodes look as far as the horizon.
const BEFORE: usize = 16;

/// One stencil entry, its values in the order of use.
#[repr(C)]
struct Entry {
    offset: isize,
    xi: [f64; 3],
    ix: f64,
    /// Of y^2.
    limit: f64,
    /// c w (PMB), omega w x^2 and omega w x (LPS), c w/x (heat), w (correspondence).
    pmb: f64,
    lps: [f64; 2],
    heat: f64,
    w: f64,
}

/// The scene in a box, x fastest, padded in the other directions: the slot behind the end of a row is the first of the next.
pub struct Twin {
    n: usize,
    reach: usize,
    entries: Vec<Entry>,
    /// First slot of every chunk; one byte per chunk and entry.
    chunks: Vec<usize>,
    bits: Vec<u8>,
    pub u: [Vec<f64>; 3],
    pub f: [Vec<f64>; 3],
    /// LPS: A = (3K - 5G) theta / m, B = 15 G / m, q = 3 (3K - 5G) / m^2.
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    pub q: Vec<f64>,
    /// Correspondence: inverse shape tensor and stabilisation, and the state of the nodes.
    shape: [Vec<f64>; 6],
    penalty: Vec<f64>,
    state: [Vec<f64>; 9],
}

impl Twin {
    /// `c`: constant of PMB or of heat conduction; `s0`: critical stretch. The processor must have AVX-512.
    pub fn new(n: usize, c: f64, s0: f64) -> Twin {
        assert!(is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq"));
        let reach = (HORIZON / DX) as usize;
        let side = n + 2 * reach;
        let len = side * side * n + BEFORE + 8 + reach;
        let zero = || vec![0.0; len];
        let mut t = Twin {
            n,
            reach,
            entries: vec![],
            chunks: vec![],
            bits: vec![],
            u: [zero(), zero(), zero()],
            f: [zero(), zero(), zero()],
            a: zero(),
            b: zero(),
            q: zero(),
            shape: std::array::from_fn(|_| zero()),
            penalty: zero(),
            state: std::array::from_fn(|_| zero()),
        };
        t.stencil(c, s0);
        t.masks();
        t
    }

    /// Slot of a cell.
    pub fn slot(&self, cell: [usize; 3]) -> usize {
        let [i, j, k] = cell;
        ((k + self.reach) * (self.n + 2 * self.reach) + j + self.reach) * self.n + BEFORE + i
    }

    fn stencil(&mut self, c: f64, s0: f64) {
        let h = self.reach as isize;
        let volume = DX.powi(3);
        for k in -h..=h {
            for j in -h..=h {
                for i in -h..=h {
                    let xi = [i, j, k].map(|c| c as f64 * DX);
                    let r2 = xi[2].mul_add(xi[2], xi[1].mul_add(xi[1], xi[0] * xi[0]));
                    let x = (xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]).sqrt();
                    if x == 0.0 || x > HORIZON {
                        continue;
                    }
                    let inside = x <= HORIZON - 0.5 * DX;
                    let w = if inside {
                        volume
                    } else {
                        (HORIZON + 0.5 * DX - x) / DX * volume
                    };
                    self.entries.push(Entry {
                        offset: (k * (self.n as isize + 2 * h) + j) * self.n as isize + i,
                        xi,
                        // SAFETY: checked in `new`.
                        ix: unsafe { reciprocal_root(r2) },
                        limit: (x * x) * ((1.0 + s0) * (1.0 + s0)),
                        pmb: w * c,
                        lps: [w * x, w],
                        heat: w * c / x,
                        w,
                    });
                }
            }
        }
    }

    /// The cell of a slot, of which some are beside the box.
    fn cell(&self, slot: usize) -> Option<[isize; 3]> {
        let (n, h, at) = (self.n, self.reach, slot.checked_sub(BEFORE)?);
        let side = n + 2 * h;
        let cell = [at % n, at / n % side, at / n / side].map(|c| c as isize);
        let cell = [cell[0], cell[1] - h as isize, cell[2] - h as isize];
        cell.iter()
            .all(|c| (0..n as isize).contains(c))
            .then_some(cell)
    }

    /// Eight slots after the other, of which one is a node at least.
    fn masks(&mut self) {
        let (n, h) = (self.n as isize, self.reach as isize);
        let inside = |c: isize| (0..n).contains(&c);
        for first in (BEFORE..self.a.len() - 8).step_by(8) {
            let cells: [_; 8] = std::array::from_fn(|lane| self.cell(first + lane));
            if cells.iter().all(Option::is_none) {
                continue;
            }
            self.chunks.push(first);
            for dk in -h..=h {
                for dj in -h..=h {
                    for di in -h..=h {
                        let r = ((di * di + dj * dj + dk * dk) as f64).sqrt() * DX;
                        if r == 0.0 || r > HORIZON {
                            continue;
                        }
                        let there = |cell: &Option<[isize; 3]>| {
                            cell.is_some_and(|[i, j, k]| {
                                inside(i + di) && inside(j + dj) && inside(k + dk)
                            })
                        };
                        let lanes = cells.iter().enumerate();
                        let lanes = lanes.map(|(lane, cell)| u8::from(there(cell)) << lane);
                        self.bits.push(lanes.sum());
                    }
                }
            }
        }
    }

    /// PMB with breaking.
    pub fn pmb(&mut self) {
        // SAFETY: checked in `new`; offsets of the stencil stay inside the padded box.
        unsafe { self.pmb_avx512() }
    }

    /// LPS: dilatation (with breaking), then force.
    pub fn lps(&mut self) {
        // SAFETY: as above.
        unsafe {
            self.dilatation_avx512();
            self.force_avx512();
        }
    }

    /// Heat: the rate in `f[0]` of the temperature in `u[0]`, but for the factor `q`.
    pub fn heat(&mut self) {
        // SAFETY: as above.
        unsafe { self.heat_avx512() }
    }

    /// What correspondence takes from whole families.
    pub fn set_up(&mut self, e: &Elastic) {
        for (c, &at) in self.chunks.iter().enumerate() {
            for lane in 0..8 {
                let (mut shape, mut count) = ([0.0; 6], 0.0);
                for (k, entry) in self.entries.iter().enumerate() {
                    if self.bits[c * self.entries.len() + k] >> lane & 1 == 1 {
                        let [x, y, z] = entry.xi;
                        let products = [x * x, x * y, x * z, y * y, y * z, z * z];
                        (0..6).for_each(|m| shape[m] += entry.w * products[m]);
                        count += 1.0;
                    }
                }
                if count > 0.0 {
                    let inverse = elastic::inverse(shape);
                    (0..6).for_each(|m| self.shape[m][at + lane] = inverse[m]);
                    self.penalty[at + lane] = e.penalty / count;
                }
            }
        }
    }

    /// Stabilised correspondence: displacement gradient (with breaking) and stress, then force.
    pub fn correspondence(&mut self, e: &Elastic) {
        // SAFETY: as above.
        unsafe {
            self.gradient_avx512(e);
            self.pull_avx512();
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn heat_avx512(&mut self) {
        unsafe {
            let t = self.u[0].as_ptr();
            let mut bits = self.bits.as_ptr();
            let first = self.entries.as_ptr();
            let end = first.add(self.entries.len());
            for &at in &self.chunks {
                let ti = load(t, at);
                let mut sum = _mm512_setzero_pd();
                let mut e = first;
                while e != end {
                    let other = at.wrapping_add_signed((*e).offset);
                    let d = _mm512_maskz_sub_pd(*bits, load(t, other), ti);
                    sum = _mm512_fmadd_pd(_mm512_set1_pd((*e).heat), d, sum);
                    e = e.add(1);
                    bits = bits.add(1);
                }
                let rate = _mm512_mul_pd(sum, load(self.q.as_ptr(), at));
                _mm512_storeu_pd(self.f[0].as_mut_ptr().add(at), rate);
            }
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn gradient_avx512(&mut self, material: &Elastic) {
        unsafe {
            let u = [self.u[0].as_ptr(), self.u[1].as_ptr(), self.u[2].as_ptr()];
            let mut bits = self.bits.as_mut_ptr();
            let first = self.entries.as_ptr();
            let end = first.add(self.entries.len());
            for &at in &self.chunks {
                let ui = [load(u[0], at), load(u[1], at), load(u[2], at)];
                let mut s = [_mm512_setzero_pd(); 9];
                let mut e = first;
                while e != end {
                    let (_, square) = deformed(&u, &ui, at, e);
                    let mut k = *bits;
                    let limit = _mm512_set1_pd((*e).limit);
                    let dead = _mm512_mask_cmp_pd_mask::<_CMP_LT_OQ>(k, limit, square);
                    if dead != 0 {
                        k &= !dead;
                        *bits = k;
                    }
                    let other = at.wrapping_add_signed((*e).offset);
                    let w = _mm512_set1_pd((*e).w);
                    let mut a = 0;
                    while a < 3 {
                        let eta = _mm512_sub_pd(load(u[a], other), ui[a]);
                        let eta = _mm512_maskz_mul_pd(k, w, eta);
                        let mut b = 0;
                        while b < 3 {
                            let xi = _mm512_set1_pd((*e).xi[b]);
                            s[3 * a + b] = _mm512_fmadd_pd(eta, xi, s[3 * a + b]);
                            b += 1;
                        }
                        a += 1;
                    }
                    e = e.add(1);
                    bits = bits.add(1);
                }
                let shape = std::array::from_fn(|m| load(self.shape[m].as_ptr(), at));
                let c = load(self.penalty.as_ptr(), at);
                let state = elastic::state(&s, &shape, c, material);
                for (to, value) in self.state.iter_mut().zip(state) {
                    _mm512_storeu_pd(to.as_mut_ptr().add(at), value);
                }
            }
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn pull_avx512(&mut self) {
        unsafe {
            let u = [self.u[0].as_ptr(), self.u[1].as_ptr(), self.u[2].as_ptr()];
            let state: [*const f64; 9] = std::array::from_fn(|k| self.state[k].as_ptr());
            let penalty = self.penalty.as_ptr();
            let mut bits = self.bits.as_ptr();
            let first = self.entries.as_ptr();
            let end = first.add(self.entries.len());
            for &at in &self.chunks {
                let ui = [load(u[0], at), load(u[1], at), load(u[2], at)];
                let own: [__m512d; 9] = std::array::from_fn(|k| load(state[k], at));
                let ci = load(penalty, at);
                let mut f = [_mm512_setzero_pd(); 3];
                let mut e = first;
                while e != end {
                    let other = at.wrapping_add_signed((*e).offset);
                    let c = _mm512_add_pd(ci, load(penalty, other));
                    let w = _mm512_set1_pd((*e).w);
                    let mut a = 0;
                    while a < 3 {
                        let eta = _mm512_sub_pd(load(u[a], other), ui[a]);
                        let mut t = _mm512_mul_pd(c, eta);
                        let mut b = 0;
                        while b < 3 {
                            let both = _mm512_add_pd(own[3 * a + b], load(state[3 * a + b], other));
                            t = _mm512_fmadd_pd(both, _mm512_set1_pd((*e).xi[b]), t);
                            b += 1;
                        }
                        f[a] = _mm512_mask3_fmadd_pd(w, t, f[a], *bits);
                        a += 1;
                    }
                    e = e.add(1);
                    bits = bits.add(1);
                }
                for (to, value) in self.f.iter_mut().zip(f) {
                    _mm512_storeu_pd(to.as_mut_ptr().add(at), value);
                }
            }
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn pmb_avx512(&mut self) {
        unsafe {
            let u = [self.u[0].as_ptr(), self.u[1].as_ptr(), self.u[2].as_ptr()];
            let mut bits = self.bits.as_mut_ptr();
            let first = self.entries.as_ptr();
            let end = first.add(self.entries.len());
            for &at in &self.chunks {
                let ui = [load(u[0], at), load(u[1], at), load(u[2], at)];
                let mut f = [_mm512_setzero_pd(); 3];
                let mut e = first;
                while e != end {
                    let (y, square) = deformed(&u, &ui, at, e);
                    let iy = root(square);
                    let mut k = *bits;
                    let dead = _mm512_mask_cmp_pd_mask::<_CMP_LT_OQ>(
                        k,
                        _mm512_set1_pd((*e).limit),
                        square,
                    );
                    if dead != 0 {
                        k &= !dead;
                        *bits = k;
                    }
                    let d = _mm512_maskz_sub_pd(k, _mm512_set1_pd((*e).ix), iy);
                    let t = _mm512_mul_pd(_mm512_set1_pd((*e).pmb), d);
                    f[0] = _mm512_fmadd_pd(t, y[0], f[0]);
                    f[1] = _mm512_fmadd_pd(t, y[1], f[1]);
                    f[2] = _mm512_fmadd_pd(t, y[2], f[2]);
                    e = e.add(1);
                    bits = bits.add(1);
                }
                _mm512_storeu_pd(self.f[0].as_mut_ptr().add(at), f[0]);
                _mm512_storeu_pd(self.f[1].as_mut_ptr().add(at), f[1]);
                _mm512_storeu_pd(self.f[2].as_mut_ptr().add(at), f[2]);
            }
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn dilatation_avx512(&mut self) {
        unsafe {
            let u = [self.u[0].as_ptr(), self.u[1].as_ptr(), self.u[2].as_ptr()];
            let mut bits = self.bits.as_mut_ptr();
            let first = self.entries.as_ptr();
            let end = first.add(self.entries.len());
            for &at in &self.chunks {
                let ui = [load(u[0], at), load(u[1], at), load(u[2], at)];
                let mut sum = _mm512_setzero_pd();
                let mut e = first;
                while e != end {
                    let (_, square) = deformed(&u, &ui, at, e);
                    let iy = root(square);
                    let mut k = *bits;
                    let dead = _mm512_mask_cmp_pd_mask::<_CMP_LT_OQ>(
                        k,
                        _mm512_set1_pd((*e).limit),
                        square,
                    );
                    if dead != 0 {
                        k &= !dead;
                        *bits = k;
                    }
                    let d = _mm512_sub_pd(_mm512_set1_pd((*e).ix), iy);
                    let y = _mm512_mul_pd(square, iy);
                    let extension = _mm512_maskz_mul_pd(k, y, d);
                    sum = _mm512_fmadd_pd(_mm512_set1_pd((*e).lps[0]), extension, sum);
                    e = e.add(1);
                    bits = bits.add(1);
                }
                let a = _mm512_mul_pd(sum, load(self.q.as_ptr(), at));
                _mm512_storeu_pd(self.a.as_mut_ptr().add(at), a);
            }
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn force_avx512(&mut self) {
        unsafe {
            let u = [self.u[0].as_ptr(), self.u[1].as_ptr(), self.u[2].as_ptr()];
            let (pa, pb) = (self.a.as_ptr(), self.b.as_ptr());
            let mut bits = self.bits.as_ptr();
            let first = self.entries.as_ptr();
            let end = first.add(self.entries.len());
            for &at in &self.chunks {
                let ui = [load(u[0], at), load(u[1], at), load(u[2], at)];
                let (ai, bi) = (load(pa, at), load(pb, at));
                let mut f = [_mm512_setzero_pd(); 3];
                let mut e = first;
                while e != end {
                    let (y, square) = deformed(&u, &ui, at, e);
                    let iy = root(square);
                    let other = at.wrapping_add_signed((*e).offset);
                    let d = _mm512_sub_pd(_mm512_set1_pd((*e).ix), iy);
                    let t = _mm512_mul_pd(_mm512_add_pd(ai, load(pa, other)), iy);
                    let t = _mm512_fmadd_pd(_mm512_add_pd(bi, load(pb, other)), d, t);
                    let t = _mm512_maskz_mul_pd(*bits, _mm512_set1_pd((*e).lps[1]), t);
                    f[0] = _mm512_fmadd_pd(t, y[0], f[0]);
                    f[1] = _mm512_fmadd_pd(t, y[1], f[1]);
                    f[2] = _mm512_fmadd_pd(t, y[2], f[2]);
                    e = e.add(1);
                    bits = bits.add(1);
                }
                _mm512_storeu_pd(self.f[0].as_mut_ptr().add(at), f[0]);
                _mm512_storeu_pd(self.f[1].as_mut_ptr().add(at), f[1]);
                _mm512_storeu_pd(self.f[2].as_mut_ptr().add(at), f[2]);
            }
        }
    }
}

#[inline]
#[target_feature(enable = "avx512f")]
unsafe fn load(p: *const f64, at: usize) -> __m512d {
    unsafe { _mm512_loadu_pd(p.add(at)) }
}

/// Y = xi + (u_j - u_i), and |Y|^2.
#[inline]
#[target_feature(enable = "avx512f")]
unsafe fn deformed(
    u: &[*const f64; 3],
    ui: &[__m512d; 3],
    at: usize,
    e: *const Entry,
) -> ([__m512d; 3], __m512d) {
    unsafe {
        let other = at.wrapping_add_signed((*e).offset);
        let y0 = _mm512_add_pd(
            _mm512_set1_pd((*e).xi[0]),
            _mm512_sub_pd(load(u[0], other), ui[0]),
        );
        let y1 = _mm512_add_pd(
            _mm512_set1_pd((*e).xi[1]),
            _mm512_sub_pd(load(u[1], other), ui[1]),
        );
        let y2 = _mm512_add_pd(
            _mm512_set1_pd((*e).xi[2]),
            _mm512_sub_pd(load(u[2], other), ui[2]),
        );
        let square = _mm512_fmadd_pd(y2, y2, _mm512_fmadd_pd(y1, y1, _mm512_mul_pd(y0, y0)));
        ([y0, y1, y2], square)
    }
}

/// 1/sqrt(x): estimate and one step of fourth order.
#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn root(x: __m512d) -> __m512d {
    let y = _mm512_rsqrt14_pd(x);
    let e = _mm512_fnmadd_pd(_mm512_mul_pd(x, y), y, _mm512_set1_pd(1.0));
    let p = _mm512_fmadd_pd(e, _mm512_set1_pd(0.3125), _mm512_set1_pd(0.375));
    let p = _mm512_fmadd_pd(e, p, _mm512_set1_pd(0.5));
    _mm512_fmadd_pd(_mm512_mul_pd(y, e), p, y)
}

#[target_feature(enable = "avx512f")]
fn reciprocal_root(x: f64) -> f64 {
    _mm512_cvtsd_f64(root(_mm512_set1_pd(x)))
}
