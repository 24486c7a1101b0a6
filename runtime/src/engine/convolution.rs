//! Sums over bonds as convolutions, where a law is a polynomial of its state and no bond can break.
//!
//! On a lattice of one material all nodes have the same bonds. What a bond adds is then a sum of products `p K q`: of
//! numbers `p` at the node, `q` at the other end, and a coefficient `K` for every kind of bond ([`polynomial`]). The sum
//! over the bonds of a node is `p` times the convolution of `K` with `q`, and `q` is zero where no node is, so that
//! surfaces and holes need nothing of their own. Products that differ in `K` alone share the transform of `q`; those
//! that differ in `K` and `q` alone share the way back. Where `q` does not change, the convolution is a steady array, summed
//! once bond by bond. Prologue and epilogue of a sweep run at every node as ever.
//!
//! All step sweeps with bonds are convolutions, or the scene is refused; tangents are where they can. Energies, being
//! squares of small differences, are not: they would lose digits. A state with broken bonds is walked bond by bond.
mod polynomial;
mod run;

use super::geometry::Geometry;
use super::program::Program;
use super::{Engine, Home, SetupError, State};
use crate::fourier::{Complex, Fourier, Kernel, Product};
use crate::layout::{Cells, Family, Shape, Stencil};
use crate::spec::{SlotKind, Spec, Stage};
use crate::traverse::{CHUNK, RunConvolved, convolved};
use polynomial::{Kinds, Monomial, Obstacle, Own, rough, sums};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The even or odd part of a kernel that is rounding of the other.
const ROUNDING: f64 = 1e-15;

/// What a sweep does in the place of its bonds.
#[derive(Debug)]
struct Sweep {
    /// Positions in [`Convolution::sources`].
    sources: Vec<usize>,
    /// Per output; sources by position in `sources`.
    outputs: Vec<Vec<Product>>,
    terms: Vec<Summand>,
}

/// Part of a sum: `factor` times numbers of the node times an array.
#[derive(Debug)]
struct Summand {
    sum: usize,
    own: Vec<Own>,
    factor: f64,
    array: Array,
}

#[derive(Clone, Copy, Debug)]
enum Array {
    Output(usize),
    Steady(usize),
}

/// A product of numbers at the other end, and its transform.
#[derive(Debug)]
struct Source {
    factors: Vec<Home>,
    spectrum: Vec<Complex>,
    fresh: bool,
}

/// Convolutions of a law on a body.
pub(super) struct Convolution {
    cells: Cells,
    fourier: Fourier,
    kernels: Vec<Kernel>,
    sources: Vec<Source>,
    steady: Vec<Vec<f64>>,
    /// Of the sweep at work: on the way back, and in layout order.
    spectra: Vec<Vec<Complex>>,
    outputs: Vec<Vec<f64>>,
    sweeps: Vec<Option<Sweep>>,
    /// Where nodes are, if not in all cells of the box.
    inside: Option<Vec<bool>>,
    run: RunConvolved,
}

impl std::fmt::Debug for Convolution {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_tuple("Convolution").field(&self.fourier).finish()
    }
}

/// What convolutions there are.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ConvolutionReport {
    pub sweeps: Vec<String>,
    /// Transforms of a force evaluation.
    pub transforms: usize,
    /// Cells of a transform along each axis.
    pub size: Vec<usize>,
    pub bytes: usize,
}

/// A kernel before its transform.
type Steps = Vec<([i64; 3], f64)>;

/// Everything that sweeps share while they are analysed.
struct Maker<'a> {
    spec: &'a Spec,
    engine: &'a Engine,
    cells: Cells,
    fourier: Fourier,
    /// Values by steps, and whether they are odd: transformed when all that is needed is known to fit.
    kernels: Vec<(Steps, bool)>,
    /// By family and the bits of the coefficients.
    known: BTreeMap<(usize, Vec<u64>), Vec<usize>>,
    sources: Vec<Vec<Home>>,
    steady: Vec<Vec<f64>>,
    summed: BTreeMap<(usize, Vec<u64>, Vec<Home>), Option<usize>>,
}

