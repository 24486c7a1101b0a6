//! Convolutions on a box of cells, by fast Fourier transforms.
//!
//! `out(i) = sum over s of K(s) q(i + s)` for all cells i of the box, q being 0 outside of it, or repeated along an
//! axis that is periodic. An axis that is not is padded by the reach of the kernels, so that nothing comes around.
//!
//! A transform goes axis by axis: along the first, two rows as the real and the imaginary part of one; along the second,
//! plane by plane while the plane is in the cache; along the third, some columns at a time, together with the products
//! and the way back. Rows, planes and columns that hold nothing but padding are left out. A spectrum is kept as it is
//! before the third axis. Every number is computed by one task in one order: bits do not depend on threads.
use crate::lane::Isa;
use rayon::prelude::*;
use rustfft::{Fft, FftPlannerAvx, FftPlannerScalar};
use std::sync::Arc;

pub(crate) type Complex = rustfft::num_complex::Complex<f64>;
const ZERO: Complex = Complex { re: 0.0, im: 0.0 };

/// Bytes of the columns of a task, which stay in the second-level cache, and how many columns make sense.
const BUDGET: usize = 256 << 10;
const COLUMNS: [usize; 2] = [4, 64];
/// Planes of a task: an even number, so that rows come in pairs also where a plane has but one.
const PLANES: usize = 2;

/// One axis of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Axis {
    pub cells: usize,
    /// Cells that kernels reach.
    pub reach: usize,
    pub periodic: bool,
}

impl Axis {
    /// Cells with padding.
    fn padded(&self) -> usize {
        match self.periodic {
            true => self.cells,
            false => quick(self.cells + self.reach),
        }
    }
}

/// The length from `least` on whose transform costs least, all factors being 2, 3 and 5.
fn quick(least: usize) -> usize {
    let cost = |n: usize| {
        let (mut rest, mut each) = (n, 1.0);
        for (factor, passes) in [(2, 1.0), (3, 1.7), (5, 2.6)] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
                each += passes;
            }
        }
        (rest == 1).then_some(each * n as f64)
    };
    let all = (least..=2 * least).filter_map(|n| Some((n, cost(n)?)));
    all.min_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(least, |n| n.0)
}

/// The transform of a kernel: even kernels have a real one, odd ones an imaginary one. At `column * depth + k`.
pub(crate) struct Kernel {
    pub values: Vec<f64>,
    pub imaginary: bool,
}

/// `factor` times the convolution of a source with a kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Product {
    /// Positions among the sources at hand and among all kernels.
    pub source: usize,
    pub kernel: usize,
    pub factor: f64,
}

/// Transforms of a box.
pub(crate) struct Fourier {
    axes: [Axis; 3],
    /// With padding.
    pub size: [usize; 3],
    /// Per axis, forward and inverse; none for an axis of one cell.
    plans: [Option<[Arc<dyn Fft<f64>>; 2]>; 3],
    isa: Isa,
}

impl std::fmt::Debug for Fourier {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_tuple("Fourier").field(&self.size).finish()
    }
}

impl Fourier {
    /// The first axis is the one along which values are neighbours in memory.
    pub fn new(axes: [Axis; 3], isa: Isa) -> Fourier {
        let size = axes.map(|a| a.padded());
        let plans = size.map(|n| {
            (n > 1).then(|| {
                let avx = match isa {
                    Isa::Scalar => None,
                    _ => FftPlannerAvx::new().ok(),
                };
                match avx {
                    Some(mut plan) => [plan.plan_fft_forward(n), plan.plan_fft_inverse(n)],
                    None => {
                        let mut plan = FftPlannerScalar::new();
                        [plan.plan_fft_forward(n), plan.plan_fft_inverse(n)]
                    }
                }
            })
        });
        Fourier {
            axes,
            size,
            plans,
            isa,
        }
    }

    /// Complex numbers along the first axis: the others follow, as what is transformed is real.
    fn half(&self) -> usize {
        self.size[0] / 2 + 1
    }

    fn plane(&self) -> usize {
        self.half() * self.size[1]
    }

    /// Complex numbers of a spectrum.
    pub fn len(&self) -> usize {
        self.plane() * self.axes[2].cells
    }

    /// Numbers of a kernel.
    pub fn kernel_len(&self) -> usize {
        self.plane() * self.size[2]
    }

    fn run(&self, axis: usize, inverse: usize, values: &mut [Complex], scratch: &mut Vec<Complex>) {
        if let Some(plans) = &self.plans[axis] {
            let plan = &plans[inverse];
            scratch.resize(plan.get_inplace_scratch_len().max(scratch.len()), ZERO);
            plan.process_with_scratch(values, scratch);
        }
    }

