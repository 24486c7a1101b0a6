//! A sweep that was not compiled: its bodies walk the tapes, inside the same traversals.
use super::Code;
use super::block::{AT_ONCE, Blocks, Columns, File, rows};
use super::exec::{Leaves, Registers, run};
use super::pack::{Filled, Leaf, Step};
use crate::kernel::{Bond, Lane, Node, Streams};
use crate::traverse::{Body, Rows};

/// Most prologue values, and most accumulators, of an interpreted sweep.
pub(crate) const MAX_VALUES: usize = 48;

/// The three tapes of a sweep.
#[derive(Clone, Debug, Default)]
pub struct TapeSweep {
    pub(crate) pre: Code,
    pub(crate) bond: Code,
    pub(crate) post: Code,
    /// One bit per accumulator that holds an extreme, which starts at minus infinity.
    pub(crate) extremes: u64,
    /// Streams in a cloud, which are then what the bond tape reads as reference-bond values.
    pub(crate) streams: usize,
}

struct AtNode<'a, L: Lane, N> {
    node: &'a N,
    pre: &'a [L; MAX_VALUES],
    acc: &'a [L; MAX_VALUES],
}

impl<L: Lane, N: Node<L>> Leaves<L> for AtNode<'_, L, N> {
    #[inline(always)]
    fn leaf(&mut self, leaf: Leaf, k: usize) -> L {
        match leaf {
            Leaf::Own => self.node.own(k),
            Leaf::Const => self.node.constant(k),
            Leaf::Pre => self.pre[k],
            Leaf::Acc => self.acc[k],
            _ => L::splat(0.0),
        }
    }
}

impl<const D: usize> Body<D> for TapeSweep {
    #[inline(always)]
    unsafe fn run<L: Blocks, N: Node<L>, R: Rows<L, D>>(&self, node: &mut N, rows: &R) {
        let pre = self.prologue(node);
        let mut acc = self.zeros();
        // SAFETY: as of this function.
        unsafe { self.bonds(&pre, rows, &mut acc) };
        self.epilogue(&pre, &acc, node);
    }
    #[inline(always)]
    fn streams(&self) -> usize {
        self.streams
    }
    #[inline(always)]
    fn recorded(&self) -> usize {
        0
    }
    #[inline(always)]
    fn geo<L: Lane, B: Bond<L, D> + Streams<L>>(&self, bond: &B, k: usize) -> L {
        bond.stream(k)
    }
}

impl TapeSweep {
    /// What sums begin with.
    #[inline(always)]
    pub(crate) fn zeros<L: Lane>(&self) -> [L; MAX_VALUES] {
        let mut acc = [L::splat(0.0); MAX_VALUES];
        let mut left = self.extremes;
        while left != 0 {
            acc[left.trailing_zeros() as usize] = L::splat(f64::NEG_INFINITY);
            left &= left - 1;
        }
        acc
    }

    #[inline(always)]
    pub(crate) fn prologue<L: Lane, N: Node<L>>(&self, node: &N) -> [L; MAX_VALUES] {
        let none = [L::splat(0.0); MAX_VALUES];
        let mut pre = none;
        let mut r = Registers::new();
        let mut at = AtNode {
            node,
            pre: &none,
            acc: &none,
        };
        run(&self.pre, &mut r, &mut at);
        for (to, &from) in pre.iter_mut().zip(&self.pre.outs) {
            *to = r.number(from);
        }
        pre
    }

    #[inline(always)]
    pub(crate) fn epilogue<L: Lane, N: Node<L>>(
        &self,
        pre: &[L; MAX_VALUES],
        acc: &[L; MAX_VALUES],
        node: &mut N,
    ) {
        let mut r = Registers::new();
        let mut at = AtNode {
            node: &*node,
            pre,
            acc,
        };
        run(&self.post, &mut r, &mut at);
        for (k, &from) in self.post.outs.iter().enumerate() {
            node.out(k, r.number(from));
        }
    }

    /// Runs the bond tape over all rows, block after block.
    #[inline(always)]
    unsafe fn bonds<L: Blocks, R: Rows<L, D>, const D: usize>(
        &self,
        pre: &[L; MAX_VALUES],
        bonds: &R,
        acc: &mut [L; MAX_VALUES],
    ) {
        let most = rows::<L>(self.bond.registers);
        let mut file = File::<L>::new();
        let columns = file.columns(most);
        let width = most.min(bonds.count().next_multiple_of(AT_ONCE));
        for step in &self.bond.filled.same {
            let (d, v) = match *step {
                Step::Lit(d, v) => (d, L::splat(v)),
                Step::Leaf(d, _, k) => (d, pre[k as usize]),
                _ => continue,
            };
            let mut k = 0;
            while k < width {
                // SAFETY: columns have `most` rows, of which there are `width` at most.
                unsafe { columns.number(d).add(k).write(v) };
                k += 1;
            }
        }
        let mut first = 0;
        while first < bonds.count() {
            let block = Block {
                bonds,
                first,
                count: most.min(bonds.count() - first),
            };
            // SAFETY: as of this function; the columns hold what is the same for all bonds.
            unsafe { block.run(&self.bond, columns, acc) };
            first += most;
        }
    }
}

