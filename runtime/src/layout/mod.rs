//! Where nodes and bonds live: layout slots, chunks, rows, families.
//!
//! Node arrays have one value per *slot*. Real nodes, padding and ghosts are slots; a ghost is the periodic
//! image of a node, its values are copied from the node's slot before a sweep reads them at the other end
//! of a bond. Bond arrays have eight values per *row* (see [`crate::traverse`]), masks one byte.
mod cloud;
mod lattice;
mod search;

pub(crate) use cloud::cloud;
pub(crate) use lattice::{lattice, plan_lattice};

use crate::fourier::Axis;
use crate::traverse::CHUNK;
use rayon::prelude::*;
use std::sync::Arc;

/// Relative slack of the squared horizon: a neighbour at exactly delta belongs to the family, however rounded.
pub(crate) const INCLUSIVE: f64 = 1.0 + 1e-9;

/// No user node: padding and ghosts.
pub(crate) const NONE: u32 = u32::MAX;

/// Keeps a bond for a named family: reference positions of its ends [m], weight [m^3], pair of materials.
pub(crate) type Filter<'a> = &'a (dyn Fn([[f64; 3]; 2], f64, usize) -> bool + Sync);

/// Nodes in slots, slots in chunks.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    pub dim: usize,
    /// Number of slots.
    pub len: usize,
    /// User node -> slot, and back (`NONE` in padding; ghosts name their user node's slot through `ghosts`).
    pub slot: Vec<u32>,
    pub user: Vec<u32>,
    /// Reference positions per slot; ghosts at the image.
    pub x: [Vec<f64>; 3],
    /// Node volumes, 0 in padding and ghosts.
    pub volume: Vec<f64>,
    pub base: Vec<u32>,
    pub nodes: Vec<u8>,
    /// Slot -> chunk, `NONE` where no node is.
    pub chunk_of: Vec<u32>,
    pub ghosts: Ghosts,
    /// Chunks of each material; a chunk has one.
    pub parts: Vec<std::ops::Range<usize>>,
}

/// Periodic images: slot `to[k]` repeats slot `from[k]`.
#[derive(Debug, Default)]
pub(crate) struct Ghosts {
    pub to: Vec<u32>,
    pub from: Vec<u32>,
    /// Slot -> the slot it repeats (itself for nodes); empty without ghosts.
    pub origin: Vec<u32>,
}

impl Ghosts {
    pub fn new(to: Vec<u32>, from: Vec<u32>, len: usize) -> Ghosts {
        let mut origin = vec![];
        if !to.is_empty() {
            origin = (0..len as u32).collect();
            for (&t, &f) in to.iter().zip(&from) {
                origin[t as usize] = f;
            }
        }
        Ghosts { to, from, origin }
    }

    pub fn refresh(&self, values: &mut [f64]) {
        for (&t, &f) in self.to.iter().zip(&self.from) {
            values[t as usize] = values[f as usize];
        }
    }

    #[inline]
    pub fn origin(&self, slot: usize) -> usize {
        self.origin.get(slot).map_or(slot, |&s| s as usize)
    }
}

impl Layout {
    /// Slots of some chunks, and all ghosts.
    pub fn slots_of(&self, chunks: impl Iterator<Item = usize>) -> impl Iterator<Item = usize> {
        let base = |chunk: usize| self.base[chunk] as usize;
        let own = chunks.flat_map(move |chunk| base(chunk)..base(chunk) + CHUNK);
        own.chain(self.ghosts.to.iter().map(|slot| *slot as usize))
    }

    pub fn chunks(&self) -> usize {
        self.base.len()
    }

    /// (chunk, lane) of a node or of the node that a ghost repeats.
    pub fn place(&self, slot: usize) -> (usize, usize) {
        let slot = self.ghosts.origin(slot);
        (self.chunk_of[slot] as usize, slot % CHUNK)
    }