    /// The spectrum of the values that `fill(plane, line, row)` writes to the beginning of rows of zeros.
    pub fn forward(&self, fill: &(dyn Fn(usize, usize, &mut [f64]) + Sync), to: &mut [Complex]) {
        self.planes(self.axes[1].cells, fill, to);
    }

    fn planes(
        &self,
        lines: usize,
        fill: &(dyn Fn(usize, usize, &mut [f64]) + Sync),
        to: &mut [Complex],
    ) {
        let (n, depth) = (self.size[0], self.size[1]);
        let room = || (vec![vec![0.0; n]; 2], vec![ZERO; n], vec![]);
        let one = |room: &mut (Vec<Vec<f64>>, Vec<Complex>, Vec<Complex>),
                   (task, planes): (usize, &mut [Complex])| {
            let (rows, pair, scratch) = room;
            planes.fill(ZERO);
            let count = planes.len() / self.plane() * lines;
            for first in (0..count).step_by(2) {
                for (k, row) in rows.iter_mut().enumerate() {
                    row.fill(0.0);
                    let line = first + k;
                    if line < count {
                        fill(task * PLANES + line / lines, line % lines, row);
                    }
                }
                for (z, (a, b)) in pair.iter_mut().zip(rows[0].iter().zip(&rows[1])) {
                    *z = Complex { re: *a, im: *b };
                }
                self.run(0, 0, pair, scratch);
                let at = |line: usize| line / lines * self.plane() + line % lines;
                let (a, b) = (at(first), at(first + 1));
                for h in 0..self.half() {
                    let (z, w) = (pair[h], pair[(n - h) % n].conj());
                    planes[a + h * depth] = 0.5 * (z + w);
                    if first + 1 < count {
                        let d = 0.5 * (z - w);
                        planes[b + h * depth] = Complex {
                            re: d.im,
                            im: -d.re,
                        };
                    }
                }
            }
            self.run(1, 0, planes, scratch);
        };
        let tasks = to.par_chunks_mut(self.plane() * PLANES).enumerate();
        tasks.for_each_init(room, one);
    }

    /// The transform of a kernel that is even or odd: values by steps.
    pub fn kernel(&self, values: &[([i64; 3], f64)], odd: bool) -> Kernel {
        let [n0, n1, n2] = self.size;
        let mut grid = vec![0.0; n0 * n1 * n2];
        let scale = 1.0 / grid.len() as f64;
        for (step, value) in values {
            let at = |a: usize| (-step[a]).rem_euclid(self.size[a] as i64) as usize;
            grid[(at(2) * n1 + at(1)) * n0 + at(0)] += scale * value;
        }
        let fill = |plane: usize, line: usize, row: &mut [f64]| {
            row.copy_from_slice(&grid[(plane * n1 + line) * n0..][..n0]);
        };
        let mut spectrum = vec![ZERO; self.kernel_len()];
        self.planes(n1, &fill, &mut spectrum);
        let (mut column, mut scratch) = (vec![ZERO; n2], vec![]);
        let mut all = Vec::with_capacity(spectrum.len());
        for c in 0..self.plane() {
            for (k, z) in column.iter_mut().enumerate() {
                *z = spectrum[k * self.plane() + c];
            }
            self.run(2, 0, &mut column, &mut scratch);
            all.extend(column.iter().map(|z| if odd { z.im } else { z.re }));
        }
        Kernel {
            values: all,
            imaginary: odd,
        }
    }

    /// Sums of products, one spectrum each, on the way back from the third axis.
    pub fn convolve(
        &self,
        sources: &[&[Complex]],
        kernels: &[Kernel],
        sums: &[Vec<Product>],
        to: &mut [Vec<Complex>],
    ) {
        let (plane, depth, filled) = (self.plane(), self.size[2], self.axes[2].cells);
        let outputs: Vec<Shared> = to.iter_mut().map(|v| Shared(v.as_mut_ptr())).collect();
        let most = BUDGET / (16 * depth * (sources.len() + 1));
        let most = most.clamp(COLUMNS[0], COLUMNS[1]);
        let room = || {
            (
                vec![ZERO; sources.len() * most * depth],
                vec![ZERO; most * depth],
                vec![],
            )
        };
        let one = |room: &mut (Vec<Complex>, Vec<Complex>, Vec<Complex>), task: usize| {
            let (columns, sum, scratch) = room;
            let from = task * most;
            let count = most.min(plane - from);
            let sum = &mut sum[..count * depth];
            for (source, columns) in sources.iter().zip(columns.chunks_exact_mut(most * depth)) {
                let columns = &mut columns[..count * depth];
                for k in 0..filled {
                    let row = &source[k * plane + from..][..count];
                    for (c, z) in row.iter().enumerate() {
                        columns[c * depth + k] = *z;
                    }
                }
                for column in columns.chunks_exact_mut(depth) {
                    column[filled..].fill(ZERO);
                }
                self.run(2, 0, columns, scratch);
            }
            for (products, to) in sums.iter().zip(&outputs) {
                sum.fill(ZERO);
                for p in products {
                    let source = &columns[p.source * most * depth..][..count * depth];
                    let kernel = &kernels[p.kernel];
                    let add = Add {
                        source,
                        kernel: &kernel.values[from * depth..],
                        factor: p.factor,
                        imaginary: kernel.imaginary,
                    };
                    add.to(sum, self.isa);
                }
                self.run(2, 1, sum, scratch);
                for k in 0..filled {
                    for c in 0..count {
                        // SAFETY: no other task writes these columns, and a spectrum has so many planes.
                        unsafe { to.0.add(k * plane + from + c).write(sum[c * depth + k]) };
                    }
                }
            }
        };
        debug_assert!(to.iter().all(|v| v.len() == self.len()));
        (0..plane.div_ceil(most))
            .into_par_iter()
            .for_each_init(room, one);
    }

