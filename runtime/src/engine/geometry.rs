//! Reference-bond values of every sweep: a table per kind of bond, or streams per bond.
use super::constants::{AtReferenceBond, Materials};
use super::program::Program;
use crate::kernel::norm_squared;
use crate::lane::{Isa, Memory};
use crate::layout::{Family, Layout, Stencil};
use crate::spec::{Op, Spec, Tape};
use crate::tape::{Code, Leaf, Many, length, numbers, operands};
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
    numbering: Numbering,
    /// How many there are.
    count: usize,
    /// Of every family: tapes, and which of their outputs are streams that no earlier tape has.
    fresh: Vec<Vec<(&'a Code, Vec<usize>)>>,
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
            numbering: Numbering::default(),
            count: 0,
            fresh: vec![vec![]; families.len()],
        }
    }

    pub fn add(&mut self, spec: &Spec, p: &'a Program, tape: &Tape) -> Geometry {
        debug_assert!(tape.outs.len() <= MAX_GEOMETRY && spec.dim == self.layout.dim);
        let keys = self.numbering.outputs(p.family, tape);
        let (mut streams, mut fresh) = (vec![], vec![]);
        for (position, key) in keys.into_iter().enumerate() {
            let next = self.count + fresh.len();
            let stream = *self.numbering.streams.entry(key).or_insert(next);
            if stream == next {
                fresh.push(position);
            }
            streams.push(stream);
        }
        self.count += fresh.len();
        if !fresh.is_empty() {
            self.fresh[p.family].push((&p.geometry, fresh));
        }
        Geometry::Streams(streams)
    }

    /// All streams, by number.
    pub fn values(&self) -> Vec<Vec<f64>> {
        // Numbers were given out sweep by sweep, and a sweep has one family.
        let mut values = vec![vec![]; self.count];
        for (k, family) in self.families.iter().enumerate() {
            let cells = family.present.len() * CHUNK;
            let mine = self.numbering.streams.iter();
            let mut mine: Vec<usize> = mine.filter(|s| s.0.0 == k).map(|s| *s.1).collect();
            mine.sort_unstable();
            let mut streams: Vec<Vec<f64>> = mine.iter().map(|_| vec![0.0; cells]).collect();
            self.fill(family, &self.fresh[k], &mut streams);
            for (to, stream) in mine.into_iter().zip(streams) {
                values[to] = stream;
            }
        }
        values
    }

    /// Each chunk writes its own part of every stream. A bond is looked at once, for all tapes.
    fn fill(&self, family: &Family, tapes: &[(&Code, Vec<usize>)], streams: &mut [Vec<f64>]) {
        let Some(most) = tapes.iter().map(|t| Many::most(t.0)).min() else {
            return;
        };
        let mut parts: Vec<Vec<&mut [f64]>> = (0..self.layout.chunks()).map(|_| vec![]).collect();
        for stream in streams {
            let mut rest = &mut stream[..];
            for (chunk, parts) in parts.iter_mut().enumerate() {
                let (part, tail) = rest.split_at_mut(family.rows(chunk).len() * CHUNK);
                parts.push(part);
                rest = tail;
            }
        }
        let each = |room: &mut (Many, Many), (chunk, mut parts): (usize, Vec<&mut [f64]>)| {
            let cells = family.rows(chunk).len() * CHUNK;
            for first in (0..cells).step_by(most) {
                let count = most.min(cells - first);
                let mut rooms = vec![vec![]; count];
                let bonds: Vec<AtReferenceBond> = (first..)
                    .zip(&mut rooms)
                    .map(|(cell, room)| {
                        let row = family.rows(chunk).start + cell / CHUNK;
                        self.bond(family, (chunk, row, cell % CHUNK), room)
                    })
                    .collect();
                let lengths: Vec<f64> = bonds.iter().map(|bond| bond.length).collect();
                let mut leaf = |leaf: Leaf, k: usize, to: &mut [f64]| match leaf {
                    Leaf::X => to.copy_from_slice(&lengths),
                    Leaf::Omega => omega(&bonds, k, &lengths, &mut room.1, to),
                    _ => {
                        for (to, bond) in to.iter_mut().zip(&bonds) {
                            *to = bond.value(leaf, k);
                        }
                    }
                };
                let mut parts = parts.iter_mut();
                for (code, places) in tapes {
                    let mut places = places.iter().peekable();
                    room.0.run(code, count, &mut leaf, &mut |position, values| {
                        if places.next_if_eq(&&position).is_some()
                            && let Some(part) = parts.next()
                        {
                            part[first..first + count].copy_from_slice(values);
                        }
                    });
                }
            }
        };
        let room = || (Many::new(), Many::new());
        let parts = parts.into_par_iter().enumerate();
        parts.for_each_init(room, each);
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

/// Influence function `k` on bonds: those between the same materials, side by side, in one go.
fn omega(bonds: &[AtReferenceBond], k: usize, lengths: &[f64], many: &mut Many, to: &mut [f64]) {
    let mut from = 0;
    for alike in bonds.chunk_by(|a, b| std::ptr::eq(a.influences, b.influences)) {
        let these = from..from + alike.len();
        alike[0].influences[k].each(many, &lengths[these.clone()], &mut to[these.clone()]);
        from = these.end;
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
    /// By family and value.
    streams: HashMap<(usize, usize), usize>,
}

impl Numbering {
    fn outputs(&mut self, family: usize, tape: &Tape) -> Vec<(usize, usize)> {
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
        let outs = tape.outs.iter();
        outs.map(|&r| (family, numbers[r as usize])).collect()
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