    /// Position of the materials of two slots among all pairs.
    pub fn pair(&self, from: usize, to: usize) -> usize {
        if self.parts.len() < 2 {
            return 0;
        }
        let material = |slot: usize| {
            let (chunk, _) = self.place(slot);
            self.parts.partition_point(|part| part.end <= chunk)
        };
        material(from) * self.parts.len() + material(to)
    }

    pub fn position(&self, slot: usize) -> [f64; 3] {
        [self.x[0][slot], self.x[1][slot], self.x[2][slot]]
    }

    pub fn bytes(&self) -> usize {
        8 * self.len * (self.dim.max(1) + 1)
            + 4 * (self.slot.len() + self.user.len() + self.chunk_of.len() + self.base.len())
    }
}

/// What a lattice is made of, from its fastest axis to its slowest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells {
    pub axes: [Axis; 3],
    /// Slots from cell to cell, the slot of the first cell, and which direction of space each axis has.
    pub stride: [usize; 3],
    pub first: usize,
    pub direction: [usize; 3],
    /// [m]
    pub spacing: f64,
}

impl Cells {
    /// Cells from one end of a bond to the other, along each axis.
    pub fn step(&self, xi: [f64; 3]) -> [i64; 3] {
        self.direction
            .map(|a| (xi[a] / self.spacing).round() as i64)
    }
}

/// Bonds of one family.
#[derive(Debug)]
pub(crate) struct Family {
    /// Per chunk: its rows are `first..last`.
    pub first: Vec<u32>,
    pub last: Vec<u32>,
    /// One byte per row: bonds of the reference family.
    pub present: Arc<Vec<u8>>,
    /// Directed bonds.
    pub bonds: usize,
    pub shape: Shape,
}

#[derive(Debug)]
pub(crate) enum Shape {
    /// All bonds of a row are alike.
    Stencil(Stencil),
    List(List),
}

/// Neighbour slots: eight per row, or one per row in a chunk of *runs*, whose rows lead to eight slots side by side each.
#[derive(Debug, Default)]
pub(crate) struct List {
    pub index: Vec<u32>,
    /// Where the slots of each chunk begin, and where the last ones end.
    pub at: Vec<u32>,
}

impl List {
    /// Whether a chunk of so many rows has runs.
    #[inline]
    fn are_runs(&self, chunk: usize, rows: usize) -> bool {
        (self.at[chunk + 1] - self.at[chunk]) as usize == rows
    }
}

/// The bonds of a lattice: few kinds, and few ways in which they follow one another.
#[derive(Debug, Default)]
pub(crate) struct Stencil {
    pub kinds: Vec<Kind>,
    /// Lists of kinds, ascending, one behind the other.
    pub patterns: Vec<u32>,
    /// Per chunk: where the list of its rows begins. Chunks whose rows are alike share one.
    pub pattern: Vec<u32>,
}

/// A bond that many nodes of a lattice have: a step to another cell, between two materials.
#[derive(Clone, Debug)]
pub(crate) struct Kind {
    /// From slot to slot.
    pub offset: i64,
    pub xi: [f64; 3],
    pub weight: f64,
    /// Of materials.
    pub pair: u32,
    /// The reverse bond.
    pub opposite: Option<u32>,
}

/// Slots at the other ends of the bonds of one chunk.
#[derive(Clone, Copy)]
enum Ends<'a> {
    Steps {
        first: usize,
        base: i64,
        kinds: &'a [Kind],
        rows: &'a [u32],
    },
    /// The rows from `first` on, with one slot or eight.
    List {
        first: usize,
        runs: bool,
        index: &'a [u32],
    },
}

impl Ends<'_> {
    #[inline]
    fn slot(&self, row: usize, lane: usize) -> usize {
        match *self {
            Ends::Steps {
                first,
                base,
                kinds,
                rows,
            } => (base + lane as i64 + kinds[rows[row - first] as usize].offset) as usize,
            Ends::List { first, runs, index } => match runs {
                true => index[row - first] as usize + lane,
                false => index[(row - first) * CHUNK + lane] as usize,
            },
        }
    }
}