    /// Back from a spectrum, which is of no use afterwards: `keep(plane, line, row)` gets the rows of the box.
    pub fn inverse(&self, spectrum: &mut [Complex], keep: &(dyn Fn(usize, usize, &[f64]) + Sync)) {
        let (n, depth) = (self.size[0], self.size[1]);
        let (lines, cells) = (self.axes[1].cells, self.axes[0].cells);
        let room = || (vec![ZERO; n], vec![0.0; cells], vec![]);
        let one = |room: &mut (Vec<Complex>, Vec<f64>, Vec<Complex>),
                   (task, planes): (usize, &mut [Complex])| {
            let (pair, row, scratch) = room;
            self.run(1, 1, planes, scratch);
            let count = planes.len() / self.plane() * lines;
            for first in (0..count).step_by(2) {
                let at = |line: usize| line / lines * self.plane() + line % lines;
                let (a, b) = (at(first), at(first + 1));
                for h in 0..self.half() {
                    let z = planes[a + h * depth];
                    let w = match first + 1 < count {
                        true => planes[b + h * depth],
                        false => ZERO,
                    };
                    let back = (n - h) % n;
                    if back == h {
                        pair[h] = Complex { re: z.re, im: w.re };
                    } else {
                        pair[h] = Complex {
                            re: z.re - w.im,
                            im: z.im + w.re,
                        };
                        pair[back] = Complex {
                            re: z.re + w.im,
                            im: w.re - z.im,
                        };
                    }
                }
                self.run(0, 1, pair, scratch);
                for k in 0..2.min(count - first) {
                    for (to, z) in row.iter_mut().zip(&*pair) {
                        *to = if k == 0 { z.re } else { z.im };
                    }
                    let line = first + k;
                    keep(task * PLANES + line / lines, line % lines, row);
                }
            }
        };
        let tasks = spectrum.par_chunks_mut(self.plane() * PLANES).enumerate();
        tasks.for_each_init(room, one);
    }
}

/// A spectrum that tasks write together, each its own columns.
struct Shared(*mut Complex);
// SAFETY: see where it is written.
unsafe impl Sync for Shared {}

/// `sum += factor * kernel * source`
#[derive(Clone, Copy)]
struct Add<'a> {
    source: &'a [Complex],
    kernel: &'a [f64],
    factor: f64,
    imaginary: bool,
}