impl Convolution {
    /// Analyses the sweeps of an engine whose family stage has run, with so many bytes at hand.
    ///
    /// # Errors
    /// A step sweep that is none, with what to do; too little memory.
    pub fn new(
        engine: &Engine,
        cells: Cells,
        available: Option<u64>,
    ) -> Result<Convolution, SetupError> {
        let spec = &engine.spec;
        if engine.layout.parts.len() > 1 {
            let why = "all nodes to be alike, and this body has several materials or horizons";
            return refuse(why, "");
        }
        if let Some(p) = engine.programs.iter().find(|p| p.kills) {
            let why = format!(
                "bonds that hold, and `{}` of `{}` may break some",
                p.name, spec.law
            );
            return refuse(&why, "leave out what they break at");
        }
        let mut maker = Maker {
            spec,
            engine,
            cells,
            fourier: Fourier::new(cells.axes, engine.isa),
            kernels: vec![],
            known: BTreeMap::new(),
            sources: vec![],
            steady: vec![],
            summed: BTreeMap::new(),
        };
        for s in spec.sweeps.iter().filter(|s| s.stage == Stage::Step) {
            if let Some(obstacle) = rough(spec, s) {
                let why = format!(
                    "sums that need not be exactly nothing, and `{}` of `{}` takes {}",
                    s.name, spec.law, obstacle.what
                );
                return refuse(&why, remedy(spec, obstacle));
            }
        }
        let mut sweeps = vec![];
        for (k, p) in engine.programs.iter().enumerate() {
            let wanted = matches!(p.stage, Stage::Step | Stage::Tangent) && p.loops;
            sweeps.push(match (wanted.then(|| maker.sweep(k)), p.stage) {
                (Some(Err(obstacle)), Stage::Step) => {
                    let why = format!(
                        "sums of products, and `{}` of `{}` takes {}",
                        p.name, spec.law, obstacle.what
                    );
                    return refuse(&why, remedy(spec, obstacle));
                }
                (found, _) => found.and_then(Result::ok),
            });
        }
        let step = |(p, s): (&Program, &Option<Sweep>)| p.stage == Stage::Step && s.is_some();
        if !engine.programs.iter().zip(&sweeps).any(step) {
            return refuse("sums over bonds, and this law has none at its steps", "");
        }
        let Maker {
            fourier,
            kernels,
            sources,
            steady,
            ..
        } = maker;
        let most = sweeps
            .iter()
            .flatten()
            .map(|s| s.outputs.len())
            .max()
            .unwrap_or(0);
        let spectra = 16 * (most + sources.len()) * fourier.len();
        // Beside all of them, the grid and the spectrum that one is made in.
        let transforms = 8 * (kernels.len() + 4) * fourier.kernel_len();
        let needed = (spectra + transforms + 8 * most * engine.layout.len) as u64;
        if let Some(available) = available.filter(|available| needed > *available) {
            return Err(SetupError::Memory { needed, available });
        }
        let kernels = (kernels.iter())
            .map(|(steps, odd)| fourier.kernel(steps, *odd))
            .collect();
        let spectrum = || vec![Complex::default(); fourier.len()];
        let inside = inside(engine, &cells);
        Ok(Convolution {
            sources: (sources.into_iter())
                .map(|factors| Source {
                    factors,
                    spectrum: spectrum(),
                    fresh: false,
                })
                .collect(),
            spectra: (0..most).map(|_| spectrum()).collect(),
            outputs: vec![vec![0.0; engine.layout.len]; most],
            cells,
            fourier,
            kernels,
            steady,
            sweeps,
            inside,
            run: convolved(engine.isa),
        })
    }

