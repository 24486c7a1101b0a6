//! Reference-bond values of every sweep: a table per kind of bond, or what they are formed from, bond by bond.
use super::constants::{AtReferenceBond, Materials};
use super::program::Program;
use super::{Engine, Precision};
use crate::kernel::norm_squared;
use crate::lane::{Isa, Memory};
use crate::layout::{Family, Layout, Stencil};
use crate::pages::zeros;
use crate::spec::{Op, Spec, Stage, Tape};
use crate::tape::{Code, Leaf, Many, length, numbers, operands};
use crate::traverse::{CHUNK, Stream};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::ptr::null;

/// Of one sweep.
#[derive(Debug)]
pub(super) enum Geometry {
    /// A record per kind of bond: offset (the bits of an i64), xi, 1/|xi|, values, two in a place in single precision. And, in the order of
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
    precision: Precision,
) -> Geometry {
    let single = precision == Precision::Single;
    let mut of_bond = vec![0.0; 1 + dim + p.geometry.outs.len()];
    let stride = 1 + match single {
        true => of_bond.len().div_ceil(2),
        false => of_bond.len(),
    };
    let mut values = vec![0.0; stencil.kinds.len() * stride];
    for (record, kind) in values.chunks_exact_mut(stride).zip(&stencil.kinds) {
        record[0] = f64::from_bits(kind.offset as u64);
        of_bond[..dim].copy_from_slice(&kind.xi[..dim]);
        of_bond[dim] = reciprocal_length(isa, dim, kind.xi);
        let pair = &materials.pairs[kind.pair as usize];
        let bond = AtReferenceBond {
            constants: &pair.constants,
            influences: &pair.influences,
            xi: kind.xi,
            length: length(kind.xi, dim),
            weight: kind.weight,
        };
        numbers(&p.geometry, &mut { bond }, &mut of_bond[1 + dim..]);
        match single {
            true => pairs(&of_bond, &mut record[1..]),
            false => record[1..].copy_from_slice(&of_bond),
        }
    }
    let record = |&kind: &u32| values[kind as usize * stride..].as_ptr() as usize;
    let records = stencil.patterns.iter().map(record).collect();
    Geometry::Table { values, records }
}

/// Rounded to single precision, two in the place of one. What was finite stays so.
fn pairs(values: &[f64], to: &mut [f64]) {
    for (to, values) in to.iter_mut().zip(values.chunks(2)) {
        let mut bytes = [0; 8];
        for (bytes, v) in bytes.chunks_exact_mut(4).zip(values) {
            let single = match v.is_finite() {
                true => v.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32,
                false => *v as f32,
            };
            bytes.copy_from_slice(&single.to_ne_bytes());
        }
        *to = f64::from_ne_bytes(bytes);
    }
}

/// A stream of a cloud: eight numbers per row, eight for all rows where they would be alike, or, where few rows differ,
/// eight for each of these and the place of its own in every row.
#[derive(Debug, PartialEq)]
pub(super) struct Kept {
    values: Vec<f64>,
    alike: bool,
    rows: Vec<u32>,
}

/// Rows that must share eight numbers on average for them to be stored apart.
const SHARED: usize = 16;

impl Kept {
    fn alike(value: f64) -> Kept {
        Kept {
            values: vec![value; CHUNK],
            alike: true,
            rows: vec![],
        }
    }

    /// Of all bonds of a family. Nobody reads what stands in lanes without a bond: like another of the row, it makes no row
    /// that differs from others for its sake.
    fn new(mut values: Vec<f64>, family: &Family) -> Kept {
        for (row, &bits) in values.chunks_exact_mut(CHUNK).zip(&*family.present) {
            if let Some(&there) = row.get(bits.trailing_zeros() as usize) {
                let lanes = row.iter_mut().enumerate();
                lanes
                    .filter(|(lane, _)| bits >> lane & 1 == 0)
                    .for_each(|(_, v)| *v = there);
            }
        }
        let first = values.first().copied().unwrap_or(0.0);
        if values.iter().all(|v| v.to_bits() == first.to_bits()) {
            return Kept::alike(first);
        }
        let (values, rows) = match few(&values) {
            Some(few) => few,
            None => (values, vec![]),
        };
        Kept {
            values,
            alike: false,
            rows,
        }
    }

