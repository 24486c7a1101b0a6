//! Lattice traversal: the family is a stencil, every load is contiguous.
use super::{Body, CHUNK, Call, Nodes, Row, Rows};
use crate::kernel::Bond;
use crate::lane::Memory;
use crate::tape::Blocks;

/// Bonds of one kind seen from the nodes of one part of a chunk.
struct Entry<'a, L: Memory, const D: usize, const MASKED: bool> {
    row: Row<'a, L, MASKED>,
    record: *const f64,
    nbr: &'a [*const f64],
    /// Slot of the other end of lane 0.
    other: usize,
    eta: [L; D],
}

impl<L: Memory, const D: usize, const MASKED: bool> Bond<L, D> for Entry<'_, L, D, MASKED> {
    #[inline(always)]
    fn xi(&self, a: usize) -> L {
        L::splat(unsafe { *self.record.add(1 + a) })
    }
    #[inline(always)]
    fn eta(&self, a: usize) -> L {
        self.eta[a]
    }
    #[inline(always)]
    fn ix(&self) -> L {
        L::splat(unsafe { *self.record.add(1 + D) })
    }
    #[inline(always)]
    fn geo(&self, k: usize) -> L {
        L::splat(unsafe { *self.record.add(2 + D + k) })
    }
    #[inline(always)]
    fn nbr(&self, k: usize) -> L {
        unsafe { L::load(self.nbr[k].add(self.other)) }
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

/// Loads one value per direction.
#[inline(always)]
unsafe fn load<L: Memory, const D: usize>(from: &[*const f64; 3], at: usize) -> [L; D] {
    let mut v = [L::splat(0.0); D];
    let mut a = 0;
    while a < D {
        v[a] = unsafe { L::load(from[a].add(at)) };
        a += 1;
    }
    v
}

/// The rows of one part of a chunk.
struct Entries<'a, L: Memory, const D: usize, const MASKED: bool> {
    call: &'a Call,
    u: &'a [*const f64; 3],
    nbr: &'a [*const f64],
    chunk: usize,
    part: usize,
    /// Slot of lane 0, and the displacements there.
    at: usize,
    ui: [L; D],
    /// The first row, and what the rows have.
    row: usize,
    records: *const *const f64,
    count: usize,
}

impl<L: Memory, const D: usize, const MASKED: bool> Rows<L, D> for Entries<'_, L, D, MASKED> {
    type Bond<'a>
        = Entry<'a, L, D, MASKED>
    where
        Self: 'a;
    #[inline(always)]
    fn count(&self) -> usize {
        self.count
    }
    #[inline(always)]
    unsafe fn bond(&self, k: usize) -> Entry<'_, L, D, MASKED> {
        unsafe {
            let record = *self.records.add(k);
            let other = self.at.wrapping_add_signed(*record.cast::<i64>() as isize);
            let mut eta: [L; D] = load(self.u, other);
            let mut a = 0;
            while a < D {
                eta[a] = eta[a].sub(self.ui[a]);
                a += 1;
            }
            Entry {
                row: Row::new(self.call, self.chunk, self.row + k, self.part),
                record,
                nbr: self.nbr,
                other,
                eta,
            }
        }
    }
}

/// Runs a sweep on the chunks `from..to`.
#[inline(always)]
pub(super) unsafe fn chunks<L: Blocks, S: Body<D>, const D: usize, const MASKED: bool>(
    sweep: &S,
    call: &Call,
    from: usize,
    to: usize,
) {
    let (u, nbr) = (call.u, call.nbr);
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
                let mut nodes = Nodes::<MASKED>::new(call, chunk, part * L::W, at);
                let entries = Entries::<L, D, MASKED> {
                    call,
                    u: &u,
                    nbr: &nbr,
                    chunk,
                    part,
                    at,
                    ui: load(&u, at),
                    row: first,
                    records: call.records.add(*call.pattern.add(chunk) as usize),
                    count: last - first,
                };
                sweep.run(&mut nodes, &entries);
                part += 1;
            }
        }
        chunk += 1;
    }
}
