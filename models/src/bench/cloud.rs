//! SELL-8 kernels in AVX-512 intrinsics: nodes in lanes, records loaded and transposed instead of gathered, one number
//! per bond, software prefetch.
use super::elastic;
use super::lattice::root;
use super::scene::{DX, HORIZON};
use super::twin::Elastic;
use std::arch::x86_64::*;

const AHEAD: usize = 24;
/// Cells to the farthest in which a neighbour may be: nodes are less than (REACH + 1 - HORIZON/DX)/2 from their centres.
const REACH: usize = 3;

/// A cube of nodes, a cell each, as neighbour lists over slots in a given order.
pub struct Twin {
    /// Columns `start[c]..start[c + 1]` of the block of nodes 8 c ..
    start: Vec<usize>,
    index: Vec<u32>,
    bits: Vec<u8>,
    /// (1 + s0)^2
    limit: f64,
    /// c w (PMB), omega w x^2 (LPS), c w/x (heat), w (correspondence).
    pmb: Vec<f64>,
    lps: Vec<f64>,
    heat: Vec<f64>,
    w: Vec<f64>,
    x: [Vec<f64>; 3],
    x_records: Vec<Record>,
    u_records: Vec<Record>,
    pub u: [Vec<f64>; 3],
    pub f: [Vec<f64>; 3],
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    pub q: Vec<f64>,
    /// Correspondence: inverse shape tensor and stabilisation; rows of the state, the stabilisation behind the first.
    shape: [Vec<f64>; 6],
    penalty: Vec<f64>,
    state: [Vec<Record>; 3],
}

impl Twin {
    /// `nodes`: positions, of node (i, j, k) at i + n (j + n k), less than 0.49 spacings from its cell's centre in each direction; `slot`:
    /// their slots; `len`: length of node arrays.
    pub fn new(nodes: &[[f64; 3]], slot: &[u32], len: usize, c: f64, s0: f64) -> Twin {
        let n = (nodes.len() as f64).cbrt().round() as usize;
        assert!(is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq"));
        let zero = || vec![0.0; len];
        let mut t = Twin {
            start: vec![0],
            index: vec![],
            bits: vec![],
            limit: (1.0 + s0) * (1.0 + s0),
            pmb: vec![],
            lps: vec![],
            heat: vec![],
            w: vec![],
            x: [zero(), zero(), zero()],
            x_records: vec![Record([0.0; 4]); len],
            u_records: vec![Record([0.0; 4]); len],
            u: [zero(), zero(), zero()],
            f: [zero(), zero(), zero()],
            a: zero(),
            b: zero(),
            q: zero(),
            shape: std::array::from_fn(|_| zero()),
            penalty: zero(),
            state: std::array::from_fn(|_| vec![Record([0.0; 4]); len]),
        };
        // Slots that no node has repeat node 0; nothing reads them.
        let slots = slot.iter().max().map_or(0, |last| *last as usize + 1);
        let mut cell = vec![[0usize; 3]; slots.next_multiple_of(8)];
        for (node, &s) in slot.iter().enumerate() {
            cell[s as usize] = [node % n, node / n % n, node / n / n];
            for a in 0..3 {
                t.x[a][s as usize] = nodes[node][a];
            }
        }
        pack(&t.x, &mut t.x_records);
        for block in cell.chunks(8).enumerate() {
            t.block(n, nodes, slot, block.0 * 8, block.1, c);
        }
        t
    }

    fn block(
        &mut self,
        n: usize,
        nodes: &[[f64; 3]],
        slot: &[u32],
        first: usize,
        cells: &[[usize; 3]],
        c: f64,
    ) {
        let lists: Vec<Vec<u32>> = cells
            .iter()
            .map(|&cell| neighbours(n, nodes, slot, cell))
            .collect();
        let columns = lists.iter().map(Vec::len).max().unwrap_or(0);
        for column in 0..columns {
            let mut byte = 0u8;
            for lane in 0..8 {
                let list = lists.get(lane).map_or(&[][..], |l| l);
                let there = column < list.len();
                byte |= (there as u8) << lane;
                let j = list
                    .get(column)
                    .or(list.last())
                    .map_or(first as u32, |j| *j) as usize;
                self.index.push(j as u32);
                self.geometry(first + lane, j, there, c);
            }
            self.bits.push(byte);
        }
        self.start.push(self.bits.len());
    }

    fn geometry(&mut self, i: usize, j: usize, there: bool, c: f64) {
        let xi = [0, 1, 2].map(|a| self.x[a][j] - self.x[a][i]);
        let x = (xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]).sqrt();
        let inside = x <= HORIZON - 0.5 * DX;
        let volume = DX.powi(3);
        let w = if inside {
            volume
        } else {
            (HORIZON + 0.5 * DX - x) / DX * volume
        };
        let w = if there { w } else { 0.0 };
        self.pmb.push(w * c);
        self.lps.push(w * x);
        // A lane of a node without bonds may name its own node.
        self.heat.push(if x > 0.0 { w * c / x } else { 0.0 });
        self.w.push(w);
    }