    pub fn call(&self) -> Stream {
        let (values, eight) = (self.values.as_ptr(), CHUNK * size_of::<f64>());
        match self.rows.is_empty() {
            true => Stream {
                rows: values.cast(),
                step: if self.alike { 0 } else { eight },
                table: null(),
            },
            false => Stream {
                rows: self.rows.as_ptr().cast(),
                step: size_of::<u32>(),
                table: values,
            },
        }
    }

    /// Has a number for every bond.
    pub fn differs(&self) -> bool {
        !self.alike
    }

    pub fn bytes(&self) -> usize {
        8 * self.values.len() + 4 * self.rows.len()
    }
}

/// The rows that differ, and the place of every row among them; None where they are many. A body cut from a lattice has
/// few, since its neighbours are in the order of where they lie.
fn few(values: &[f64]) -> Option<(Vec<f64>, Vec<u32>)> {
    let mut known: HashMap<[u64; CHUNK], u32> = HashMap::new();
    let (mut differ, mut places) = (vec![], Vec::with_capacity(values.len() / CHUNK));
    for (k, row) in values.chunks_exact(CHUNK).enumerate() {
        let next = known.len() as u32;
        let bits = std::array::from_fn(|lane| row[lane].to_bits());
        let place = *known.entry(bits).or_insert(next);
        if place == next {
            differ.extend_from_slice(row);
        }
        places.push(place);
        // A jittered cloud is known for one by its first rows.
        if known.len() > 1024 + k / SHARED {
            return None;
        }
    }
    (known.len() * SHARED <= places.len()).then_some((differ, places))
}

/// Makes one of streams that have the same values: `omega w` and `w` where the influence function is 1.
pub(super) fn share(streams: &mut [Kept], geometry: &mut [Geometry]) {
    let mut places: Vec<usize> = (0..streams.len()).collect();
    for k in 0..streams.len() {
        let (before, rest) = streams.split_at_mut(k);
        let same = before.iter().position(|s| *s == rest[0]);
        if let Some(same) = same.filter(|_| rest[0].differs()) {
            places[k] = same;
            rest[0] = Kept::alike(0.0);
        }
    }
    for geometry in geometry {
        if let Geometry::Streams(list) = geometry {
            list.iter_mut().for_each(|k| *k = places[*k]);
        }
    }
}

/// How many streams have a number for every bond, as far as the law tells.
pub(super) fn streams_of_bonds(spec: &Spec, programs: &[Program], materials: usize) -> usize {
    let mut numbering = Numbering::default();
    let mut found = HashSet::new();
    for (p, s) in programs.iter().zip(&spec.sweeps) {
        let constant = constant(&s.streams);
        let keys = numbering.outputs(p.family, &s.streams).into_iter();
        let kept = |(_, constant): &(_, bool)| !constant || materials > 1;
        found.extend(keys.zip(constant).filter(kept).map(|(key, _)| key));
    }
    found.len()
}

/// Of every output, whether it is made of constants alone.
fn constant(tape: &Tape) -> Vec<bool> {
    let mut found: Vec<bool> = vec![];
    for op in &tape.ops {
        let here = matches!(op, Op::Const(_) | Op::Lit(_) | Op::Inf);
        let from = operands(op);
        found.push(here || !from.is_empty() && from.iter().all(|&r| found[r as usize]));
    }
    tape.outs.iter().map(|&r| found[r as usize]).collect()
}

