//! The loops: nodes eight at a time, their bonds one row after the other.
//!
//! Both traversals work on chunks. A chunk is eight consecutive layout slots; a *row* is one bond of each of
//! them, with one mask byte (bit k: the bond of lane k counts). On a lattice all bonds of a row are of one
//! kind; in a cloud a row is a column of the SELL-8 block. Narrower lanes take a chunk in 8 / W parts.
//!
//! Nothing here branches on a law. `MASKED = false` is the instance for chunks whose families are whole:
//! it reads no masks and cannot break bonds.
mod cloud;
mod convolved;
mod interpreted;
mod lattice;

pub(crate) use convolved::{Convolved, Factor, RunConvolved, Term, convolved};
pub(crate) use interpreted::{interpreted, interpreted_single};

use crate::engine::records::Pack;
use crate::kernel::{Bond, Lane, Node, Streams, Sweep};
use crate::lane::{Memory, Record};
use crate::tape::{Blocks, TapeSweep};
use std::ptr::null;

/// Nodes in a chunk, and bits in a row's mask.
pub const CHUNK: usize = 8;
/// Most slots that a sweep may list for reading at the node, at the other end, or for writing.
pub const MAX_SLOTS: usize = 128;
/// Most reference-bond values of a sweep, and most streams.
pub const MAX_GEOMETRY: usize = 32;
/// Most records of a sweep besides positions and displacements.
pub(crate) const MAX_RECORDS: usize = MAX_SLOTS / RECORD;
/// Numbers in a record.
pub(crate) const RECORD: usize = 4;
/// Most bond histories of a sweep.
pub const MAX_HISTORIES: usize = 16;

/// How many of the slots at the head of a sweep's `nbr` list a cloud reads from records, when sweeps have formed so
/// many: a single number is as fast to gather.
pub(crate) const fn recorded(formed: usize) -> usize {
    if formed % RECORD == 1 {
        formed - 1
    } else {
        formed
    }
}

/// Everything one run of one sweep reads and writes, as addresses. Made by the engine.
#[derive(Clone)]
pub struct Call {
    /// Displacements: arrays on a lattice, records in a cloud, where positions are records too. A lattice reads these, and
    /// `nbr`, as numbers of the lane's own precision ([`Memory::Near`]).
    pub(crate) u: [*const f64; 3],
    pub(crate) u_records: *const Record,
    pub(crate) x_records: *const Record,
    pub(crate) own: [*const f64; MAX_SLOTS],
    pub(crate) nbr: [*const f64; MAX_SLOTS],
    /// Cloud: the slots of `nbr` that are read from records, four by four.
    pub(crate) nbr_records: [*const Record; MAX_RECORDS],
    pub(crate) out: [*mut f64; MAX_SLOTS],
    /// Constants of all materials, and per chunk where those of its material begin.
    pub(crate) constants: *const f64,
    pub(crate) constants_at: *const u32,
    /// Per chunk: first slot, occupied lanes, rows `first..last`.
    pub(crate) base: *const u32,
    pub(crate) nodes: *const u8,
    pub(crate) first: *const u32,
    pub(crate) last: *const u32,
    /// Per row. Written only where a bond breaks.
    pub(crate) bits: *mut u8,
    /// Bonds that may break, one byte per row or one for all (`armed_step` 1 or 0).
    pub(crate) armed: *const u8,
    pub(crate) armed_step: usize,
    /// Per chunk: bonds broken by this call are added.
    pub(crate) broken: *mut u32,
    /// Lattice: per chunk the place in `records` where those of its rows begin. A record: offset (an i64), then, in the
    /// lane's precision, xi, 1/|xi|, geometry.
    pub(crate) pattern: *const u32,
    pub(crate) records: *const *const f64,
    /// Cloud: neighbour slots as [`crate::layout::List`] has them, positions for the runs, and what is kept of the bonds.
    pub(crate) index: *const u32,
    pub(crate) index_at: *const u32,
    pub(crate) x: [*const f64; 3],
    pub(crate) streams: [Stream; MAX_GEOMETRY],
    /// Per row eight values: committed, next, and the position of the reverse bond's value.
    pub(crate) history: [*const f64; MAX_HISTORIES],
    pub(crate) next: [*mut f64; MAX_HISTORIES],
    pub(crate) reverse: *const u32,
    pub(crate) tape: *const TapeSweep,
    /// Records that hold what this run writes.
    pub(crate) packs: *const [Pack],
}

// SAFETY: a call is shared between threads that run disjoint chunks; what a chunk writes (its own slots, mask
// bytes, histories and counter) no other chunk touches.
unsafe impl Sync for Call {}

/// Numbers of the bonds of a cloud: eight per row; or eight for all rows, where all bonds have the same; or of every row the
/// place of its own in a table, where few rows differ.
#[derive(Clone, Copy)]
pub(crate) struct Stream {
    /// What is read row by row, and how many bytes lie from one row to the next.
    pub rows: *const u8,
    pub step: usize,
    /// Null where the rows are the numbers.
    pub table: *const f64,
}