    /// The state may have changed.
    pub fn forget(&mut self) {
        self.sources.iter_mut().for_each(|s| s.fresh = false);
    }

    pub fn bytes(&self) -> usize {
        let spectra = self.spectra.len() + self.sources.len();
        16 * spectra * self.fourier.len()
            + 8 * self.kernels.len() * self.fourier.kernel_len()
            + self
                .outputs
                .iter()
                .chain(&self.steady)
                .map(|v| 8 * v.len())
                .sum::<usize>()
            + self.inside.as_ref().map_or(0, Vec::len)
    }

    pub fn report(&self, programs: &[Program]) -> ConvolutionReport {
        let step = |k: &usize| programs[*k].stage == Stage::Step && self.sweeps[*k].is_some();
        let step: Vec<usize> = (0..programs.len()).filter(step).collect();
        let sweeps = || step.iter().filter_map(|k| self.sweeps[*k].as_ref());
        let mut sources: Vec<usize> = sweeps().flat_map(|s| s.sources.clone()).collect();
        sources.sort_unstable();
        sources.dedup();
        ConvolutionReport {
            sweeps: step.iter().map(|k| programs[*k].name.clone()).collect(),
            transforms: sources.len() + sweeps().map(|s| s.outputs.len()).sum::<usize>(),
            size: self.fourier.size.into_iter().filter(|n| *n > 1).collect(),
            bytes: self.bytes(),
        }
    }
}

/// Small displacements rid a law of what it does to the deformation, and of nothing else: not of what bonds remember.
fn remedy(spec: &Spec, obstacle: Obstacle) -> &'static str {
    let remembers = spec.histories.iter().any(|h| h.bond);
    match obstacle.deformed && !spec.linearised && !remembers {
        true => "try `linearised = true` in [material]",
        false => "",
    }
}

fn refuse<T>(why: &str, remedy: &str) -> Result<T, SetupError> {
    let remedy = match remedy {
        "" => "use `lattice`".into(),
        some => format!("{some}, or use `lattice`"),
    };
    Err(SetupError::Traversal(
        format!("a convolution takes {why}"),
        remedy,
    ))
}

/// Per cell of the box, line by line; none where all hold a node.
fn inside(engine: &Engine, cells: &Cells) -> Option<Vec<bool>> {
    let [n0, n1, n2] = cells.axes.map(|a| a.cells);
    let volume = &engine.layout.volume;
    let line = |k: usize| cells.first + k / n1 * cells.stride[2] + k % n1 * cells.stride[1];
    let inside: Vec<bool> = (0..n1 * n2)
        .flat_map(|k| volume[line(k)..][..n0].iter().map(|v| *v > 0.0))
        .collect();
    inside.contains(&false).then_some(inside)
}

