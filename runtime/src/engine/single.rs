//! Sums over bonds in single precision: what they read of nodes, rounded, beside the numbers themselves.
//!
//! A sweep that may ([`crate::spec::SweepSpec::single`]) reads displacements and values of the other end from here. What it
//! reads of its own node it rounds as it reads it, and what it writes is a number like all others: states, fields and
//! everything that is integrated stay in double precision.
use super::constants::Materials;
use super::geometry::{Geometry, table};
use super::program::Program;
use super::{Engine, Home, Isa, Precision, Settings, SetupError, State, Traversal};
use crate::kernel::Run;
use crate::layout::{Family, Shape};
use crate::spec::{Op, SlotKind, Spec, Stage};
use crate::traverse::Call;
use rayon::prelude::*;

/// Magnitudes that are taken. In SI units a large one (a stiffness) meets small ones (volumes, lengths), so that products of
/// them are numbers too; where one is not, forces are not finite, and a run says so.
const SAFE: std::ops::Range<f64> = 1e-30..1e30;
/// Displacements below [in their own unit] are zero, as arithmetic with the smallest numbers takes many times as long.
const NOTHING: f32 = 1e-30;

/// Numbers of nodes in single precision.
#[derive(Debug, Default)]
pub(super) struct Rounded {
    u: Vec<Vec<f32>>,
    /// As [`slots_read`] has them.
    slots: Vec<usize>,
    values: Vec<Vec<f32>>,
    /// Records of the bonds of every sweep that reads them in single precision.
    pub tables: Vec<Option<Geometry>>,
    /// The state may have changed since it was rounded.
    stale: bool,
    /// For the time being sums are in double precision nevertheless.
    paused: bool,
}

/// Whether sums are to be in single precision, and can be.
pub(super) fn wanted(spec: &Spec, s: &Settings, lattice: bool) -> Result<bool, SetupError> {
    if s.precision == Precision::Double {
        return Ok(false);
    }
    let fail = |m: String, remedy: &str| Err(SetupError::Precision(m, remedy.into()));
    if s.traversal == Traversal::Convolution {
        let m = "a convolution is in double precision".into();
        return fail(m, "use the traversal `lattice`, or leave the precision out");
    }
    if !lattice {
        let m =
            "sums in single precision need the lattice traversal; this body is walked as a cloud"
                .into();
        return fail(m, "leave the precision out");
    }
    if !spec.sweeps.iter().any(|sweep| sweep.single) {
        let m = format!(
            "every sum of `{}` adds what moves to what stays, as a bond to its stretch: in single precision the digits of small displacements are lost",
            spec.law
        );
        let remedy = match spec.linearised {
            true => "leave the precision out",
            false => {
                "set `linearised = true` in [material] where displacements are small, or leave the precision out"
            }
        };
        return fail(m, remedy);
    }
    Ok(s.isa.unwrap_or_else(Isa::best) != Isa::Scalar)
}

/// Tables in single precision beside those in double: kinds of bonds are few.
pub(super) fn tables(
    programs: &[Program],
    families: &[Family],
    materials: &Materials,
    dim: usize,
    isa: Isa,
) -> Vec<Option<Geometry>> {
    let one = |p: &Program| match &families[p.family].shape {
        Shape::Stencil(stencil) if p.single.is_some() => {
            Some(table(p, stencil, materials, dim, isa, Precision::Single))
        }
        _ => None,
    };
    programs.iter().map(one).collect()
}

/// Slots that sums in single precision read at the other end of a bond, in ascending order; None where there are no such
/// sums.
fn slots_read(programs: &[Program]) -> Option<Vec<usize>> {
    let single = || programs.iter().filter(|p| p.single.is_some());
    single().next()?;
    let mut slots: Vec<usize> = single().flat_map(|p| p.nbr.iter().copied()).collect();
    slots.sort_unstable();
    slots.dedup();
    Some(slots)
}