/// Does something with the bonds of a row, be it a run or not.
macro_rules! at_row {
    ($rows:expr, $k:expr, |$bond:ident| $do:expr) => {
        if $rows.are_runs() {
            #[allow(unused_mut)]
            let mut $bond = $rows.run($k);
            $do
        } else {
            #[allow(unused_mut)]
            let mut $bond = $rows.bond($k);
            $do
        }
    };
}

/// Some of the bonds of the nodes at hand.
struct Block<'a, R> {
    bonds: &'a R,
    first: usize,
    count: usize,
}

impl<R> Block<'_, R> {
    /// The row of the traversal. Those behind the last one, up to a multiple of [`AT_ONCE`], repeat it: they are
    /// computed and not used.
    #[inline(always)]
    fn row(&self, k: usize) -> usize {
        self.first + if k < self.count { k } else { self.count - 1 }
    }

    #[inline(always)]
    unsafe fn run<L: Blocks, const D: usize>(
        &self,
        code: &Code,
        columns: Columns<L>,
        acc: &mut [L; MAX_VALUES],
    ) where
        R: Rows<L, D>,
    {
        let rows = self.count.next_multiple_of(AT_ONCE);
        unsafe {
            self.fill(code, columns, rows);
            let mut steps = &code.steps[..];
            loop {
                steps = &steps[L::arithmetic(steps, columns, rows)..];
                let Some((step, rest)) = steps.split_first() else {
                    return;
                };
                match *step {
                    Step::Leaf(d, leaf, k) => self.load(leaf, k as usize, columns.number(d), rows),
                    _ => self.effect(step, columns, acc),
                }
                steps = rest;
            }
        }
    }

    /// Fills the registers of bond vectors.
    #[inline(always)]
    unsafe fn fill<L: Blocks, const D: usize>(&self, code: &Code, columns: Columns<L>, rows: usize)
    where
        R: Rows<L, D>,
    {
        let f = &code.filled;
        if f.xi.is_none() && f.eta.is_none() && f.y.is_none() && f.ix.is_none() {
            return;
        }
        let mut k = 0;
        while k < rows {
            unsafe {
                self.bonds.ahead(self.row(k));
                at_row!(self.bonds, self.row(k), |bond| fill(f, &bond, columns, k));
            }
            k += 1;
        }
    }

    #[inline(always)]
    unsafe fn load<L: Blocks, const D: usize>(&self, leaf: Leaf, k: usize, to: *mut L, rows: usize)
    where
        R: Rows<L, D>,
    {
        macro_rules! each {
            ($value:ident) => {{
                let mut row = 0;
                while row < rows {
                    unsafe {
                        at_row!(self.bonds, self.row(row), |bond| to
                            .add(row)
                            .write(bond.$value(k)))
                    };
                    row += 1;
                }
            }};
        }
        match leaf {
            Leaf::Geo => each!(geo),
            Leaf::Nbr => each!(nbr),
            Leaf::History => each!(history),
            Leaf::Reverse => each!(reverse),
            _ => {}
        }
    }

    #[inline(always)]
    unsafe fn effect<L: Blocks, const D: usize>(
        &self,
        step: &Step,
        columns: Columns<L>,
        acc: &mut [L; MAX_VALUES],
    ) where
        R: Rows<L, D>,
    {
        macro_rules! each {
            (|$bond:ident, $k:ident| $do:expr) => {{
                let mut $k = 0;
                while $k < self.count {
                    unsafe { at_row!(self.bonds, self.first + $k, |$bond| $do) };
                    $k += 1;
                }
            }};
        }
        match *step {
            Step::AddTo(sum, a, b) => {
                let (a, b, mut s) = (columns.number(a), columns.number(b), acc[sum as usize]);
                each!(|bond, k| bond.add(&mut s, *a.add(k), *b.add(k)));
                acc[sum as usize] = s;
            }
            Step::MaxTo(sum, a) => {
                let (a, mut s) = (columns.number(a), acc[sum as usize]);
                each!(|bond, k| bond.max(&mut s, *a.add(k)));
                acc[sum as usize] = s;
            }
            Step::Kill(m) => {
                let m = columns.truth(m);
                each!(|bond, k| bond.kill(*m.add(k)));
            }
            Step::PutHistory(h, a) => {
                let a = columns.number(a);
                each!(|bond, k| bond.put_history(h as usize, *a.add(k)));
            }
            _ => {}
        }
    }
}

/// The registers of bond vectors in row `k` of the columns.
#[inline(always)]
unsafe fn fill<L: Blocks, B: Bond<L, D>, const D: usize>(
    f: &Filled,
    bond: &B,
    columns: Columns<L>,
    k: usize,
) {
    let mut a = 0;
    while a < D {
        let to = |r: [u8; 3]| unsafe { columns.number(r[a]).add(k) };
        unsafe {
            if let Some(r) = f.y {
                to(r).write(bond.xi(a).add(bond.eta(a)));
            }
            if let Some(r) = f.xi {
                to(r).write(bond.xi(a));
            }
            if let Some(r) = f.eta {
                to(r).write(bond.eta(a));
            }
        }
        a += 1;
    }
    if let Some(r) = f.ix {
        unsafe { columns.number(r).add(k).write(bond.ix()) };
    }
}