impl Maker<'_> {
    /// # Errors
    /// What is no polynomial.
    fn sweep(&mut self, k: usize) -> Result<Sweep, Obstacle> {
        let (engine, p) = (self.engine, &self.engine.programs[k]);
        if !p.confined.is_empty() {
            let what = "a field that lives on a part of the body";
            return Err(Obstacle::lasting(what));
        }
        let (Shape::Stencil(stencil), Geometry::Table { values, .. }) =
            (&engine.families[p.family].shape, &engine.geometry[k])
        else {
            return Err(Obstacle::lasting("bonds off any lattice"));
        };
        let dim = self.spec.dim;
        let kinds = Kinds {
            dim,
            records: values
                .chunks_exact(2 + dim + p.geometry.outs.len())
                .collect(),
        };
        let found = sums(self.spec, p, &engine.homes, &self.spec.sweeps[k], &kinds)?;
        let mut sweep = Sweep {
            sources: vec![],
            outputs: vec![],
            terms: vec![],
        };
        for (sum, polynomial) in found.into_iter().enumerate() {
            // What shares the numbers at the node shares an output.
            let mut outputs: BTreeMap<Vec<Own>, usize> = BTreeMap::new();
            for (Monomial { own, far }, numbers) in polynomial {
                let (sign, numbers) = signed(numbers);
                if far.iter().all(|home| self.is_steady(*home)) {
                    if let Some(array) = self.steady(p.family, stencil, numbers, far) {
                        let array = Array::Steady(array);
                        sweep.terms.push(Summand {
                            sum,
                            own,
                            factor: sign,
                            array,
                        });
                    }
                    continue;
                }
                let source = self.source(far);
                let source = position(&mut sweep.sources, source);
                let kernels = self.kernels(p.family, stencil, numbers);
                let fresh = sweep.outputs.len();
                let output = *outputs.entry(own.clone()).or_insert(fresh);
                if output == fresh {
                    sweep.outputs.push(vec![]);
                    let array = Array::Output(output);
                    sweep.terms.push(Summand {
                        sum,
                        own,
                        factor: 1.0,
                        array,
                    });
                }
                let products = kernels.into_iter().map(|kernel| Product {
                    source,
                    kernel,
                    factor: sign,
                });
                sweep.outputs[output].extend(products);
            }
        }
        Ok(sweep)
    }

    /// Whether a number is the same at every step.
    fn is_steady(&self, home: Home) -> bool {
        let mut slots = self.spec.slots.iter().zip(&self.engine.homes);
        slots.any(|(slot, h)| {
            *h == home
                && matches!(
                    slot.kind,
                    SlotKind::Computed(Stage::Reference | Stage::Family)
                )
        })
    }

    fn source(&mut self, factors: Vec<Home>) -> usize {
        position(&mut self.sources, factors)
    }

    /// The even and the odd part, where they are not zero.
    fn kernels(&mut self, family: usize, stencil: &Stencil, numbers: Vec<f64>) -> Vec<usize> {
        let key = (family, bits(&numbers));
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let opposite = |kind: usize| {
            let opposite = stencil.kinds[kind].opposite;
            opposite.map_or(0.0, |k| numbers[k as usize])
        };
        let part = |sign: f64| -> Vec<f64> {
            let each = numbers.iter().enumerate();
            each.map(|(k, v)| 0.5 * (v + sign * opposite(k))).collect()
        };
        let parts = [part(1.0), part(-1.0)];
        let largest = parts
            .each_ref()
            .map(|p| p.iter().fold(0.0, |m: f64, v| m.max(v.abs())));
        let mut found = vec![];
        for (odd, part) in parts.into_iter().enumerate() {
            if largest[odd] <= ROUNDING * largest[1 - odd] {
                continue;
            }
            // A kind without an opposite has one in its parts.
            let mut steps = vec![];
            for (kind, value) in stencil.kinds.iter().zip(part) {
                let step = self.cells.step(kind.xi);
                steps.push((step, value));
                if kind.opposite.is_none() {
                    let back = if odd == 1 { -value } else { value };
                    steps.push((step.map(|s| -s), back));
                }
            }
            found.push(self.kernels.len());
            self.kernels.push((steps, odd == 1));
        }
        self.known.insert(key, found.clone());
        found
    }

    /// A sum over bonds that no step changes; none where it is zero everywhere.
    fn steady(
        &mut self,
        family: usize,
        stencil: &Stencil,
        numbers: Vec<f64>,
        far: Vec<Home>,
    ) -> Option<usize> {
        let key = (family, bits(&numbers), far.clone());
        if let Some(known) = self.summed.get(&key) {
            return *known;
        }
        let engine = self.engine;
        let arrays: Vec<&[f64]> = far.iter().filter_map(|home| engine.array(*home)).collect();
        let sum = bond_by_bond(engine, &engine.families[family], stencil, &numbers, &arrays);
        let found = sum.iter().any(|v| *v != 0.0).then(|| {
            self.steady.push(sum);
            self.steady.len() - 1
        });
        self.summed.insert(key, found);
        found
    }
}

