//! Running packed code over a lane type, one node at a time.
use super::Code;
use super::pack::{Leaf, One, Step, Two};
use crate::kernel::Lane;
use std::mem::MaybeUninit;

/// What a tape reads in its place.
pub(crate) trait Leaves<L: Lane> {
    fn leaf(&mut self, leaf: Leaf, k: usize) -> L;
}

/// Registers, as many as a byte can name, so that no access needs a bounds check. Left uninitialised: packed
/// code writes a register before it reads it.
pub(crate) struct Registers<L: Lane> {
    numbers: [MaybeUninit<L>; 256],
    truths: [MaybeUninit<L::Mask>; 256],
}

impl<L: Lane> Registers<L> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Registers {
            numbers: [const { MaybeUninit::uninit() }; 256],
            truths: [const { MaybeUninit::uninit() }; 256],
        }
    }
    #[inline(always)]
    pub(crate) fn number(&self, r: u8) -> L {
        // SAFETY: `Code::new` gives out registers in definition order.
        unsafe { self.numbers[r as usize].assume_init() }
    }
    #[inline(always)]
    fn truth(&self, r: u8) -> L::Mask {
        // SAFETY: as for numbers.
        unsafe { self.truths[r as usize].assume_init() }
    }
    #[inline(always)]
    fn put(&mut self, r: u8, v: L) {
        self.numbers[r as usize] = MaybeUninit::new(v);
    }
    #[inline(always)]
    fn put_truth(&mut self, r: u8, v: L::Mask) {
        self.truths[r as usize] = MaybeUninit::new(v);
    }
}

/// Runs `code`; its outputs stay in the registers.
#[inline(always)]
pub(crate) fn run<L: Lane, V: Leaves<L>>(code: &Code, r: &mut Registers<L>, v: &mut V) {
    for step in &code.steps {
        match *step {
            Step::Lit(d, x) => r.put(d, L::splat(x)),
            Step::Leaf(d, leaf, k) => r.put(d, v.leaf(leaf, k as usize)),
            Step::One(d, f, a) => r.put(d, one(f, r.number(a))),
            Step::Two(d, f, a, b) => r.put(d, two(f, r.number(a), r.number(b))),
            Step::Fma(d, a, b, c) => r.put(d, r.number(a).fma(r.number(b), r.number(c))),
            Step::Powi(d, a, n) => r.put(d, r.number(a).powi(n)),
            Step::Select(d, m, a, b) => r.put(d, L::select(r.truth(m), r.number(a), r.number(b))),
            Step::Lt(d, a, b) => r.put_truth(d, r.number(a).lt(r.number(b))),
            Step::Le(d, a, b) => r.put_truth(d, r.number(a).le(r.number(b))),
            Step::And(d, a, b) => r.put_truth(d, L::and(r.truth(a), r.truth(b))),
            Step::Or(d, a, b) => r.put_truth(d, L::or(r.truth(a), r.truth(b))),
            Step::Not(d, a) => r.put_truth(d, L::not(r.truth(a))),
            // Tapes of bonds run in blocks.
            Step::Kill(_) | Step::AddTo(..) | Step::MaxTo(..) | Step::PutHistory(..) => {}
        }
    }
}

#[inline(always)]
fn one<L: Lane>(f: One, a: L) -> L {
    match f {
        One::Neg => a.neg(),
        One::Abs => a.abs(),
        One::Sqrt => a.sqrt(),
        One::Rsqrt => a.rsqrt(),
        One::Exp => a.exp(),
        One::Ln => a.ln(),
        One::Sin => a.sin(),
        One::Cos => a.cos(),
        One::Tan => a.tan(),
    }
}

#[inline(always)]
fn two<L: Lane>(f: Two, a: L, b: L) -> L {
    match f {
        Two::Add => a.add(b),
        Two::Sub => a.sub(b),
        Two::Mul => a.mul(b),
        Two::Div => a.div(b),
        Two::Min => a.min(b),
        Two::Max => a.max(b),
        Two::Pow => a.pow(b),
    }
}

/// Runs over `f64` and copies as many outputs as fit.
pub(crate) fn numbers<V: Leaves<f64>>(code: &Code, v: &mut V, out: &mut [f64]) {
    let mut r = Registers::<f64>::new();
    run(code, &mut r, v);
    for (to, &from) in out.iter_mut().zip(&code.outs) {
        *to = r.number(from);
    }
}

/// Runs a filter over `f64`; true for code without an output.
pub(crate) fn truth<V: Leaves<f64>>(code: &Code, v: &mut V) -> bool {
    let mut r = Registers::<f64>::new();
    run(code, &mut r, v);
    code.outs.first().is_none_or(|&from| r.truth(from))
}