/// A directed bond met by [`Family::for_each`].
#[derive(Clone, Copy)]
pub(crate) struct Met {
    pub row: usize,
    pub lane: usize,
    /// Slot of the node, and of the other end (possibly a ghost).
    pub node: usize,
    pub other: usize,
}

impl Met {
    #[inline]
    pub fn bit(&self) -> u8 {
        1 << self.lane
    }
}

impl Family {
    #[inline]
    pub fn rows(&self, chunk: usize) -> std::ops::Range<usize> {
        self.first[chunk] as usize..self.last[chunk] as usize
    }

    /// Slot of the other end.
    pub fn other(&self, layout: &Layout, chunk: usize, row: usize, lane: usize) -> usize {
        self.ends(layout, chunk).slot(row, lane)
    }

    /// Where the bonds of a chunk lead to.
    #[inline]
    fn ends(&self, layout: &Layout, chunk: usize) -> Ends<'_> {
        match &self.shape {
            Shape::Stencil(stencil) => Ends::Steps {
                first: self.first[chunk] as usize,
                base: layout.base[chunk] as i64,
                kinds: &stencil.kinds,
                rows: self.kinds(stencil, chunk),
            },
            Shape::List(list) => {
                let index = &list.index[list.at[chunk] as usize..list.at[chunk + 1] as usize];
                let rows = self.rows(chunk);
                Ends::List {
                    first: rows.start,
                    runs: list.are_runs(chunk, rows.len()),
                    index,
                }
            }
        }
    }

    /// Kinds of the rows of a chunk.
    #[inline]
    fn kinds<'a>(&self, stencil: &'a Stencil, chunk: usize) -> &'a [u32] {
        let from = stencil.pattern[chunk] as usize;
        &stencil.patterns[from..from + self.rows(chunk).len()]
    }

    /// Bytes of lists per bond, and the part of the chunks that have runs.
    pub fn lists(&self) -> (f64, f64) {
        let Shape::List(list) = &self.shape else {
            return (0.0, 0.0);
        };
        let chunks = self.first.len();
        let runs = (0..chunks).filter(|&chunk| list.are_runs(chunk, self.rows(chunk).len()));
        (
            (4 * list.index.len()) as f64 / self.bonds.max(1) as f64,
            runs.count() as f64 / chunks.max(1) as f64,
        )
    }

    /// Marks the slots, eight by eight, that rows of lists lead to.
    pub fn mark_listed(&self, marks: &mut [bool]) {
        let Shape::List(list) = &self.shape else {
            return;
        };
        for chunk in 0..self.first.len() {
            if !list.are_runs(chunk, self.rows(chunk).len()) {
                let slots = &list.index[list.at[chunk] as usize..list.at[chunk + 1] as usize];
                for &slot in slots {
                    marks[slot as usize / CHUNK] = true;
                }
            }
        }
    }

    /// Visits the reference bonds of a chunk in the order of the sums.
    #[inline]
    pub fn for_each(&self, layout: &Layout, chunk: usize, mut visit: impl FnMut(Met)) {
        let (ends, base) = (self.ends(layout, chunk), layout.base[chunk] as usize);
        for row in self.rows(chunk) {
            let mut bits = self.present[row];
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                visit(Met {
                    row,
                    lane,
                    node: base + lane,
                    other: ends.slot(row, lane),
                });
            }
        }
    }

    /// For every bond the position of the reverse bond in a per-bond array; bonds without one (a filter that
    /// tells directions apart) point to an extra row at the end.
    pub fn reverse(&self, layout: &Layout) -> Vec<u32> {
        let rows = self.present.len();
        let mut reverse = vec![(rows * CHUNK) as u32; rows * CHUNK];
        match &self.shape {
            Shape::Stencil(stencil) => {
                for chunk in 0..layout.chunks() {
                    let (kinds, first) = (self.kinds(stencil, chunk), self.rows(chunk).start);
                    self.for_each(layout, chunk, |m| {
                        let kind = &stencil.kinds[kinds[m.row - first] as usize];
                        let (c, lane) = layout.place(m.other);
                        let back = kind
                            .opposite
                            .and_then(|k| self.kinds(stencil, c).binary_search(&k).ok());
                        if let Some(back) = back {
                            let row = self.rows(c).start + back;
                            reverse[m.row * CHUNK + m.lane] = (row * CHUNK + lane) as u32;
                        }
                    });
                }
            }
            Shape::List(_) => self.reverse_of_list(layout, &mut reverse),
        }
        reverse
    }

    /// Finds j -> i among the bonds of j: the one that leads back to i with the opposite bond vector.
    fn reverse_of_list(&self, layout: &Layout, reverse: &mut [u32]) {
        let found: Vec<Vec<(usize, u32)>> = (0..layout.chunks())
            .into_par_iter()
            .map(|chunk| {
                let mut pairs = vec![];
                self.for_each(layout, chunk, |m| {
                    if let Some(back) = self.find_back(layout, m) {
                        pairs.push((m.row * CHUNK + m.lane, back as u32));
                    }
                });
                pairs
            })
            .collect();
        for (bond, back) in found.into_iter().flatten() {
            reverse[bond] = back;
        }
    }

    fn find_back(&self, layout: &Layout, m: Met) -> Option<usize> {
        let (chunk, lane) = layout.place(m.other);
        let far = layout.ghosts.origin(m.other);
        let difference = |a: usize, b: usize, k: usize| layout.x[k][b] - layout.x[k][a];
        let mut best: Option<(f64, usize)> = None;
        for row in self.rows(chunk) {
            let end = self.other(layout, chunk, row, lane);
            if self.present[row] >> lane & 1 == 1 && layout.ghosts.origin(end) == m.node {
                // Several images of one node can be neighbours: the opposite vector decides.
                let miss: f64 = (0..layout.dim)
                    .map(|k| (difference(m.node, m.other, k) + difference(far, end, k)).powi(2))
                    .sum();
                if best.is_none_or(|b| miss < b.0) {
                    best = Some((miss, row * CHUNK + lane));
                }
            }
        }
        best.map(|b| b.1)
    }

    pub fn bytes(&self) -> usize {
        let list = match &self.shape {
            Shape::Stencil(s) => 4 * (s.patterns.len() + s.pattern.len()),
            Shape::List(list) => 4 * (list.index.len() + list.at.len()),
        };
        list + self.present.len() + 8 * self.first.len()
    }
}

/// v_ij of the partial-volume rule (shared by LAMMPS and others): 1 inside delta - dx/2, then linear, 1/2 at delta.
pub(crate) fn partial_volume(r: f64, delta: f64, spacing: f64) -> f64 {
    if r <= delta - 0.5 * spacing {
        1.0
    } else {
        ((delta + 0.5 * spacing - r) / spacing).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use crate::body::{Body, Flavour, Grid};

    /// A node of volume 1 in every cell of a box, the first axis fastest.
    pub fn cells(flavour: Flavour, shape: [u32; 3]) -> Body {
        let [nx, ny, nz] = shape;
        let cell = (0..nx * ny * nz).map(|k| [k % nx, k / nx % ny, k / nx / ny]);
        let cell: Vec<[u32; 3]> = cell.collect();
        Body {
            flavour,
            x: cell.iter().map(|c| c.map(f64::from)).collect(),
            volume: vec![1.0; cell.len()],
            material: vec![],
            regions: vec![],
            horizon: vec![],
            cross: 1.0,
            grid: Some(Grid {
                origin: [0.0; 3],
                spacing: 1.0,
                shape,
                cell,
            }),
            spacing: 1.0,
            periodic: [None; 3],
        }
    }
}