    /// Heat: the rate in `f[0]` of the temperature in `u[0]`, but for the factor `q`.
    pub fn heat(&mut self) {
        // SAFETY: checked in `new`; indices are slots.
        unsafe { self.heat_avx512() }
    }

    /// What correspondence takes from whole families.
    pub fn set_up(&mut self, e: &Elastic) {
        for c in 0..self.start.len() - 1 {
            for lane in 0..8 {
                let (node, mut shape, mut count) = (8 * c + lane, [0.0; 6], 0.0);
                for row in self.start[c]..self.start[c + 1] {
                    if self.bits[row] >> lane & 1 == 1 {
                        let j = self.index[8 * row + lane] as usize;
                        let [x, y, z] = [0, 1, 2].map(|a| self.x[a][j] - self.x[a][node]);
                        let products = [x * x, x * y, x * z, y * y, y * z, z * z];
                        (0..6).for_each(|m| shape[m] += self.w[8 * row + lane] * products[m]);
                        count += 1.0;
                    }
                }
                if count > 0.0 {
                    let inverse = elastic::inverse(shape);
                    (0..6).for_each(|m| self.shape[m][node] = inverse[m]);
                    self.penalty[node] = e.penalty / count;
                }
            }
        }
    }

    /// Stabilised correspondence: displacement gradient (with breaking) and stress, then force.
    pub fn correspondence(&mut self, e: &Elastic) {
        // SAFETY: as above.
        pack(&self.u, &mut self.u_records);
        unsafe {
            self.gradient_avx512(e);
            self.pull_avx512();
        }
    }

    /// PMB with breaking.
    pub fn pmb(&mut self) {
        // SAFETY: checked in `new`; indices are slots.
        pack(&self.u, &mut self.u_records);
        unsafe { self.pmb_avx512() }
    }

