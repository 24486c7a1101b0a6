//! Cloud traversal: neighbour lists in SELL-8, nodes in lanes.
use super::{Body, CHUNK, Call, Nodes, RECORD, Row, Rows, Stream};
use crate::kernel::{Bond, Streams, norm_squared};
use crate::lane::{Record, Records};
use crate::tape::Blocks;

/// Rows ahead at which indices and streams are fetched.
const AHEAD: usize = 24;

/// One bond of each node of one part of a chunk.
struct Column<'a, L: Records, S, const D: usize, const MASKED: bool, const RUN: bool> {
    row: Row<'a, L, MASKED>,
    sweep: &'a S,
    streams: &'a [Stream],
    nbr: &'a [*const f64],
    nbr_records: &'a [*const Record],
    /// Slots of the other ends, of which the first is `at` in a run.
    index: *const u32,
    at: usize,
    xi: [L; D],
    eta: [L; D],
}

impl<L: Records, S, const D: usize, const MASKED: bool, const RUN: bool> Streams<L>
    for Column<'_, L, S, D, MASKED, RUN>
{
    #[inline(always)]
    fn stream(&self, k: usize) -> L {
        unsafe { L::load(self.streams[k].at(self.row.row).add(self.row.part * L::W)) }
    }
}

impl<L: Records, S: Body<D>, const D: usize, const MASKED: bool, const RUN: bool> Bond<L, D>
    for Column<'_, L, S, D, MASKED, RUN>
{
    #[inline(always)]
    fn xi(&self, a: usize) -> L {
        self.xi[a]
    }
    #[inline(always)]
    fn eta(&self, a: usize) -> L {
        self.eta[a]
    }
    #[inline(always)]
    fn ix(&self) -> L {
        norm_squared(self.xi).rsqrt()
    }
    #[inline(always)]
    fn geo(&self, k: usize) -> L {
        self.sweep.geo(self, k)
    }
    #[inline(always)]
    fn nbr(&self, k: usize) -> L {
        unsafe {
            if RUN {
                L::load(self.nbr[k].add(self.at))
            } else if k < self.sweep.recorded() {
                // What is read of one record is loaded once: nothing is stored in between.
                L::gather_records(self.nbr_records[k / RECORD], self.index)[k % RECORD]
            } else {
                L::gather(self.nbr[k], self.index)
            }
        }
    }
    #[inline(always)]
    fn history(&self, k: usize) -> L {
        self.row.history(k)
    }
    #[inline(always)]
    fn reverse(&self, k: usize) -> L {
        self.row.reverse(k)
    }
    #[inline(always)]
    fn put_history(&mut self, k: usize, v: L) {
        self.row.put_history(k, v)
    }
    #[inline(always)]
    fn kill(&mut self, m: L::Mask) {
        self.row.kill(m)
    }
    #[inline(always)]
    fn add(&self, acc: &mut L, a: L, b: L) {
        self.row.add(acc, a, b)
    }
    #[inline(always)]
    fn max(&self, acc: &mut L, a: L) {
        self.row.max(acc, a)
    }
}

/// Components of the records at the places of an index row.
#[inline(always)]
unsafe fn at_places<L: Records, const D: usize>(
    records: *const Record,
    index: *const u32,
) -> [L; D] {
    let all = unsafe { L::gather_records(records, index) };
    let mut v = [L::splat(0.0); D];
    let mut a = 0;
    while a < D {
        v[a] = all[a];
        a += 1;
    }
    v
}

/// Differences to the other ends.
#[inline(always)]
unsafe fn across<L: Records, const D: usize>(
    records: *const Record,
    index: *const u32,
    own: &[L; D],
) -> [L; D] {
    let mut v: [L; D] = unsafe { at_places(records, index) };
    let mut a = 0;
    while a < D {
        v[a] = v[a].sub(own[a]);
        a += 1;
    }
    v
}

/// Components at nodes side by side.
#[inline(always)]
unsafe fn side_by_side<L: Records, const D: usize>(from: &[*const f64; 3], at: usize) -> [L; D] {
    let mut v = [L::splat(0.0); D];
    let mut a = 0;
    while a < D {
        v[a] = unsafe { L::load(from[a].add(at)) };
        a += 1;
    }
    v
}

/// Differences to the other ends where these lie side by side.
#[inline(always)]
unsafe fn along<L: Records, const D: usize>(
    from: &[*const f64; 3],
    at: usize,
    own: &[L; D],
) -> [L; D] {
    let mut v: [L; D] = unsafe { side_by_side(from, at) };
    let mut a = 0;
    while a < D {
        v[a] = v[a].sub(own[a]);
        a += 1;
    }
    v
}

