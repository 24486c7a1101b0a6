//! SELL-8 kernels in AVX-512 intrinsics: nodes in lanes, rows that lead to nodes side by side loaded from arrays, records
//! loaded and transposed instead of gathered in others, one number per bond (rows that repeat kept once), software prefetch.
mod loads;

use super::elastic;
use super::lattice::root;
use super::scene::{DX, HORIZON};
use super::twin::Elastic;
use loads::{Bonds, Numbers, Record, Stream, deformed, fetch, four, pack, single};
use std::arch::x86_64::*;

/// Most rows of runs for a row of lists.
const MOST: f64 = 1.6;
/// Cells to the farthest in which a neighbour may be: nodes are less than (REACH + 1 - HORIZON/DX)/2 from their centres.
const REACH: usize = 3;

/// A cube of nodes, a cell each, as neighbour lists over slots in a given order.
pub struct Twin {
    /// Columns `start[c]..start[c + 1]` of the block of nodes 8 c .., and where their slots begin: eight per column, or one
    /// where all columns of the block lead to slots side by side.
    start: Vec<usize>,
    at: Vec<usize>,
    index: Vec<u32>,
    bits: Vec<u8>,
    /// (1 + s0)^2
    limit: f64,
    /// c w (PMB), omega w x^2 (LPS), c w/x (heat), w (correspondence).
    pmb: Stream,
    lps: Stream,
    heat: Stream,
    w: Stream,
    x: [Vec<f64>; 3],
    x_records: Vec<Record>,
    u_records: Vec<Record>,
    /// Per eight slots whether a column of lists leads there.
    listed: Vec<bool>,
    pub u: [Vec<f64>; 3],
    pub f: [Vec<f64>; 3],
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    pub q: Vec<f64>,
    /// Correspondence: inverse shape tensor and stabilisation; rows of the state, the stabilisation behind the first.
    shape: [Vec<f64>; 6],
    penalty: Vec<f64>,
    state: [Vec<f64>; 9],
    state_records: [Vec<Record>; 3],
}