impl Add<'_> {
    fn to(&self, sum: &mut [Complex], isa: Isa) {
        match isa {
            // SAFETY: an engine has an instruction set that the processor has.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => unsafe { self.in_avx2(sum) },
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => unsafe { self.in_avx512(sum) },
            _ => self.here(sum),
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn in_avx2(&self, sum: &mut [Complex]) {
        self.here(sum);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    fn in_avx512(&self, sum: &mut [Complex]) {
        self.here(sum);
    }

    #[inline(always)]
    fn here(&self, sum: &mut [Complex]) {
        let count = sum.len();
        let (source, kernel) = (&self.source[..count], &self.kernel[..count]);
        if self.imaginary {
            for n in 0..count {
                let k = self.factor * kernel[n];
                sum[n].re -= k * source[n].im;
                sum[n].im += k * source[n].re;
            }
        } else {
            for n in 0..count {
                let k = self.factor * kernel[n];
                sum[n].re += k * source[n].re;
                sum[n].im += k * source[n].im;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    /// By the definition.
    fn direct(axes: &[Axis; 3], steps: &[([i64; 3], f64)], q: &[f64]) -> Vec<f64> {
        let n = axes.map(|a| a.cells as i64);
        let mut out = vec![];
        for k in 0..n[2] {
            for j in 0..n[1] {
                for i in 0..n[0] {
                    let term = |(s, v): &([i64; 3], f64)| {
                        let mut at = [i + s[0], j + s[1], k + s[2]];
                        for a in 0..3 {
                            match axes[a].periodic {
                                true => at[a] = at[a].rem_euclid(n[a]),
                                false if !(0..n[a]).contains(&at[a]) => return 0.0,
                                false => {}
                            }
                        }
                        v * q[((at[2] * n[1] + at[1]) * n[0] + at[0]) as usize]
                    };
                    out.push(steps.iter().map(term).sum());
                }
            }
        }
        out
    }

    fn check(cells: [usize; 3], reach: usize, periodic: [bool; 3], isa: Isa) {
        let axes: [Axis; 3] = std::array::from_fn(|a| Axis {
            cells: cells[a],
            reach: if cells[a] == 1 && !periodic[a] {
                0
            } else {
                reach
            },
            periodic: periodic[a],
        });
        let f = Fourier::new(axes, isa);
        let [n0, n1, n2] = cells;
        let wave = |k: usize, c: f64| (k as f64 * c + 0.3).sin();
        let q: [Vec<f64>; 2] = [1.7, 2.3].map(|c| (0..n0 * n1 * n2).map(|k| wave(k, c)).collect());
        // One even and one odd kernel.
        let r = axes.map(|a| a.reach as i64);
        let mut steps = [vec![], vec![]];
        for k in -r[2]..=r[2] {
            for j in -r[1]..=r[1] {
                for i in -r[0]..=r[0] {
                    let x = (i + 2 * j - 3 * k) as f64;
                    steps[0].push(([i, j, k], x.cos()));
                    steps[1].push(([i, j, k], x.sin()));
                }
            }
        }
        let kernels = [f.kernel(&steps[0], false), f.kernel(&steps[1], true)];
        let spectra: Vec<Vec<Complex>> = q
            .iter()
            .map(|q| {
                let mut to = vec![ZERO; f.len()];
                let fill = |p: usize, l: usize, row: &mut [f64]| {
                    row[..n0].copy_from_slice(&q[(p * n1 + l) * n0..][..n0]);
                };
                f.forward(&fill, &mut to);
                to
            })
            .collect();
        let product = |source, kernel, factor| Product {
            source,
            kernel,
            factor,
        };
        let sums = [
            vec![product(0, 0, 2.0), product(1, 1, -1.0)],
            vec![product(1, 0, 1.0)],
        ];
        let mut out = vec![vec![ZERO; f.len()]; 2];
        let sources: Vec<&[Complex]> = spectra.iter().map(|s| &s[..]).collect();
        f.convolve(&sources, &kernels, &sums, &mut out);
        for (products, spectrum) in sums.iter().zip(&mut out) {
            let found = Mutex::new(vec![0.0; q[0].len()]);
            f.inverse(spectrum, &|p, l, row| {
                found.lock().unwrap()[(p * n1 + l) * n0..][..n0].copy_from_slice(row);
            });
            let found = found.into_inner().unwrap();
            let mut expected = vec![0.0; q[0].len()];
            for p in products {
                let part = direct(&axes, &steps[p.kernel], &q[p.source]);
                expected
                    .iter_mut()
                    .zip(part)
                    .for_each(|(e, d)| *e += p.factor * d);
            }
            let size = expected.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
            let apart = expected
                .iter()
                .zip(&found)
                .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
            assert!(
                apart <= 2e-14 * size,
                "{cells:?} {periodic:?} {isa:?}: {:e}",
                apart / size
            );
        }
    }

    #[test]
    fn convolutions_are_their_definition() {
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            for cells in [
                [7, 5, 6],
                [8, 1, 9],
                [13, 1, 1],
                [1, 1, 1],
                [12, 3, 1],
                [4, 11, 2],
            ] {
                for bits in 0..8 {
                    let periodic = [0, 1, 2].map(|a| bits >> a & 1 == 1);
                    check(cells, 3, periodic, isa);
                }
            }
        }
    }

    /// A kernel that reaches around a periodic body more than once.
    #[test]
    fn images_are_added_up() {
        check([5, 3, 2], 7, [true; 3], Isa::Scalar);
    }

    #[test]
    fn lengths_are_products_of_small_primes() {
        assert_eq!(quick(53), 54);
        assert_eq!(quick(1), 1);
        assert_eq!(quick(97), 100);
        assert!((1..2000).all(|n| (n..=n + n / 3 + 1).contains(&quick(n))));
    }
}