/// The columns of one part of a chunk.
struct Columns<'a, L: Records, S, const D: usize, const MASKED: bool> {
    call: &'a Call,
    sweep: &'a S,
    nbr: &'a [*const f64],
    nbr_records: &'a [*const Record],
    streams: &'a [Stream],
    chunk: usize,
    part: usize,
    u_records: *const Record,
    x_records: *const Record,
    u: &'a [*const f64; 3],
    x: &'a [*const f64; 3],
    /// Displacements and positions of the nodes.
    ui: [L; D],
    xi: [L; D],
    /// The first row.
    row: usize,
    /// Slots of the other ends: eight of each row, or the first.
    index: *const u32,
    runs: bool,
    count: usize,
}

impl<L: Records, S, const D: usize, const MASKED: bool> Columns<'_, L, S, D, MASKED> {
    #[inline(always)]
    unsafe fn column<const RUN: bool>(&self, k: usize) -> Column<'_, L, S, D, MASKED, RUN> {
        unsafe {
            let row = Row::<L, MASKED>::new(self.call, self.chunk, self.row + k, self.part, 0);
            let (index, at, xi, eta);
            if RUN {
                index = self.index;
                at = *index.add(k) as usize + self.part * L::W;
                (xi, eta) = (along(self.x, at, &self.xi), along(self.u, at, &self.ui));
            } else {
                let (x, u) = (self.x_records, self.u_records);
                index = self.index.add(k * CHUNK + self.part * L::W);
                at = 0;
                (xi, eta) = (across(x, index, &self.xi), across(u, index, &self.ui));
            }
            Column {
                sweep: self.sweep,
                streams: self.streams,
                nbr: self.nbr,
                nbr_records: self.nbr_records,
                index,
                at,
                xi,
                eta,
                row,
            }
        }
    }
}

impl<L: Records, S: Body<D>, const D: usize, const MASKED: bool> Rows<L, D>
    for Columns<'_, L, S, D, MASKED>
{
    type Bond<'a>
        = Column<'a, L, S, D, MASKED, false>
    where
        Self: 'a;
    type Run<'a>
        = Column<'a, L, S, D, MASKED, true>
    where
        Self: 'a;
    #[inline(always)]
    fn count(&self) -> usize {
        self.count
    }
    #[inline(always)]
    unsafe fn bond(&self, k: usize) -> Self::Bond<'_> {
        unsafe { self.column(k) }
    }
    #[inline(always)]
    fn are_runs(&self) -> bool {
        self.runs
    }
    #[inline(always)]
    unsafe fn run(&self, k: usize) -> Self::Run<'_> {
        unsafe { self.column(k) }
    }
    #[inline(always)]
    fn ahead(&self, k: usize) {
        if !self.runs {
            L::prefetch(self.index.wrapping_add((k + AHEAD) * CHUNK).cast());
        }
        let mut s = 0;
        while s < self.sweep.streams() {
            L::prefetch(self.streams[s].source(self.row + k + AHEAD));
            s += 1;
        }
    }
}

/// Runs a sweep on the chunks `from..to`.
#[inline(always)]
pub(super) unsafe fn chunks<L: Blocks + Records, S: Body<D>, const D: usize, const MASKED: bool>(
    sweep: &S,
    call: &Call,
    from: usize,
    to: usize,
) {
    let (u_records, x_records) = (call.u_records, call.x_records);
    let (u, x, nbr, nbr_records) = (call.u, call.x, call.nbr, call.nbr_records);
    let streams = call.streams;
    let mut chunk = from;
    while chunk < to {
        unsafe {
            let base = *call.base.add(chunk) as usize;
            let (first, last) = (
                *call.first.add(chunk) as usize,
                *call.last.add(chunk) as usize,
            );
            let at = |chunk| *call.index_at.add(chunk) as usize;
            let (index, runs) = (
                call.index.add(at(chunk)),
                at(chunk + 1) - at(chunk) == last - first,
            );
            let mut part = 0;
            while part < CHUNK / L::W {
                let at = base + part * L::W;
                let mut nodes = Nodes::<MASKED>::new::<L>(call, chunk, part, at);
                let columns = Columns::<L, S, D, MASKED> {
                    call,
                    sweep,
                    nbr: &nbr,
                    nbr_records: &nbr_records,
                    streams: &streams,
                    chunk,
                    part,
                    u_records,
                    x_records,
                    u: &u,
                    x: &x,
                    ui: side_by_side(&u, at),
                    xi: side_by_side(&x, at),
                    row: first,
                    index,
                    runs,
                    count: last - first,
                };
                sweep.run(&mut nodes, &columns);
                part += 1;
            }
        }
        chunk += 1;
    }
}