/// Bytes per node of what is rounded.
pub(super) fn bytes_per_node(spec: &Spec, programs: &[Program]) -> usize {
    slots_read(programs).map_or(0, |slots| 4 * (spec.dim + slots.len()))
}

impl Rounded {
    pub fn new(spec: &Spec, programs: &[Program], len: usize) -> Rounded {
        let Some(slots) = slots_read(programs) else {
            return Rounded::default();
        };
        Rounded {
            u: vec![vec![0.0; len]; spec.dim],
            values: vec![vec![0.0; len]; slots.len()],
            slots,
            ..Rounded::default()
        }
    }

    pub fn bytes(&self) -> usize {
        let all = self.u.iter().chain(&self.values);
        all.map(|v| 4 * v.len()).sum()
    }

    fn of_slot(&self, slot: usize) -> Option<usize> {
        self.slots.binary_search(&slot).ok()
    }
}

fn rounded(v: f64) -> f32 {
    let v = v as f32;
    if v.abs() < NOTHING { 0.0 } else { v }
}

fn round(from: &[f64], to: &mut [f32]) {
    let one = |(from, to): (&[f64], &mut [f32])| {
        for (from, to) in from.iter().zip(to) {
            *to = rounded(*from);
        }
    };
    if rayon::current_num_threads() > 1 && from.len() > 1 << 14 {
        let parts = from.par_chunks(1 << 12).zip(to.par_chunks_mut(1 << 12));
        parts.for_each(one);
    } else {
        one((from, to));
    }
}

/// The same at some slots.
fn round_at(slots: impl Iterator<Item = usize>, from: &[f64], to: &mut [f32]) {
    slots.for_each(|slot| to[slot] = rounded(from[slot]));
}

impl Engine {
    /// Sums over bonds in single precision.
    pub fn is_single(&self) -> bool {
        !self.rounded.u.is_empty()
    }

    /// Sums in double precision from now on where `pause` holds, and again as the settings have it where it does not. What
    /// sweeps have written stays as it is until they run again.
    pub(crate) fn pause_single(&mut self, pause: bool) {
        if !self.is_single() || self.rounded.paused == pause {
            return;
        }
        self.rounded.paused = pause;
        self.sleep.forget();
        for (&slot, to) in self.rounded.slots.iter().zip(&mut self.rounded.values) {
            if let Home::Array(a) = self.homes[slot] {
                round(&self.arrays[a], to);
            }
        }
    }

    /// Whether a sweep is to sum in single precision now.
    fn sums_single(&self, p: &Program) -> bool {
        p.single.is_some() && !self.rounded.paused
    }

    /// The instances of a sweep: whole families, any.
    pub(super) fn instances(&self, p: &Program) -> [Run; 2] {
        p.single.filter(|_| self.sums_single(p)).unwrap_or(p.run)
    }

    /// What was rounded of the state is so no longer.
    pub(super) fn forget_rounded(&mut self) {
        self.rounded.stale = true;
    }

    /// The state as the sums of sweep `k` read it: where chunks sleep it is there already.
    pub(super) fn round_state(&mut self, k: usize, s: &State) {
        if !self.sums_single(&self.programs[k]) || !std::mem::take(&mut self.rounded.stale) {
            return;
        }
        let mut rounded = std::mem::take(&mut self.rounded);
        let (layout, awake) = (&self.layout, self.sleep.to_pack());
        let renew = |from: &[f64], to: &mut [f32]| match awake {
            Some(awake) => round_at(layout.slots_of(awake.iter().cloned().flatten()), from, to),
            None => round(from, to),
        };
        for (from, to) in s.u.iter().zip(&mut rounded.u) {
            renew(from, to);
        }
        for (&slot, to) in rounded.slots.iter().zip(&mut rounded.values) {
            if !matches!(self.spec.slots[slot].kind, SlotKind::Computed(_)) {
                renew(self.read(self.homes[slot], s), to);
            }
        }
        self.rounded = rounded;
        self.sleep.packed();
    }