/// Runs a kernel on every block, in the way of its rows.
macro_rules! every_block {
    ($twin:ident.$kernel:ident($($more:expr)?)) => {
        for c in 0..$twin.start.len() - 1 {
            if $twin.are_runs(c) {
                $twin.$kernel::<true>(c $(, $more)?)
            } else {
                $twin.$kernel::<false>(c $(, $more)?)
            }
        }
    };
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
            at: vec![0],
            index: vec![],
            bits: vec![],
            limit: (1.0 + s0) * (1.0 + s0),
            pmb: Stream::default(),
            lps: Stream::default(),
            heat: Stream::default(),
            w: Stream::default(),
            x: [zero(), zero(), zero()],
            x_records: vec![Record([0.0; 4]); len],
            u_records: vec![Record([0.0; 4]); len],
            listed: vec![false; len.div_ceil(8)],
            u: [zero(), zero(), zero()],
            f: [zero(), zero(), zero()],
            a: zero(),
            b: zero(),
            q: zero(),
            shape: std::array::from_fn(|_| zero()),
            penalty: zero(),
            state: std::array::from_fn(|_| zero()),
            state_records: std::array::from_fn(|_| vec![Record([0.0; 4]); len]),
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
        for block in cell.chunks(8).enumerate() {
            t.block(n, nodes, slot, block.0 * 8, block.1, c);
        }
        for v in [&mut t.pmb, &mut t.lps, &mut t.heat, &mut t.w] {
            v.keep(&t.bits);
        }
        for c in 0..t.start.len() - 1 {
            if !t.are_runs(c) {
                let slots = &t.index[t.at[c]..t.at[c + 1]];
                slots.iter().for_each(|s| t.listed[*s as usize / 8] = true);
            }
        }
        pack(&t.x, &mut t.x_records, &t.listed);
        t.index = loads::in_large_pages(&t.index);
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
        let rows = match runs(&lists, self.x[0].len() / 8 * 8) {
            Some(runs) => {
                self.index.extend(runs.iter().map(|(from, _)| from));
                let lanes = [0, 1, 2, 3, 4, 5, 6, 7];
                let row = |&(from, bits): &(u32, u8)| (lanes.map(|k| from + k), bits);
                runs.iter().map(row).collect()
            }
            None => {
                let rows = columns(&lists, first as u32);
                self.index.extend(rows.iter().flat_map(|(row, _)| row));
                rows
            }
        };
        for (row, bits) in rows {
            for (lane, j) in row.into_iter().enumerate() {
                self.geometry(first + lane, j as usize, bits >> lane & 1 == 1, c);
            }
            self.bits.push(bits);
        }
        self.start.push(self.bits.len());
        self.at.push(self.index.len());
    }

    /// Whether the rows of a block lead to slots side by side.
    fn are_runs(&self, c: usize) -> bool {
        self.at[c + 1] - self.at[c] == self.start[c + 1] - self.start[c]
    }

    fn slot(&self, c: usize, row: usize, lane: usize) -> usize {
        let (index, row) = (&self.index[self.at[c]..], row - self.start[c]);
        match self.are_runs(c) {
            true => index[row] as usize + lane,
            false => index[8 * row + lane] as usize,
        }
    }

    /// Where the slots of a block stand, so that those of a column follow at the columns before it, or at eight times as many.
    #[inline]
    fn places<const RUN: bool>(&self, c: usize) -> *const u32 {
        let before = if RUN {
            self.start[c]
        } else {
            8 * self.start[c]
        };
        let from = self.index.as_ptr().wrapping_add(self.at[c]);
        from.wrapping_sub(before)
    }

    /// Positions and displacements.
    fn moved(&self) -> [Numbers<'_>; 2] {
        [(&self.x, &self.x_records), (&self.u, &self.u_records)].map(Numbers::new)
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
        self.pmb.values.push(w * c);
        self.lps.values.push(w * x);
        // A lane of a node without bonds may name its own node.
        self.heat.values.push(if x > 0.0 { w * c / x } else { 0.0 });
        self.w.values.push(w);
    }

    /// Heat: the rate in `f[0]` of the temperature in `u[0]`, but for the factor `q`.
    pub fn heat(&mut self) {
        // SAFETY: checked in `new`; indices are slots, those of runs with seven more behind.
        unsafe { every_block!(self.heat_avx512()) }
    }

    /// What correspondence takes from whole families.
    pub fn set_up(&mut self, e: &Elastic) {
        for c in 0..self.start.len() - 1 {
            for lane in 0..8 {
                let (node, mut shape, mut count) = (8 * c + lane, [0.0; 6], 0.0);
                for row in self.start[c]..self.start[c + 1] {
                    if self.bits[row] >> lane & 1 == 1 {
                        let j = self.slot(c, row, lane);
                        let [x, y, z] = [0, 1, 2].map(|a| self.x[a][j] - self.x[a][node]);
                        let products = [x * x, x * y, x * z, y * y, y * z, z * z];
                        (0..6).for_each(|m| shape[m] += self.w.number(row, lane) * products[m]);
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
        pack(&self.u, &mut self.u_records, &self.listed);
        unsafe {
            every_block!(self.gradient_avx512(e));
            every_block!(self.pull_avx512());
        }
    }

    /// PMB with breaking.
    pub fn pmb(&mut self) {
        // SAFETY: checked in `new`; indices are slots, those of runs with seven more behind.
        pack(&self.u, &mut self.u_records, &self.listed);
        unsafe { every_block!(self.pmb_avx512()) }
    }

    /// LPS: dilatation (with breaking), then force.
    pub fn lps(&mut self) {
        // SAFETY: as above.
        pack(&self.u, &mut self.u_records, &self.listed);
        unsafe {
            every_block!(self.dilatation_avx512());
            every_block!(self.force_avx512());
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn heat_avx512<const RUN: bool>(&mut self, c: usize) {
        unsafe {
            let t = self.u[0].as_ptr();
            let places = self.places::<RUN>(c);
            let at = 8 * c;
            let ti = _mm512_loadu_pd(t.add(at));
            let mut sum = _mm512_setzero_pd();
            for row in self.start[c]..self.start[c + 1] {
                let index = fetch::<RUN>(places, row);
                let bits = *self.bits.as_ptr().add(row);
                let d = _mm512_maskz_sub_pd(bits, single::<RUN>(t, index), ti);
                sum = _mm512_fmadd_pd(self.heat.at(row), d, sum);
            }
            let rate = _mm512_mul_pd(sum, _mm512_loadu_pd(self.q.as_ptr().add(at)));
            _mm512_storeu_pd(self.f[0].as_mut_ptr().add(at), rate);
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn gradient_avx512<const RUN: bool>(&mut self, c: usize, material: &Elastic) {
        unsafe {
            let bits = self.bits.as_mut_ptr();
            let [x, u] = self.moved();
            let limit = _mm512_set1_pd(self.limit);
            let places = self.places::<RUN>(c);
            let at = 8 * c;
            let (xi, ui) = (x.own(at), u.own(at));
            let mut s = [_mm512_setzero_pd(); 9];
            for row in self.start[c]..self.start[c + 1] {
                let bond = Bonds::new::<RUN>(&x, &u, &xi, &ui, fetch::<RUN>(places, row));
                let mut k = *bits.add(row);
                let longest = _mm512_mul_pd(limit, bond.reference);
                let dead = _mm512_mask_cmp_pd_mask::<_CMP_LT_OQ>(k, longest, bond.square);
                if dead != 0 {
                    k &= !dead;
                    *bits.add(row) = k;
                }
                let w = self.w.at(row);
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
            for (to, value) in self.state.iter_mut().zip(&state) {
                _mm512_storeu_pd(to.as_mut_ptr().add(at), *value);
            }
            if !self.listed[c] {
                return;
            }
            for (a, to) in self.state_records.iter_mut().enumerate() {
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

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn pull_avx512<const RUN: bool>(&mut self, c: usize) {
        unsafe {
            let [x, u] = self.moved();
            let places = self.places::<RUN>(c);
            let at = 8 * c;
            let (xi, ui) = (x.own(at), u.own(at));
            let load = |v: &Vec<f64>, at: usize| _mm512_loadu_pd(v.as_ptr().add(at));
            let mine: [__m512d; 9] = std::array::from_fn(|k| load(&self.state[k], at));
            let ci = _mm512_loadu_pd(self.penalty.as_ptr().add(at));
            let mut f = [_mm512_setzero_pd(); 3];
            for row in self.start[c]..self.start[c + 1] {
                let index = fetch::<RUN>(places, row);
                let bond = Bonds::new::<RUN>(&x, &u, &xi, &ui, index);
                let w = self.w.at(row);
                let bits = *self.bits.as_ptr().add(row);
                let mut far = [[_mm512_setzero_pd(); 4]; 3];
                let mut a = 0;
                while a < 3 {
                    if RUN {
                        let j = *index as usize;
                        let mut b = 0;
                        while b < 3 {
                            far[a][b] = load(&self.state[3 * a + b], j);
                            b += 1;
                        }
                        far[a][3] = load(&self.penalty, j);
                    } else {
                        far[a] = four(self.state_records[a].as_ptr(), index);
                    }
                    a += 1;
                }
                let c = _mm512_add_pd(ci, far[0][3]);
                let mut a = 0;
                while a < 3 {
                    let mut t = _mm512_mul_pd(c, bond.eta[a]);
                    let mut b = 0;
                    while b < 3 {
                        let both = _mm512_add_pd(mine[3 * a + b], far[a][b]);
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

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn pmb_avx512<const RUN: bool>(&mut self, c: usize) {
        unsafe {
            let bits = self.bits.as_mut_ptr();
            let [x, u] = self.moved();
            let limit = _mm512_set1_pd(self.limit);
            let places = self.places::<RUN>(c);
            let at = 8 * c;
            let (xi, ui) = (x.own(at), u.own(at));
            let mut f = [_mm512_setzero_pd(); 3];
            for row in self.start[c]..self.start[c + 1] {
                let (y, square, reference) =
                    deformed::<RUN>(&x, &u, &xi, &ui, fetch::<RUN>(places, row));
                let (ix, iy) = (root(reference), root(square));
                let mut k = *bits.add(row);
                let longest = _mm512_mul_pd(limit, reference);
                let dead = _mm512_mask_cmp_pd_mask::<_CMP_LT_OQ>(k, longest, square);
                if dead != 0 {
                    k &= !dead;
                    *bits.add(row) = k;
                }
                let d = _mm512_maskz_sub_pd(k, ix, iy);
                let t = _mm512_mul_pd(self.pmb.at(row), d);
                f[0] = _mm512_fmadd_pd(t, y[0], f[0]);
                f[1] = _mm512_fmadd_pd(t, y[1], f[1]);
                f[2] = _mm512_fmadd_pd(t, y[2], f[2]);
            }
            _mm512_storeu_pd(self.f[0].as_mut_ptr().add(at), f[0]);
            _mm512_storeu_pd(self.f[1].as_mut_ptr().add(at), f[1]);
            _mm512_storeu_pd(self.f[2].as_mut_ptr().add(at), f[2]);
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn dilatation_avx512<const RUN: bool>(&mut self, c: usize) {
        unsafe {
            let bits = self.bits.as_mut_ptr();
            let [x, u] = self.moved();
            let limit = _mm512_set1_pd(self.limit);
            let places = self.places::<RUN>(c);
            let at = 8 * c;
            let (xi, ui) = (x.own(at), u.own(at));
            let mut sum = _mm512_setzero_pd();
            for row in self.start[c]..self.start[c + 1] {
                let (_, square, reference) =
                    deformed::<RUN>(&x, &u, &xi, &ui, fetch::<RUN>(places, row));
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
                sum = _mm512_fmadd_pd(self.lps.at(row), extension, sum);
            }
            let a = _mm512_mul_pd(sum, _mm512_loadu_pd(self.q.as_ptr().add(at)));
            _mm512_storeu_pd(self.a.as_mut_ptr().add(at), a);
        }
    }

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    unsafe fn force_avx512<const RUN: bool>(&mut self, c: usize) {
        unsafe {
            let [x, u] = self.moved();
            let (pa, pb) = (self.a.as_ptr(), self.b.as_ptr());
            let places = self.places::<RUN>(c);
            let at = 8 * c;
            let (xi, ui) = (x.own(at), u.own(at));
            let (ai, bi) = (_mm512_loadu_pd(pa.add(at)), _mm512_loadu_pd(pb.add(at)));
            let mut f = [_mm512_setzero_pd(); 3];
            for row in self.start[c]..self.start[c + 1] {
                let index = fetch::<RUN>(places, row);
                let (y, square, reference) = deformed::<RUN>(&x, &u, &xi, &ui, index);
                let (ix, iy) = (root(reference), root(square));
                let d = _mm512_sub_pd(ix, iy);
                let aj = single::<RUN>(pa, index);
                let bj = single::<RUN>(pb, index);
                let t = _mm512_mul_pd(_mm512_add_pd(ai, aj), iy);
                let t = _mm512_fmadd_pd(_mm512_add_pd(bi, bj), d, t);
                let t = _mm512_maskz_mul_pd(
                    *self.bits.as_ptr().add(row),
                    _mm512_mul_pd(self.lps.at(row), ix),
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

/// Rows that lead to slots side by side, by the slot of lane 0 and the lanes that have a bond; None where there are too many.
fn runs(lists: &[Vec<u32>], slots: usize) -> Option<Vec<(u32, u8)>> {
    let mut starts: Vec<(i64, u8)> = vec![];
    for (lane, list) in lists.iter().enumerate() {
        starts.extend(
            list.iter()
                .map(|&j| (i64::from(j) - lane as i64, 1 << lane)),
        );
    }
    starts.sort_unstable();
    let row = |same: &[(i64, u8)]| {
        let from = usize::try_from(same[0].0).ok()?;
        let inside = from + 8 <= slots;
        inside.then(|| (from as u32, same.iter().map(|s| s.1).sum()))
    };
    let rows = starts.chunk_by(|a, b| a.0 == b.0).map(row);
    let rows: Vec<_> = rows.collect::<Option<_>>()?;
    let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
    (rows.len() <= (longest as f64 * MOST) as usize).then_some(rows)
}

/// Rows of lists; what a list lacks repeats its last.
fn columns(lists: &[Vec<u32>], first: u32) -> Vec<([u32; 8], u8)> {
    let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
    let row = |k: usize| {
        let list = |lane: usize| lists.get(lane).map_or(&[][..], |list| list);
        let other = |lane: usize| list(lane).get(k).or(list(lane).last()).copied();
        let there = |lane: usize| u8::from(k < list(lane).len()) << lane;
        (
            std::array::from_fn(|lane| other(lane).unwrap_or(first)),
            (0..8).map(there).sum(),
        )
    };
    (0..longest).map(row).collect()
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
