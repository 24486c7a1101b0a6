//! Reference-bond values of every sweep: a table per kind of bond, or streams per bond.
use super::SetupError;
use super::constants::{AtReferenceBond, Materials};
use super::program::Program;
use crate::kernel::norm_squared;
use crate::lane::{Isa, Memory};
use crate::layout::{Family, Layout, Stencil};
use crate::spec::{Op, Spec, Tape};
use crate::tape::{length, numbers, operands};
use crate::traverse::{CHUNK, MAX_GEOMETRY};
use rayon::prelude::*;
use std::collections::HashMap;

/// Of one sweep.
#[derive(Debug)]
pub(super) enum Geometry {
    /// A record per kind of bond: offset (the bits of an i64), xi, 1/|xi|, values. And, in the order of
    /// [`Stencil::patterns`], where in `values` the record of each row begins, as an address: one operation
    /// less per row, and simple addresses behind it, are a twentieth of the time.
    Table {
        values: Vec<f64>,
        records: Vec<usize>,
    },
    /// Numbers of the streams.
    Streams(Vec<usize>),
}

/// Tables for a lattice.
pub(super) fn table(
    p: &Program,
    stencil: &Stencil,
    materials: &Materials,
    dim: usize,
    isa: Isa,
) -> Geometry {
    let stride = 2 + dim + p.geometry.outs.len();
    let mut values = vec![0.0; stencil.kinds.len() * stride];
    for (record, kind) in values.chunks_exact_mut(stride).zip(&stencil.kinds) {
        record[0] = f64::from_bits(kind.offset as u64);
        record[1..=dim].copy_from_slice(&kind.xi[..dim]);
        record[1 + dim] = reciprocal_length(isa, dim, kind.xi);
        let pair = &materials.pairs[kind.pair as usize];
        let bond = AtReferenceBond {
            constants: &pair.constants,
            influences: &pair.influences,
            xi: kind.xi,
            length: length(kind.xi, dim),
            weight: kind.weight,
        };
        numbers(&p.geometry, &mut { bond }, &mut record[2 + dim..]);
    }
    let record = |&kind: &u32| values[kind as usize * stride..].as_ptr() as usize;
    let records = stencil.patterns.iter().map(record).collect();
    Geometry::Table { values, records }
}

/// Streams for a cloud. Sweeps that need the same value of the same family share its stream.
pub(super) struct Streams<'a> {
    pub layout: &'a Layout,
    pub families: &'a [Family],
    pub materials: &'a Materials<'a>,
    /// Weight [m^3] of the bond to a slot, between a pair of materials.
    pub weight: &'a (dyn Fn([f64; 3], usize, usize) -> f64 + Sync),
    pub values: Vec<Vec<f64>>,
    numbering: Numbering,
}