impl Stream {
    pub const NONE: Stream = Stream {
        rows: null(),
        step: 0,
        table: null(),
    };

    /// The eight numbers of a row.
    ///
    /// # Safety
    /// The stream has this row.
    #[inline(always)]
    unsafe fn at(self, row: usize) -> *const f64 {
        let here = self.source(row);
        match self.table.is_null() {
            true => here.cast(),
            false => {
                let place = unsafe { *here.cast::<u32>() };
                self.table.wrapping_add(place as usize * CHUNK)
            }
        }
    }

    /// What is read of a row, which may lie beyond the last.
    #[inline(always)]
    fn source(self, row: usize) -> *const u8 {
        self.rows.wrapping_add(row * self.step)
    }
}

/// The bonds of the nodes of one part of a chunk, one of each node per row.
pub(crate) trait Rows<L: Lane, const D: usize> {
    type Bond<'a>: Bond<L, D>
    where
        Self: 'a;
    /// Those of runs.
    type Run<'a>: Bond<L, D>
    where
        Self: 'a;
    fn count(&self) -> usize;
    fn are_runs(&self) -> bool;
    /// # Safety
    /// `k` is below the count, and the rows are runs.
    unsafe fn run(&self, k: usize) -> Self::Run<'_>;
    /// # Safety
    /// `k` is below the count, and the rows are no runs.
    unsafe fn bond(&self, k: usize) -> Self::Bond<'_>;
    /// Fetches what rows some way behind `k` will read.
    #[inline(always)]
    fn ahead(&self, _k: usize) {}
}

/// What happens at a node: a compiled sweep takes its bonds one by one, an interpreted one in blocks.
pub(crate) trait Body<const D: usize> {
    /// # Safety
    /// The processor has the instruction set of the lane, and the rows are those of the node.
    unsafe fn run<L: Blocks, N: Node<L>, R: Rows<L, D>>(&self, node: &mut N, rows: &R);
    /// Number of the streams in a cloud.
    fn streams(&self) -> usize;
    /// Number of slots of the other end that a cloud reads from records.
    fn recorded(&self) -> usize;
    /// Reference-bond value from what a cloud keeps.
    fn geo<L: Lane, B: Bond<L, D> + Streams<L>>(&self, bond: &B, k: usize) -> L;
}

impl<S: Sweep<D>, const D: usize> Body<D> for S {
    #[inline(always)]
    unsafe fn run<L: Blocks, N: Node<L>, R: Rows<L, D>>(&self, node: &mut N, rows: &R) {
        let pre = self.pre::<L, _>(node);
        let mut acc = self.zero::<L>();
        let (mut k, count) = (0, rows.count());
        if rows.are_runs() {
            while k < count {
                rows.ahead(k);
                // SAFETY: k is below the count, and these are runs.
                let mut bond = unsafe { rows.run(k) };
                self.bond(&pre, &mut bond, &mut acc);
                k += 1;
            }
        } else {
            while k < count {
                rows.ahead(k);
                // SAFETY: k is below the count, and these are none.
                let mut bond = unsafe { rows.bond(k) };
                self.bond(&pre, &mut bond, &mut acc);
                k += 1;
            }
        }
        self.post(&pre, &acc, node);
    }
    #[inline(always)]
    fn streams(&self) -> usize {
        S::STREAMS
    }
    #[inline(always)]
    fn recorded(&self) -> usize {
        recorded(S::FORMED)
    }
    #[inline(always)]
    fn geo<L: Lane, B: Bond<L, D> + Streams<L>>(&self, bond: &B, k: usize) -> L {
        Sweep::geo(self, bond, k)
    }
}

/// Bits of the nodes of a lane: the bytes of its chunks, which lie `next` apart, or of one part of a chunk.
#[inline(always)]
unsafe fn bits<L: Lane>(first: *const u8, next: usize, part: usize) -> u16 {
    let (mut bits, mut k) = (0, 0);
    while k < L::W.div_ceil(CHUNK) {
        bits |= u16::from(unsafe { *first.add(k * next) }) << (k * CHUNK);
        k += 1;
    }
    bits >> (part * L::W)
}

/// The node slots at one position.
pub(crate) struct Nodes<'a, const MASKED: bool> {
    call: &'a Call,
    constants: *const f64,
    at: usize,
    occupied: u16,
}

impl<'a, const MASKED: bool> Nodes<'a, MASKED> {
    /// Those of one part of a chunk, of which slot `at` is the first.
    #[inline(always)]
    unsafe fn new<L: Lane>(call: &'a Call, chunk: usize, part: usize, at: usize) -> Self {
        unsafe {
            Nodes {
                call,
                constants: call.constants.add(*call.constants_at.add(chunk) as usize),
                at,
                occupied: bits::<L>(call.nodes.add(chunk), 1, part),
            }
        }
    }
}

