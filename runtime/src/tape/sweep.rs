//! A sweep that was not compiled: its bodies walk the tapes, inside the same traversals.
use super::Code;
use super::exec::{Leaves, Registers, run};
use super::pack::Leaf;
use crate::kernel::{Bond, Lane, Node, Sweep};

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

struct AtBond<'a, L: Lane, B> {
    bond: &'a mut B,
    pre: &'a [L; MAX_VALUES],
    acc: &'a mut [L; MAX_VALUES],
}

/// `Leaves` with the dimension that the trait of a bond carries.
struct InSpace<const D: usize, T>(T);

impl<L: Lane, const D: usize, B: Bond<L, D>> Leaves<L> for InSpace<D, AtBond<'_, L, B>> {
    #[inline(always)]
    fn leaf(&mut self, leaf: Leaf, k: usize) -> L {
        let b = &self.0;
        match leaf {
            Leaf::Pre => b.pre[k],
            Leaf::Geo => b.bond.geo(k),
            Leaf::Nbr => b.bond.nbr(k),
            Leaf::Xi => b.bond.xi(k),
            Leaf::Eta => b.bond.eta(k),
            Leaf::Ix => b.bond.ix(),
            Leaf::History => b.bond.history(k),
            Leaf::Reverse => b.bond.reverse(k),
            _ => L::splat(0.0),
        }
    }
    #[inline(always)]
    fn kill(&mut self, m: L::Mask) {
        self.0.bond.kill(m);
    }
    #[inline(always)]
    fn add(&mut self, k: usize, a: L, b: L) {
        self.0.bond.add(&mut self.0.acc[k], a, b);
    }
    #[inline(always)]
    fn max(&mut self, k: usize, a: L) {
        self.0.bond.max(&mut self.0.acc[k], a);
    }
    #[inline(always)]
    fn put_history(&mut self, k: usize, v: L) {
        self.0.bond.put_history(k, v);
    }
}

impl<const D: usize> Sweep<D> for TapeSweep {
    type Pre<L: Lane> = [L; MAX_VALUES];
    type Acc<L: Lane> = [L; MAX_VALUES];

    #[inline(always)]
    fn zero<L: Lane>(&self) -> [L; MAX_VALUES] {
        let mut acc = [L::splat(0.0); MAX_VALUES];
        let mut left = self.extremes;
        while left != 0 {
            acc[left.trailing_zeros() as usize] = L::splat(f64::NEG_INFINITY);
            left &= left - 1;
        }
        acc
    }

    #[inline(always)]
    fn pre<L: Lane, N: Node<L>>(&self, node: &N) -> [L; MAX_VALUES] {
        let mut out = [L::splat(0.0); MAX_VALUES];
        let mut r = Registers::new();
        run(
            &self.pre,
            &mut r,
            &mut AtNode {
                node,
                pre: &out,
                acc: &out,
            },
        );
        for (to, &from) in out.iter_mut().zip(&self.pre.outs) {
            *to = r.number(from);
        }
        out
    }

    #[inline(always)]
    fn bond<L: Lane, B: Bond<L, D>>(
        &self,
        pre: &[L; MAX_VALUES],
        bond: &mut B,
        acc: &mut [L; MAX_VALUES],
    ) {
        let mut r = Registers::new();
        run(
            &self.bond,
            &mut r,
            &mut InSpace::<D, _>(AtBond { bond, pre, acc }),
        );
    }

    #[inline(always)]
    fn post<L: Lane, N: Node<L>>(
        &self,
        pre: &[L; MAX_VALUES],
        acc: &[L; MAX_VALUES],
        node: &mut N,
    ) {
        let mut r = Registers::new();
        run(
            &self.post,
            &mut r,
            &mut AtNode {
                node: &*node,
                pre,
                acc,
            },
        );
        for (k, &from) in self.post.outs.iter().enumerate() {
            node.out(k, r.number(from));
        }
    }
}