    /// LPS: dilatation (with breaking), then force.
    pub fn lps(&mut self) {
        // SAFETY: as above.
        pack(&self.u, &mut self.u_records);
        unsafe {
            self.dilatation_avx512();
            self.force_avx512();
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn heat_avx512(&mut self) {
        unsafe {
            let t = self.u[0].as_ptr();
            for c in 0..self.start.len() - 1 {
                let at = 8 * c;
                let ti = _mm512_loadu_pd(t.add(at));
                let mut sum = _mm512_setzero_pd();
                for row in self.start[c]..self.start[c + 1] {
                    let index = self.index.as_ptr().add(8 * row);
                    _mm_prefetch::<_MM_HINT_T0>(index.wrapping_add(8 * AHEAD).cast());
                    let bits = *self.bits.as_ptr().add(row);
                    let d = _mm512_maskz_sub_pd(bits, gather(t, index), ti);
                    sum = _mm512_fmadd_pd(stream(&self.heat, row), d, sum);
                }
                let rate = _mm512_mul_pd(sum, _mm512_loadu_pd(self.q.as_ptr().add(at)));
                _mm512_storeu_pd(self.f[0].as_mut_ptr().add(at), rate);
            }
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn gradient_avx512(&mut self, material: &Elastic) {
        unsafe {
            let (x, u) = (self.x_records.as_ptr(), self.u_records.as_ptr());
            let bits = self.bits.as_mut_ptr();
            let limit = _mm512_set1_pd(self.limit);
            for c in 0..self.start.len() - 1 {
                let at = 8 * c;
                let (xi, ui) = (own(x, at), own(u, at));
                let mut s = [_mm512_setzero_pd(); 9];
                for row in self.start[c]..self.start[c + 1] {
                    let bond = bond(x, u, &xi, &ui, self.index.as_ptr().add(8 * row));
                    let mut k = *bits.add(row);
                    let longest = _mm512_mul_pd(limit, bond.reference);
                    let dead = _mm512_mask_cmp_pd_mask::<_CMP_LT_OQ>(k, longest, bond.square);
                    if dead != 0 {
                        k &= !dead;
                        *bits.add(row) = k;
                    }
                    let w = stream(&self.w, row);
                    let mut a = 0;
                    while a < 3 {
                        let eta = _mm512_maskz_mul_pd(k, w, bond.eta[a]);
                        let mut b = 0;
                        while b < 3 {
                            s[3 * a + b] = _mm512_fmadd_pd(eta, bond.xi[b], s[3 * a + b]);
                            b += 1;
                        }
                        a += 1;
                    }
                }
                let load = |v: &Vec<f64>| _mm512_loadu_pd(v.as_ptr().add(at));
                let shape = std::array::from_fn(|m| load(&self.shape[m]));
                let penalty = load(&self.penalty);
                let state = elastic::state(&s, &shape, penalty, material);
                for (a, to) in self.state.iter_mut().enumerate() {
                    let rows = [state[3 * a], state[3 * a + 1], state[3 * a + 2], penalty];
                    let rows = rows.map(|v| {
                        let mut lanes = [0.0; 8];
                        _mm512_storeu_pd(lanes.as_mut_ptr(), v);
                        lanes
                    });
                    for lane in 0..8 {
                        to[at + lane].0 = [0, 1, 2, 3].map(|k| rows[k][lane]);
                    }
                }
            }
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn pull_avx512(&mut self) {
        unsafe {
            let (x, u) = (self.x_records.as_ptr(), self.u_records.as_ptr());
            let state = [0, 1, 2].map(|a| self.state[a].as_ptr());
            for c in 0..self.start.len() - 1 {
                let at = 8 * c;
                let (xi, ui) = (own(x, at), own(u, at));
                let mine = [own(state[0], at), own(state[1], at), own(state[2], at)];
                let ci = _mm512_loadu_pd(self.penalty.as_ptr().add(at));
                let mut f = [_mm512_setzero_pd(); 3];
                for row in self.start[c]..self.start[c + 1] {
                    let index = self.index.as_ptr().add(8 * row);
                    let bond = bond(x, u, &xi, &ui, index);
                    let w = stream(&self.w, row);
                    let bits = *self.bits.as_ptr().add(row);
                    let (first, cj) = four(state[0], index);
                    let far = [
                        first,
                        components(state[1], index),
                        components(state[2], index),
                    ];
                    let c = _mm512_add_pd(ci, cj);
                    let mut a = 0;
                    while a < 3 {
                        let mut t = _mm512_mul_pd(c, bond.eta[a]);
                        let mut b = 0;
                        while b < 3 {
                            let both = _mm512_add_pd(mine[a][b], far[a][b]);
                            t = _mm512_fmadd_pd(both, bond.xi[b], t);
                            b += 1;
                        }
                        f[a] = _mm512_mask3_fmadd_pd(w, t, f[a], bits);
                        a += 1;
                    }
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
            let (x, u) = (self.x_records.as_ptr(), self.u_records.as_ptr());
            let bits = self.bits.as_mut_ptr();
            let limit = _mm512_set1_pd(self.limit);
            for c in 0..self.start.len() - 1 {
                let at = 8 * c;
                let (xi, ui) = (own(x, at), own(u, at));
                let mut f = [_mm512_setzero_pd(); 3];
                for row in self.start[c]..self.start[c + 1] {
                    let (y, square, reference) =
                        deformed(x, u, &xi, &ui, self.index.as_ptr().add(8 * row));
                    let (ix, iy) = (root(reference), root(square));
                    let mut k = *bits.add(row);
                    let longest = _mm512_mul_pd(limit, reference);
                    let dead = _mm512_mask_cmp_pd_mask::<_CMP_LT_OQ>(k, longest, square);
                    if dead != 0 {
                        k &= !dead;
                        *bits.add(row) = k;
                    }
                    let d = _mm512_maskz_sub_pd(k, ix, iy);
                    let t = _mm512_mul_pd(stream(&self.pmb, row), d);
                    f[0] = _mm512_fmadd_pd(t, y[0], f[0]);
                    f[1] = _mm512_fmadd_pd(t, y[1], f[1]);
                    f[2] = _mm512_fmadd_pd(t, y[2], f[2]);
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
            let (x, u) = (self.x_records.as_ptr(), self.u_records.as_ptr());
            let bits = self.bits.as_mut_ptr();
            let limit = _mm512_set1_pd(self.limit);
            for c in 0..self.start.len() - 1 {
                let at = 8 * c;
                let (xi, ui) = (own(x, at), own(u, at));
                let mut sum = _mm512_setzero_pd();
                for row in self.start[c]..self.start[c + 1] {
                    let (_, square, reference) =
                        deformed(x, u, &xi, &ui, self.index.as_ptr().add(8 * row));
                    let (ix, iy) = (root(reference), root(square));
                    let mut k = *bits.add(row);
                    let longest = _mm512_mul_pd(limit, reference);
                    let dead = _mm512_mask_cmp_pd_mask::<_CMP_LT_OQ>(k, longest, square);
                    if dead != 0 {
                        k &= !dead;
                        *bits.add(row) = k;
                    }
                    let d = _mm512_sub_pd(ix, iy);
                    let y = _mm512_mul_pd(square, iy);
                    let extension = _mm512_maskz_mul_pd(k, y, d);
                    sum = _mm512_fmadd_pd(stream(&self.lps, row), extension, sum);
                }
                let a = _mm512_mul_pd(sum, _mm512_loadu_pd(self.q.as_ptr().add(at)));
                _mm512_storeu_pd(self.a.as_mut_ptr().add(at), a);
            }
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn force_avx512(&mut self) {
        unsafe {
            let (x, u) = (self.x_records.as_ptr(), self.u_records.as_ptr());
            let (pa, pb) = (self.a.as_ptr(), self.b.as_ptr());
            for c in 0..self.start.len() - 1 {
                let at = 8 * c;
                let (xi, ui) = (own(x, at), own(u, at));
                let (ai, bi) = (_mm512_loadu_pd(pa.add(at)), _mm512_loadu_pd(pb.add(at)));
                let mut f = [_mm512_setzero_pd(); 3];
                for row in self.start[c]..self.start[c + 1] {
                    let index = self.index.as_ptr().add(8 * row);
                    let (y, square, reference) = deformed(x, u, &xi, &ui, index);
                    let (ix, iy) = (root(reference), root(square));
                    let d = _mm512_sub_pd(ix, iy);
                    let aj = gather(pa, index);
                    let bj = gather(pb, index);
                    let t = _mm512_mul_pd(_mm512_add_pd(ai, aj), iy);
                    let t = _mm512_fmadd_pd(_mm512_add_pd(bi, bj), d, t);
                    let t = _mm512_maskz_mul_pd(
                        *self.bits.as_ptr().add(row),
                        _mm512_mul_pd(stream(&self.lps, row), ix),
                        t,
                    );
                    f[0] = _mm512_fmadd_pd(t, y[0], f[0]);
                    f[1] = _mm512_fmadd_pd(t, y[1], f[1]);
                    f[2] = _mm512_fmadd_pd(t, y[2], f[2]);
                }
                _mm512_storeu_pd(self.f[0].as_mut_ptr().add(at), f[0]);
                _mm512_storeu_pd(self.f[1].as_mut_ptr().add(at), f[1]);
                _mm512_storeu_pd(self.f[2].as_mut_ptr().add(at), f[2]);
            }
        }
    }
}

/// Slots within the horizon, in the order of where they lie.
fn neighbours(n: usize, nodes: &[[f64; 3]], slot: &[u32], cell: [usize; 3]) -> Vec<u32> {
    let mut list = vec![];
    let node = |[i, j, k]: [usize; 3]| i + n * (j + n * k);
    let here = node(cell);
    let range = |c: usize| c.saturating_sub(REACH)..(c + REACH + 1).min(n);
    for k in range(cell[2]) {
        for j in range(cell[1]) {
            for i in range(cell[0]) {
                let there = node([i, j, k]);
                let square = |a: usize| (nodes[there][a] - nodes[here][a]).powi(2);
                let distance = (square(0) + square(1) + square(2)).sqrt();
                if there != here && distance <= HORIZON {
                    list.push(slot[there]);
                }
            }
        }
    }
    list
}

/// Three components of a node in half a cache line.
#[derive(Clone)]
#[repr(C, align(32))]
struct Record([f64; 4]);

fn pack(v: &[Vec<f64>; 3], records: &mut [Record]) {
    for (slot, r) in records.iter_mut().enumerate() {
        r.0 = [v[0][slot], v[1][slot], v[2][slot], 0.0];
    }
}

#[inline]
#[target_feature(enable = "avx512f")]
unsafe fn own(v: *const Record, at: usize) -> [__m512d; 3] {
    let index: [u32; 8] = std::array::from_fn(|k| (at + k) as u32);
    unsafe { components(v, index.as_ptr()) }
}

/// Components of eight records.
#[inline]
#[target_feature(enable = "avx512f")]
unsafe fn components(v: *const Record, index: *const u32) -> [__m512d; 3] {
    unsafe { four(v, index).0 }
}

/// Components of eight records, and what stands behind them.
#[inline]
#[target_feature(enable = "avx512f")]
unsafe fn four(v: *const Record, index: *const u32) -> ([__m512d; 3], __m512d) {
    unsafe {
        let mut r = [_mm512_setzero_pd(); 4];
        let mut k = 0;
        while k < 4 {
            let low = _mm256_load_pd(v.add(*index.add(k) as usize).cast());
            let high = _mm256_load_pd(v.add(*index.add(k + 4) as usize).cast());
            r[k] = _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high);
            k += 1;
        }
        let (even, even2) = (
            _mm512_unpacklo_pd(r[0], r[1]),
            _mm512_unpacklo_pd(r[2], r[3]),
        );
        let (odd, odd2) = (
            _mm512_unpackhi_pd(r[0], r[1]),
            _mm512_unpackhi_pd(r[2], r[3]),
        );
        let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        let first = [
            _mm512_permutex2var_pd(even, low, even2),
            _mm512_permutex2var_pd(odd, low, odd2),
            _mm512_permutex2var_pd(even, high, even2),
        ];
        (first, _mm512_permutex2var_pd(odd, high, odd2))
    }
}

/// Eight single values.
#[inline]
#[target_feature(enable = "avx512f,avx")]
unsafe fn gather(v: *const f64, index: *const u32) -> __m512d {
    unsafe {
        let mut pair = [_mm_setzero_pd(); 4];
        let mut k = 0;
        while k < 4 {
            let low = _mm_load_sd(v.add(*index.add(2 * k) as usize));
            pair[k] = _mm_loadh_pd(low, v.add(*index.add(2 * k + 1) as usize));
            k += 1;
        }
        let low = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(pair[0]), pair[1]);
        let high = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(pair[2]), pair[3]);
        _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high)
    }
}

/// Eight values of a row, the ones that come later fetched ahead.
#[inline]
#[target_feature(enable = "avx512f")]
unsafe fn stream(v: &[f64], row: usize) -> __m512d {
    unsafe {
        let p = v.as_ptr().add(8 * row);
        _mm_prefetch::<_MM_HINT_T0>(p.wrapping_add(8 * AHEAD).cast());
        _mm512_loadu_pd(p)
    }
}

/// Eight bonds, with |Y|^2 and |xi|^2.
struct Bonds {
    xi: [__m512d; 3],
    eta: [__m512d; 3],
    y: [__m512d; 3],
    square: __m512d,
    reference: __m512d,
}

#[inline]
#[target_feature(enable = "avx512f")]
unsafe fn bond(
    x: *const Record,
    u: *const Record,
    xi: &[__m512d; 3],
    ui: &[__m512d; 3],
    index: *const u32,
) -> Bonds {
    unsafe {
        _mm_prefetch::<_MM_HINT_T0>(index.wrapping_add(8 * AHEAD).cast());
        let (xj, uj) = (components(x, index), components(u, index));
        let (mut xi, mut eta, mut y) = (*xi, *ui, *ui);
        let mut a = 0;
        while a < 3 {
            xi[a] = _mm512_sub_pd(xj[a], xi[a]);
            eta[a] = _mm512_sub_pd(uj[a], ui[a]);
            y[a] = _mm512_add_pd(xi[a], eta[a]);
            a += 1;
        }
        let (square, reference) = (norm(&y), norm(&xi));
        Bonds {
            xi,
            eta,
            y,
            square,
            reference,
        }
    }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn norm(v: &[__m512d; 3]) -> __m512d {
    let two = _mm512_fmadd_pd(v[1], v[1], _mm512_mul_pd(v[0], v[0]));
    _mm512_fmadd_pd(v[2], v[2], two)
}

/// Y = xi + eta, |Y|^2, |xi|^2.
#[inline]
#[target_feature(enable = "avx512f")]
unsafe fn deformed(
    x: *const Record,
    u: *const Record,
    xi: &[__m512d; 3],
    ui: &[__m512d; 3],
    index: *const u32,
) -> ([__m512d; 3], __m512d, __m512d) {
    let bond = unsafe { bond(x, u, xi, ui, index) };
    (bond.y, bond.square, bond.reference)
}
