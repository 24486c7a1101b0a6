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

impl<L: Memory, const D: usize, const MASKED: bool> Entry<'_, L, D, MASKED> {
    /// Number `k` of the record.
    #[inline(always)]
    fn value(&self, k: usize) -> L {
        L::spread(unsafe { *self.record.add(1).cast::<L::Near>().add(k) })
    }
}

impl<L: Memory, const D: usize, const MASKED: bool> Bond<L, D> for Entry<'_, L, D, MASKED> {
    #[inline(always)]
    fn xi(&self, a: usize) -> L {
        self.value(a)
    }
    #[inline(always)]
    fn eta(&self, a: usize) -> L {
        self.eta[a]
    }
    #[inline(always)]
    fn ix(&self) -> L {
        self.value(D)
    }
    #[inline(always)]
    fn geo(&self, k: usize) -> L {
        self.value(1 + D + k)
    }
    #[inline(always)]
    fn nbr(&self, k: usize) -> L {
        unsafe { near(self.nbr[k], self.other) }
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

#[inline(always)]
unsafe fn near<L: Memory>(from: *const f64, at: usize) -> L {
    unsafe { L::near(from.cast::<L::Near>().add(at)) }
}

/// Loads one value per direction.
#[inline(always)]
unsafe fn load<L: Memory, const D: usize>(from: &[*const f64; 3], at: usize) -> [L; D] {
    let mut v = [L::splat(0.0); D];
    let mut a = 0;
    while a < D {
        v[a] = unsafe { near(from[a], at) };
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
    type Run<'a>
        = Entry<'a, L, D, MASKED>
    where
        Self: 'a;
    /// Every row could be one, and there is one way to read it.
    #[inline(always)]
    fn are_runs(&self) -> bool {
        false
    }
    #[inline(always)]
    unsafe fn run(&self, k: usize) -> Self::Run<'_> {
        unsafe { self.bond(k) }
    }
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
                row: Row::new(self.call, self.chunk, self.row + k, self.part, self.count),
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
        let mut part = 0;
        while part < CHUNK / L::W {
            unsafe { at::<L, S, D, MASKED>(sweep, call, &u, &nbr, chunk, part) };
            part += 1;
        }
        chunk += 1;
    }
}

/// The same with lanes for two chunks where these lie side by side and have the same rows, with lanes for one elsewhere.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) unsafe fn twos<W: Blocks, L: Blocks, S: Body<D>, const D: usize, const MASKED: bool>(
    sweep: &S,
    call: &Call,
    from: usize,
    to: usize,
) {
    let (u, nbr) = (call.u, call.nbr);
    let mut chunk = from;
    while chunk < to {
        unsafe {
            let same = |list: *const u32| *list.add(chunk) == *list.add(chunk + 1);
            let rows = |chunk| *call.last.add(chunk) - *call.first.add(chunk);
            if chunk + 1 < to
                && *call.base.add(chunk) + CHUNK as u32 == *call.base.add(chunk + 1)
                && same(call.pattern)
                && same(call.constants_at)
                && rows(chunk) == rows(chunk + 1)
                && *call.first.add(chunk) + rows(chunk) == *call.first.add(chunk + 1)
            {
                at::<W, S, D, MASKED>(sweep, call, &u, &nbr, chunk, 0);
                chunk += 2;
            } else {
                at::<L, S, D, MASKED>(sweep, call, &u, &nbr, chunk, 0);
                chunk += 1;
            }
        }
    }
}

/// One part of a chunk.
#[inline(always)]
unsafe fn at<L: Blocks, S: Body<D>, const D: usize, const MASKED: bool>(
    sweep: &S,
    call: &Call,
    u: &[*const f64; 3],
    nbr: &[*const f64],
    chunk: usize,
    part: usize,
) {
    unsafe {
        let at = *call.base.add(chunk) as usize + part * L::W;
        let first = *call.first.add(chunk) as usize;
        let last = *call.last.add(chunk) as usize;
        let mut nodes = Nodes::<MASKED>::new::<L>(call, chunk, part, at);
        let entries = Entries::<L, D, MASKED> {
            call,
            u,
            nbr,
            chunk,
            part,
            at,
            ui: load(u, at),
            row: first,
            records: call.records.add(*call.pattern.add(chunk) as usize),
            count: last - first,
        };
        sweep.run(&mut nodes, &entries);
    }
}