/// Streams for a cloud. Sweeps that need the same value of the same family share its stream.
pub(super) struct Streams<'a> {
    pub layout: &'a Layout,
    pub families: &'a [Family],
    pub materials: &'a Materials<'a>,
    /// Weight [m^3] of the bond to a slot, between a pair of materials.
    pub weight: &'a (dyn Fn([f64; 3], usize, usize) -> f64 + Sync),
    numbering: Numbering,
    /// Those that are the same on all bonds; the others get their values last.
    known: Vec<Option<f64>>,
    /// Of every family: tapes, and which of their outputs are the streams of these numbers, which no earlier tape has.
    fresh: Vec<Vec<Fresh<'a>>>,
}

struct Fresh<'a> {
    code: &'a Code,
    outputs: Vec<usize>,
    streams: Vec<usize>,
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
            known: vec![],
            fresh: families.iter().map(|_| vec![]).collect(),
        }
    }

    pub fn add(&mut self, p: &'a Program, tape: &Tape) -> Geometry {
        let mut fresh = Fresh {
            code: &p.geometry,
            outputs: vec![],
            streams: vec![],
        };
        let constant = constant(tape);
        let mut streams = vec![];
        for (output, key) in self
            .numbering
            .outputs(p.family, tape)
            .into_iter()
            .enumerate()
        {
            let next = self.known.len();
            let stream = *self.numbering.streams.entry(key).or_insert(next);
            streams.push(stream);
            if stream < next {
                continue;
            }
            let known = constant[output] && self.materials.count == 1;
            self.known.push(known.then(|| self.of_constants(p, output)));
            if !known {
                fresh.outputs.push(output);
                fresh.streams.push(stream);
            }
        }
        if !fresh.outputs.is_empty() {
            self.fresh[p.family].push(fresh);
        }
        Geometry::Streams(streams)
    }

    /// An output that is made of constants.
    fn of_constants(&self, p: &Program, output: usize) -> f64 {
        let pair = &self.materials.pairs[0];
        let mut anywhere = AtReferenceBond {
            constants: &pair.constants,
            influences: &pair.influences,
            xi: [0.0; 3],
            length: 0.0,
            weight: 0.0,
        };
        let mut outputs = vec![0.0; p.geometry.outs.len()];
        numbers(&p.geometry, &mut anywhere, &mut outputs);
        outputs[output]
    }

    /// All streams, by number.
    pub fn values(&self) -> Vec<Kept> {
        let known = |value: &Option<f64>| Kept::alike(value.unwrap_or(0.0));
        let mut kept: Vec<Kept> = self.known.iter().map(known).collect();
        for (family, fresh) in self.families.iter().zip(&self.fresh) {
            let cells = family.present.len() * CHUNK;
            let places = fresh.iter().flat_map(|tape| &tape.streams);
            let mut streams: Vec<Vec<f64>> = places.clone().map(|_| zeros(cells)).collect();
            self.fill(family, fresh, &mut streams);
            for (&to, stream) in places.zip(streams) {
                kept[to] = Kept::new(stream, family);
            }
        }
        kept
    }

    /// Each chunk writes its own part of every stream. A bond is looked at once, for all tapes.
    fn fill(&self, family: &Family, tapes: &[Fresh], streams: &mut [Vec<f64>]) {
        let Some(most) = tapes.iter().map(|t| Many::most(t.code)).min() else {
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
                for tape in tapes {
                    let mut places = tape.outputs.iter().peekable();
                    room.0
                        .run(tape.code, count, &mut leaf, &mut |position, values| {
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

impl Engine {
    /// What only sweeps of the reference stage read, which never run again.
    pub(super) fn drop_streams_of_the_reference(&mut self) {
        let mut needed = vec![false; self.streams.len()];
        for (p, geometry) in self.programs.iter().zip(&mut self.geometry) {
            let Geometry::Streams(streams) = geometry else {
                continue;
            };
            if p.stage == Stage::Reference {
                streams.clear();
            }
            streams.iter().for_each(|&k| needed[k] = true);
        }
        for (stream, _) in self.streams.iter_mut().zip(needed).filter(|s| !s.1) {
            *stream = Kept::alike(0.0);
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
