//! Cloud traversal: neighbour lists in SELL-8, nodes in lanes.
use super::{Body, CHUNK, Call, Nodes, RECORD, Row, Rows, Stream};
use crate::kernel::{Bond, Streams, norm_squared};
use crate::lane::{Record, Records};
use crate::tape::Blocks;

/// Rows ahead at which indices and streams are fetched.
const AHEAD: usize = 24;

/// One bond of each node of one part of a chunk.
struct Column<'a, L: Records, S, const D: usize, const MASKED: bool> {
    row: Row<'a, L, MASKED>,
    sweep: &'a S,
    streams: &'a [Stream],
    nbr: &'a [*const f64],
    nbr_records: &'a [*const Record],
    index: *const u32,
    xi: [L; D],
    eta: [L; D],
}

impl<L: Records, S, const D: usize, const MASKED: bool> Streams<L> for Column<'_, L, S, D, MASKED> {
    #[inline(always)]
    fn stream(&self, k: usize) -> L {
        unsafe { L::load(self.streams[k].at(self.row.cell())) }
    }
}

impl<L: Records, S: Body<D>, const D: usize, const MASKED: bool> Bond<L, D>
    for Column<'_, L, S, D, MASKED>
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
            if k < self.sweep.recorded() {
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

/// The columns of one part of a chunk.
struct Columns<'a, L: Records, S, const D: usize, const MASKED: bool> {
    call: &'a Call,
    sweep: &'a S,
    nbr: &'a [*const f64],
    nbr_records: &'a [*const Record],
    streams: &'a [Stream],
    chunk: usize,
    part: usize,
    u: *const Record,
    x: *const Record,
    /// Displacements and positions of the nodes.
    ui: [L; D],
    xi: [L; D],
    /// The first row.
    row: usize,
    count: usize,
}

impl<L: Records, S: Body<D>, const D: usize, const MASKED: bool> Rows<L, D>
    for Columns<'_, L, S, D, MASKED>
{
    type Bond<'a>
        = Column<'a, L, S, D, MASKED>
    where
        Self: 'a;
    #[inline(always)]
    fn count(&self) -> usize {
        self.count
    }
    #[inline(always)]
    unsafe fn bond(&self, k: usize) -> Column<'_, L, S, D, MASKED> {
        unsafe {
            let row = Row::<L, MASKED>::new(self.call, self.chunk, self.row + k, self.part, 0);
            let index = self.call.index.add(row.cell());
            Column {
                sweep: self.sweep,
                streams: self.streams,
                nbr: self.nbr,
                nbr_records: self.nbr_records,
                index,
                xi: across(self.x, index, &self.xi),
                eta: across(self.u, index, &self.ui),
                row,
            }
        }
    }
    #[inline(always)]
    fn ahead(&self, k: usize) {
        let cell = (self.row + k) * CHUNK + self.part * L::W;
        L::prefetch(self.call.index.wrapping_add(cell + AHEAD * CHUNK).cast());
        let mut s = 0;
        while s < self.sweep.streams() {
            L::prefetch(self.streams[s].source(cell + AHEAD * CHUNK));
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
    let (u, x, nbr, streams) = (call.u_records, call.x_records, call.nbr, call.streams);
    let nbr_records = call.nbr_records;
    let mut chunk = from;
    while chunk < to {
        unsafe {
            let base = *call.base.add(chunk) as usize;
            let (first, last) = (
                *call.first.add(chunk) as usize,
                *call.last.add(chunk) as usize,
            );
            let mut part = 0;
            while part < CHUNK / L::W {
                let at = base + part * L::W;
                let mut here = [0u32; CHUNK];
                let mut k = 0;
                while k < CHUNK {
                    here[k] = (at + k) as u32;
                    k += 1;
                }
                let mut nodes = Nodes::<MASKED>::new::<L>(call, chunk, part, at);
                let columns = Columns::<L, S, D, MASKED> {
                    call,
                    sweep,
                    nbr: &nbr,
                    nbr_records: &nbr_records,
                    streams: &streams,
                    chunk,
                    part,
                    u,
                    x,
                    ui: at_places(u, here.as_ptr()),
                    xi: at_places(x, here.as_ptr()),
                    row: first,
                    count: last - first,
                };
                sweep.run(&mut nodes, &columns);
                part += 1;
            }
        }
        chunk += 1;
    }
}