/// With a positive first number, so that what differs in its sign alone is known again.
fn signed(mut numbers: Vec<f64>) -> (f64, Vec<f64>) {
    let first = numbers.iter().find(|v| **v != 0.0);
    match first.is_some_and(|v| *v < 0.0) {
        true => {
            numbers.iter_mut().for_each(|v| *v = -*v);
            (-1.0, numbers)
        }
        false => (1.0, numbers),
    }
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    // 0 and -0 are one.
    numbers.iter().map(|v| (v + 0.0).to_bits()).collect()
}

/// Of what is in the list, or added to it.
fn position<T: PartialEq>(list: &mut Vec<T>, of: T) -> usize {
    let found = list.iter().position(|v| *v == of);
    found.unwrap_or_else(|| {
        list.push(of);
        list.len() - 1
    })
}

fn bond_by_bond(
    engine: &Engine,
    family: &Family,
    stencil: &Stencil,
    numbers: &[f64],
    far: &[&[f64]],
) -> Vec<f64> {
    let layout = &engine.layout;
    let one = |chunk: usize| {
        let (first, from) = (family.rows(chunk).start, stencil.pattern[chunk] as usize);
        let mut sums = [0.0; CHUNK];
        family.for_each(layout, chunk, |m| {
            let kind = stencil.patterns[from + m.row - first];
            let q: f64 = far.iter().map(|values| values[m.other]).product();
            sums[m.lane] += numbers[kind as usize] * q;
        });
        sums
    };
    let found: Vec<[f64; CHUNK]> = (0..layout.chunks()).into_par_iter().map(one).collect();
    let mut all = vec![0.0; layout.len];
    for (base, sums) in layout.base.iter().zip(found) {
        all[*base as usize..][..CHUNK].copy_from_slice(&sums);
    }
    all
}

impl Engine {
    fn array(&self, home: Home) -> Option<&[f64]> {
        match home {
            Home::Array(k) => Some(&self.arrays[k]),
            _ => None,
        }
    }

    /// Runs a sweep as a convolution, if it is one and all bonds are there.
    pub(super) fn convolve(&mut self, k: usize, s: &State) -> bool {
        // What is steady has sums over intact bonds in it, perhaps of another family.
        let whole = self.bonds.iter().all(|bonds| bonds.unbroken);
        // Taken out, so that the engine can be asked while it changes.
        let Some(mut convolution) = self.convolution.take_if(|c| whole && c.sweeps[k].is_some())
        else {
            return false;
        };
        convolution.run(self, k, s);
        self.convolution = Some(convolution);
        self.refresh_outputs(k);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{block, laws};
    use super::super::{Isa, Law, Precision, Settings, Traversal};
    use super::*;
    use crate::body::Flavour;

    #[test]
    fn kernels_are_counted_before_they_are_made() {
        let settings = Settings {
            materials: vec![vec![2.5]],
            influences: vec![],
            horizon: vec![3.015],
            horizon_levels: 64,
            partial_volume: true,
            lattice_constants: false,
            without: vec![],
            traversal: Traversal::Convolution,
            isa: Some(Isa::Scalar),
            precision: Precision::Double,
        };
        let body = block(Flavour::Solid, [12, 10, 9], 1.0);
        let law = Law::interpreted(laws::heat(3));
        let mut engine = Engine::new(&body, law, settings).unwrap();
        let made = engine.convolution.take().unwrap();
        let kernels = 8 * made.kernels.len() * made.fourier.kernel_len();
        let all = made.bytes();
        assert!(0 < kernels && kernels < all);
        let with = |bytes: usize| Convolution::new(&engine, made.cells, Some(bytes as u64));
        assert!(matches!(
            with(all - kernels),
            Err(SetupError::Memory { .. })
        ));
        assert_eq!(with(2 * all).unwrap().bytes(), all);
    }
}