    /// What sweep `k` has written: on `some` chunks, or on those of its last run.
    pub(super) fn round_outputs(&mut self, k: usize, some: Option<&[u32]>) {
        if self.rounded.paused {
            return;
        }
        for &slot in &self.programs[k].out {
            let (Some(at), Home::Array(a)) = (self.rounded.of_slot(slot), self.homes[slot]) else {
                continue;
            };
            let (layout, from, to) = (&self.layout, &self.arrays[a], &mut self.rounded.values[at]);
            match (some, self.sleep.of_last_run(k)) {
                (Some(some), _) => {
                    round_at(layout.slots_of(some.iter().map(|c| *c as usize)), from, to)
                }
                (None, Some(ran)) => {
                    round_at(layout.slots_of(ran.iter().cloned().flatten()), from, to)
                }
                (None, None) => round(from, to),
            }
        }
    }

    pub(super) fn point_to_rounded(&self, k: usize, call: &mut Call) {
        let p = &self.programs[k];
        if !self.sums_single(p) {
            return;
        }
        if let Some(Geometry::Table { records, .. }) = &self.rounded.tables[k] {
            call.records = records.as_ptr().cast();
        }
        for (to, u) in call.u.iter_mut().zip(&self.rounded.u) {
            *to = u.as_ptr().cast();
        }
        for (to, &slot) in call.nbr.iter_mut().zip(&p.nbr) {
            if let Some(at) = self.rounded.of_slot(slot) {
                *to = self.rounded.values[at].as_ptr().cast();
            }
        }
    }

    /// Refuses numbers that single precision cannot have, or whose products it could not have.
    pub(super) fn check_range(&mut self, rest: &State) -> Result<(), SetupError> {
        if !self.is_single() {
            return Ok(());
        }
        // Sums read what it writes.
        self.run_stage(Stage::Family, rest);
        for (k, p) in self.programs.iter().enumerate() {
            if p.single.is_none() {
                continue;
            }
            let all = [
                self.constants_of(k),
                self.numbers_of_nodes(k),
                self.numbers_of_bonds(k),
            ];
            let unsafe_one = |v: &f64| *v != 0.0 && !SAFE.contains(v);
            if let Some(v) = all.into_iter().flatten().find(unsafe_one) {
                let m = format!(
                    "`{}` takes numbers of {v:.1e} in SI units, which single precision cannot multiply",
                    p.name
                );
                return Err(SetupError::Precision(m, "leave the precision out".into()));
            }
        }
        Ok(())
    }

    /// The largest magnitude of each constant that a sweep reads.
    fn constants_of(&self, k: usize) -> Vec<f64> {
        let (sweep, count) = (&self.spec.sweeps[k], self.spec.constants.outs.len().max(1));
        let ops = sweep.pre.ops.iter().chain(&sweep.post.ops);
        let constant = |op: &Op| match op {
            Op::Const(k) => Some(largest(
                self.constants
                    .iter()
                    .skip(*k as usize)
                    .step_by(count)
                    .copied(),
            )),
            _ => None,
        };
        ops.filter_map(constant).collect()
    }

    /// Of each array that a sweep reads and that is known by now.
    fn numbers_of_nodes(&self, k: usize) -> Vec<f64> {
        let p = &self.programs[k];
        let array = |slot: &usize| match self.homes[*slot] {
            Home::Array(a) => Some(largest(self.arrays[a].iter().copied())),
            _ => None,
        };
        p.own.iter().chain(&p.nbr).filter_map(array).collect()
    }

    /// Of each number of a bond.
    fn numbers_of_bonds(&self, k: usize) -> Vec<f64> {
        let Geometry::Table { values, .. } = &self.geometry[k] else {
            return vec![];
        };
        let count = 1 + self.spec.dim + self.programs[k].geometry.outs.len();
        let number = |n: usize| largest(values.chunks_exact(1 + count).map(|r| r[1 + n]));
        (0..count).map(number).collect()
    }
}

/// The largest magnitude; what is infinite is meant to be.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    let finite = values.filter(|v| v.is_finite());
    finite.map(f64::abs).fold(0.0, f64::max)
}