impl<L: Memory, const MASKED: bool> Node<L> for Nodes<'_, MASKED> {
    #[inline(always)]
    fn constant(&self, k: usize) -> L {
        L::splat(unsafe { *self.constants.add(k) })
    }
    #[inline(always)]
    fn own(&self, k: usize) -> L {
        // What is stored on a part of the body begins where slot 0 would be.
        unsafe { L::load(self.call.own[k].wrapping_add(self.at)) }
    }
    /// Empty lanes are not written: they stay 0, or belong to another chunk.
    #[inline(always)]
    fn out(&mut self, k: usize, v: L) {
        unsafe {
            let to = self.call.out[k].wrapping_add(self.at);
            if MASKED {
                v.store_where(L::mask(self.occupied), to)
            } else {
                v.store(to)
            }
        }
    }
}

/// The masked half of a bond: what counts, and what breaks.
pub(crate) struct Row<'a, L: Memory, const MASKED: bool> {
    call: &'a Call,
    chunk: usize,
    row: usize,
    part: usize,
    /// From the row of a chunk to that of the next one, where lanes are those of two.
    next: usize,
    alive: L::Mask,
}

impl<'a, L: Memory, const MASKED: bool> Row<'a, L, MASKED> {
    #[inline(always)]
    unsafe fn new(call: &'a Call, chunk: usize, row: usize, part: usize, next: usize) -> Self {
        let alive = match MASKED {
            true => unsafe { bits::<L>(call.bits.add(row), next, part) },
            false => u16::MAX,
        };
        Row {
            call,
            chunk,
            row,
            part,
            next,
            alive: L::mask(alive),
        }
    }

    /// The rare half (which bonds may break here, and the store) stays behind the branch.
    #[inline(always)]
    fn kill(&mut self, m: L::Mask) {
        if !MASKED {
            return;
        }
        let dead = L::bits(L::and(self.alive, m));
        if dead != 0 {
            let shift = self.part * L::W;
            let (mut alive, mut k) = (0, 0);
            while k < L::W.div_ceil(CHUNK) {
                let row = self.row + k * self.next;
                unsafe {
                    let armed = *self.call.armed.add(row * self.call.armed_step);
                    let dead = ((dead >> (k * CHUNK)) as u8) << shift & armed;
                    let p = self.call.bits.add(row);
                    if dead != 0 {
                        *p &= !dead;
                        *self.call.broken.add(self.chunk + k) += dead.count_ones();
                    }
                    alive |= u16::from(*p >> shift) << (k * CHUNK);
                }
                k += 1;
            }
            self.alive = L::mask(alive);
        }
    }

    #[inline(always)]
    fn add(&self, acc: &mut L, a: L, b: L) {
        let sum = a.fma(b, *acc);
        *acc = if MASKED {
            L::select(self.alive, sum, *acc)
        } else {
            sum
        };
    }

    #[inline(always)]
    fn max(&self, acc: &mut L, a: L) {
        let larger = acc.max(a);
        *acc = if MASKED {
            L::select(self.alive, larger, *acc)
        } else {
            larger
        };
    }

    #[inline(always)]
    fn cell(&self) -> usize {
        self.row * CHUNK + self.part * L::W
    }

    #[inline(always)]
    fn history(&self, k: usize) -> L {
        unsafe { L::load(self.call.history[k].add(self.cell())) }
    }

    #[inline(always)]
    fn reverse(&self, k: usize) -> L {
        unsafe { L::gather(self.call.history[k], self.call.reverse.add(self.cell())) }
    }

    #[inline(always)]
    fn put_history(&mut self, k: usize, v: L) {
        let v = if MASKED {
            L::select(self.alive, v, self.history(k))
        } else {
            v
        };
        unsafe { v.store(self.call.next[k].add(self.cell())) }
    }
}

macro_rules! instances {
    ($($name:ident: $module:ident, $lane:ty;)*) => {$(
        /// One instance of a sweep; the caller enables its instruction set.
        ///
        /// # Safety
        /// As [`crate::kernel::Run`].
        #[doc(hidden)]
        #[inline(always)]
        pub unsafe fn $name<S: Sweep<D>, const D: usize, const MASKED: bool>(sweep: &S, call: &Call, from: usize, to: usize) {
            unsafe { $module::chunks::<$lane, S, D, MASKED>(sweep, call, from, to) }
        }
    )*};
}
instances! {
    lattice_scalar: lattice, f64;
    cloud_scalar: cloud, f64;
}
#[cfg(target_arch = "x86_64")]
instances! {
    lattice_avx2: lattice, crate::lane::Avx2;
    cloud_avx2: cloud, crate::lane::Avx2;
    lattice_single: lattice, crate::lane::Single;
    lattice_avx512: lattice, crate::lane::Avx512;
    cloud_avx512: cloud, crate::lane::Avx512;
}

/// One instance of a sweep, two chunks at a time.
///
/// # Safety
/// As [`crate::kernel::Run`].
#[cfg(target_arch = "x86_64")]
#[doc(hidden)]
#[inline(always)]
pub unsafe fn lattice_wide<S: Sweep<D>, const D: usize, const MASKED: bool>(
    sweep: &S,
    call: &Call,
    from: usize,
    to: usize,
) {
    unsafe {
        lattice::twos::<crate::lane::Wide, crate::lane::Single, S, D, MASKED>(sweep, call, from, to)
    }
}
