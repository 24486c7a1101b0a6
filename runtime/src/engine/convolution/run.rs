//! A sweep as a convolution at one state: sources forward, products with kernels, back, and what nodes do with the sums.

use super::polynomial::Own;
use super::{Array, Convolution, Source};
use crate::engine::{Engine, Home, State};
use crate::fourier::Complex;
use crate::layout::Cells;
use crate::traverse::{Call, Convolved, Factor, Term};
use rayon::prelude::*;

/// Chunks of a task.
const GRAIN: usize = 256;

impl Convolution {
    pub(super) fn run(&mut self, engine: &mut Engine, k: usize, s: &State) {
        let call = engine.call(k, s);
        let Some(sweep) = &self.sweeps[k] else {
            return;
        };
        for &source in &sweep.sources {
            let Source {
                factors,
                spectrum,
                fresh,
            } = &mut self.sources[source];
            if !std::mem::replace(fresh, true) {
                let arrays: Vec<&[f64]> =
                    factors.iter().map(|home| engine.read(*home, s)).collect();
                let fill = |plane: usize, line: usize, row: &mut [f64]| {
                    fill(
                        &self.cells,
                        self.inside.as_deref(),
                        &arrays,
                        plane,
                        line,
                        row,
                    );
                };
                self.fourier.forward(&fill, spectrum);
            }
        }
        let sources: Vec<&[Complex]> = (sweep.sources.iter())
            .map(|&source| &self.sources[source].spectrum[..])
            .collect();
        let count = sweep.outputs.len();
        self.fourier.convolve(
            &sources,
            &self.kernels,
            &sweep.outputs,
            &mut self.spectra[..count],
        );
        for (spectrum, output) in self.spectra.iter_mut().zip(&mut self.outputs).take(count) {
            let (cells, to) = (&self.cells, Rows(output.as_mut_ptr()));
            let keep = |plane: usize, line: usize, row: &[f64]| {
                let at = cells.first + plane * cells.stride[2] + line * cells.stride[1];
                // SAFETY: the box lies within the layout, and every row is kept once.
                unsafe { to.keep(at, row) };
            };
            self.fourier.inverse(spectrum, &keep);
        }
        self.at_nodes(engine, k, s, &call);
        // What the sweep wrote is another source for those that follow.
        let wrote: Vec<Home> = engine.programs[k]
            .out
            .iter()
            .map(|&slot| engine.homes[slot])
            .collect();
        for source in &mut self.sources {
            source.fresh &= !source.factors.iter().any(|home| wrote.contains(home));
        }
    }

    /// Prologue, sums and epilogue.
    fn at_nodes(&self, engine: &Engine, k: usize, s: &State, call: &Call) {
        let Some(sweep) = &self.sweeps[k] else {
            return;
        };
        let mut sums = Convolved::default();
        for term in &sweep.terms {
            let array = match term.array {
                Array::Output(k) => &self.outputs[k],
                Array::Steady(k) => &self.steady[k],
            };
            let from = sums.factors.len();
            sums.factors.extend(term.own.iter().map(|own| match own {
                Own::Pre(k) => Factor::Pre(*k),
                Own::Slot(home) => Factor::Array(engine.read(*home, s).as_ptr()),
            }));
            sums.terms.push(Term {
                sum: term.sum,
                factor: term.factor,
                array: array.as_ptr(),
                from,
                to: sums.factors.len(),
            });
        }
        let chunks = engine.layout.chunks();
        // SAFETY: the instance is one of this processor, arrays have the length of the layout, and each task has its own chunks.
        let task = |t: usize| unsafe {
            (self.run)(call, &sums, t * GRAIN, ((t + 1) * GRAIN).min(chunks));
        };
        (0..chunks.div_ceil(GRAIN)).into_par_iter().for_each(task);
    }
}

/// An array that tasks write together, each its own rows.
struct Rows(*mut f64);
// SAFETY: see where it is written.
unsafe impl Sync for Rows {}

impl Rows {
    unsafe fn keep(&self, at: usize, row: &[f64]) {
        unsafe { std::ptr::copy_nonoverlapping(row.as_ptr(), self.0.add(at), row.len()) };
    }
}

/// A row of the box: the product of some arrays where nodes are.
fn fill(
    cells: &Cells,
    inside: Option<&[bool]>,
    arrays: &[&[f64]],
    plane: usize,
    line: usize,
    row: &mut [f64],
) {
    let [n0, n1, _] = cells.axes.map(|a| a.cells);
    let at = cells.first + plane * cells.stride[2] + line * cells.stride[1];
    let row = &mut row[..n0];
    row.fill(1.0);
    for values in arrays {
        for (to, v) in row.iter_mut().zip(&values[at..at + n0]) {
            *to *= v;
        }
    }
    if let Some(inside) = inside {
        for (to, is) in row.iter_mut().zip(&inside[(plane * n1 + line) * n0..]) {
            *to = if *is { *to } else { 0.0 };
        }
    }
}