impl<'a> Streams<'a> {
    pub fn new(
        layout: &'a Layout,
        families: &'a [Family],
        materials: &'a Materials<'a>,
        weight: &'a (dyn Fn([f64; 3], usize, usize) -> f64 + Sync),
    ) -> Streams<'a> {
        Streams {
            layout,
            families,
            materials,
            weight,
            values: vec![],
            numbering: Numbering::default(),
        }
    }

    pub fn add(&mut self, spec: &Spec, p: &Program, tape: &Tape) -> Result<Geometry, SetupError> {
        debug_assert!(tape.outs.len() <= MAX_GEOMETRY && spec.dim == self.layout.dim);
        let keys = self.numbering.outputs(p.family, tape);
        let mut streams = vec![];
        let (mut fresh, mut places) = (vec![], vec![]);
        for (position, key) in keys.into_iter().enumerate() {
            let next = self.values.len() + fresh.len();
            let stream = *self.numbering.streams.entry(key).or_insert(next);
            if stream == next {
                fresh.push(vec![0.0; self.families[p.family].present.len() * CHUNK]);
                places.push(position);
            }
            streams.push(stream);
        }
        if !fresh.is_empty() {
            self.fill(p, &mut fresh, &places);
        }
        self.values.append(&mut fresh);
        Ok(Geometry::Streams(streams))
    }

    /// Each chunk writes its own part of every new stream.
    fn fill(&self, p: &Program, fresh: &mut [Vec<f64>], places: &[usize]) {
        let family = &self.families[p.family];
        let mut parts: Vec<Vec<&mut [f64]>> = (0..self.layout.chunks()).map(|_| vec![]).collect();
        for stream in fresh.iter_mut() {
            let mut rest = &mut stream[..];
            for (chunk, parts) in parts.iter_mut().enumerate() {
                let (part, tail) = rest.split_at_mut(family.rows(chunk).len() * CHUNK);
                parts.push(part);
                rest = tail;
            }
        }
        parts
            .into_par_iter()
            .enumerate()
            .for_each(|(chunk, mut parts)| {
                let (mut out, mut room) = (vec![0.0; p.geometry.outs.len()], vec![]);
                for (n, row) in family.rows(chunk).enumerate() {
                    for lane in 0..CHUNK {
                        let mut bond = self.bond(family, (chunk, row, lane), &mut room);
                        numbers(&p.geometry, &mut bond, &mut out);
                        for (part, &position) in parts.iter_mut().zip(places) {
                            part[n * CHUNK + lane] = out[position];
                        }
                    }
                }
            });
    }

    /// `room` as in [`Materials::on_bond`]. Padding weighs nothing.
    fn bond<'r>(
        &'r self,
        family: &Family,
        (chunk, row, lane): (usize, usize, usize),
        room: &'r mut Vec<f64>,
    ) -> AtReferenceBond<'r> {
        let (node, other) = (
            self.layout.base[chunk] as usize + lane,
            family.other(self.layout, chunk, row, lane),
        );
        let ends = [node, other].map(|slot| self.layout.position(slot));
        let xi = vector(ends, self.layout.dim);
        let pair = self.layout.pair(node, other);
        let there = family.present[row] >> lane & 1 == 1;
        let (constants, weight) = match there {
            true => (
                self.materials.on_bond(pair, ends, room),
                (self.weight)(xi, other, pair),
            ),
            false => (&self.materials.pairs[pair].constants[..], 0.0),
        };
        AtReferenceBond {
            constants,
            influences: &self.materials.pairs[pair].influences,
            xi,
            length: length(xi, self.layout.dim),
            weight,
        }
    }
}

/// From one end to the other.
pub(super) fn vector([a, b]: [[f64; 3]; 2], dim: usize) -> [f64; 3] {
    std::array::from_fn(|k| if k < dim { b[k] - a[k] } else { 0.0 })
}

/// Value numbers: equal operations on equal operands are one value, across tapes of one family.
#[derive(Default)]
struct Numbering {
    values: HashMap<String, usize>,
    streams: HashMap<usize, usize>,
}

impl Numbering {
    fn outputs(&mut self, family: usize, tape: &Tape) -> Vec<usize> {
        let mut numbers: Vec<usize> = vec![];
        for op in &tape.ops {
            let key = match operands(op) {
                none if none.is_empty() => format!("{family} {op:?}"),
                some => {
                    let text = format!("{op:?}");
                    let name = text.split('(').next().unwrap_or(&text);
                    let power = if let Op::Powi(_, n) = op { *n } else { 0 };
                    let ids: Vec<usize> = some.iter().map(|&r| numbers[r as usize]).collect();
                    format!("{family} {name} {power} {ids:?}")
                }
            };
            let next = self.values.len();
            numbers.push(*self.values.entry(key).or_insert(next));
        }
        tape.outs.iter().map(|&r| numbers[r as usize]).collect()
    }
}

/// 1/|xi| as the lanes of an instruction set compute it.
fn reciprocal_length(isa: Isa, dim: usize, xi: [f64; 3]) -> f64 {
    match isa {
        // SAFETY: the settings were checked, so the processor has the instruction set.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { in_avx2(dim, xi) },
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { in_avx512(dim, xi) },
        _ => in_lane::<f64>(dim, xi),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn in_avx2(dim: usize, xi: [f64; 3]) -> f64 {
    in_lane::<crate::lane::Avx2>(dim, xi)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
fn in_avx512(dim: usize, xi: [f64; 3]) -> f64 {
    in_lane::<crate::lane::Avx512>(dim, xi)
}

#[inline(always)]
fn in_lane<L: Memory>(dim: usize, xi: [f64; 3]) -> f64 {
    let v = [L::splat(xi[0]), L::splat(xi[1]), L::splat(xi[2])];
    let square = match dim {
        1 => norm_squared([v[0]]),
        2 => norm_squared([v[0], v[1]]),
        _ => norm_squared(v),
    };
    square.rsqrt().first()
}
