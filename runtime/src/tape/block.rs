//! Arithmetic over blocks of bonds: one instruction for many rows of lanes.
//!
//! To choose an instruction takes longer than to execute it on one row. A register is therefore a column of rows, and
//! every instruction a loop over them; all registers of a tape together fit into a part of the first-level cache.
use super::pack::{One, Step, Two};
use crate::kernel::Lane;
use crate::lane::Memory;
use std::mem::MaybeUninit;

/// Rows are worked on four at a time: the number of rows of a block is a multiple.
pub(crate) const AT_ONCE: usize = 4;
/// Enough for 256 registers of that many rows.
const CAPACITY: usize = 256 * AT_ONCE;
/// Bytes that the numbers of a block may take.
const BUDGET: usize = 24 << 10;
/// More rows than this gain nothing.
const MOST_ROWS: usize = 32;

/// Registers of a block, column after column. Left uninitialised: packed code writes a register before it reads it.
pub(crate) struct File<L: Lane> {
    numbers: [MaybeUninit<L>; CAPACITY],
    truths: [MaybeUninit<L::Mask>; CAPACITY],
}

/// The columns of a [`File`].
#[derive(Clone, Copy)]
pub(crate) struct Columns<L: Lane> {
    numbers: *mut L,
    truths: *mut L::Mask,
    /// From one column to the next.
    stride: usize,
}

impl<L: Lane> File<L> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        File {
            numbers: [const { MaybeUninit::uninit() }; CAPACITY],
            truths: [const { MaybeUninit::uninit() }; CAPACITY],
        }
    }

    /// Columns of `rows` rows; see [`rows`].
    #[inline(always)]
    pub(crate) fn columns(&mut self, rows: usize) -> Columns<L> {
        Columns {
            numbers: self.numbers.as_mut_ptr().cast(),
            truths: self.truths.as_mut_ptr().cast(),
            stride: rows,
        }
    }
}

/// Rows of a block of a tape with so many registers.
pub(crate) fn rows<L: Lane>(registers: usize) -> usize {
    let room = CAPACITY.min(BUDGET / size_of::<L>()) / registers.max(1);
    (room.min(MOST_ROWS) & !(AT_ONCE - 1)).max(AT_ONCE)
}

impl<L: Lane> Columns<L> {
    /// The column of a register of numbers.
    #[inline(always)]
    pub(crate) fn number(&self, r: u8) -> *mut L {
        self.numbers.wrapping_add(self.stride * r as usize)
    }
    /// The column of a register of truth values.
    #[inline(always)]
    pub(crate) fn truth(&self, r: u8) -> *mut L::Mask {
        self.truths.wrapping_add(self.stride * r as usize)
    }
}

/// A lane type with arithmetic over blocks.
pub(crate) trait Blocks: Memory {
    /// Executes `steps` on the first `rows` rows, up to one that is not arithmetic; returns its position.
    ///
    /// # Safety
    /// The processor has the instruction set, what is read was written, and the columns have `rows` rows, a multiple
    /// of [`AT_ONCE`].
    unsafe fn arithmetic(steps: &[Step], columns: Columns<Self>, rows: usize) -> usize;
}

macro_rules! blocks {
    ($($(#[$attribute:meta])* $name:ident $lane:ty;)*) => {$(
        $(#[$attribute])*
        unsafe fn $name(steps: &[Step], columns: Columns<$lane>, rows: usize) -> usize {
            unsafe { arithmetic(steps, columns, rows) }
        }
        impl Blocks for $lane {
            #[inline(always)]
            unsafe fn arithmetic(steps: &[Step], columns: Columns<Self>, rows: usize) -> usize {
                unsafe { $name(steps, columns, rows) }
            }
        }
    )*};
}
blocks! {
    scalar f64;
}
#[cfg(target_arch = "x86_64")]
blocks! {
    #[target_feature(enable = "avx2,fma")]
    avx2 crate::lane::Avx2;
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    avx512 crate::lane::Avx512;
    #[target_feature(enable = "avx2,fma")]
    single crate::lane::Single;
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    wide crate::lane::Wide;
}

/// As [`Blocks::arithmetic`]; one function for each lane type, into which everything is inlined.
#[inline(always)]
unsafe fn arithmetic<L: Lane>(steps: &[Step], columns: Columns<L>, rows: usize) -> usize {
    /// Operands are named like columns, and stand for a row in the value. Four rows are computed before one is written,
    /// because the target may be the column of an operand.
    macro_rules! each {
        ($kind:ident $d:ident = $value:expr; $($from:ident $operand:ident),+) => {{
            let d = columns.$kind($d);
            $(let $operand = columns.$from($operand).cast_const();)+
            let mut k = 0;
            while k < rows {
                unsafe {
                    let a = { $(let $operand = *$operand.add(k);)+ $value };
                    let b = { $(let $operand = *$operand.add(k + 1);)+ $value };
                    let c = { $(let $operand = *$operand.add(k + 2);)+ $value };
                    let e = { $(let $operand = *$operand.add(k + 3);)+ $value };
                    d.add(k).write(a);
                    d.add(k + 1).write(b);
                    d.add(k + 2).write(c);
                    d.add(k + 3).write(e);
                }
                k += AT_ONCE;
            }
        }};
    }
    for (at, step) in steps.iter().enumerate() {
        match *step {
            Step::Fma(d, x, y, z) => {
                each!(number d = x.fma(y, z); number x, number y, number z)
            }
            Step::Two(d, f, x, y) => match f {
                Two::Add => each!(number d = x.add(y); number x, number y),
                Two::Sub => each!(number d = x.sub(y); number x, number y),
                Two::Mul => each!(number d = x.mul(y); number x, number y),
                Two::Div => each!(number d = x.div(y); number x, number y),
                Two::Min => each!(number d = x.min(y); number x, number y),
                Two::Max => each!(number d = x.max(y); number x, number y),
                Two::Pow => each!(number d = x.pow(y); number x, number y),
            },
            Step::One(d, f, x) => match f {
                One::Neg => each!(number d = x.neg(); number x),
                One::Abs => each!(number d = x.abs(); number x),
                One::Sqrt => each!(number d = x.sqrt(); number x),
                One::Rsqrt => each!(number d = x.rsqrt(); number x),
                One::Exp => each!(number d = x.exp(); number x),
                One::Ln => each!(number d = x.ln(); number x),
                One::Sin => each!(number d = x.sin(); number x),
                One::Cos => each!(number d = x.cos(); number x),
                One::Tan => each!(number d = x.tan(); number x),
            },
            Step::Powi(d, x, n) => each!(number d = x.powi(n); number x),
            Step::Select(d, m, x, y) => {
                each!(number d = L::select(m, x, y); truth m, number x, number y)
            }
            Step::Lt(d, x, y) => each!(truth d = x.lt(y); number x, number y),
            Step::Le(d, x, y) => each!(truth d = x.le(y); number x, number y),
            Step::And(d, x, y) => each!(truth d = L::and(x, y); truth x, truth y),
            Step::Or(d, x, y) => each!(truth d = L::or(x, y); truth x, truth y),
            Step::Not(d, x) => each!(truth d = L::not(x); truth x),
            Step::Lit(..)
            | Step::Leaf(..)
            | Step::Kill(_)
            | Step::AddTo(..)
            | Step::MaxTo(..)
            | Step::PutHistory(..) => return at,
        }
    }
    steps.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tape_has_room() {
        for registers in 0..=256 {
            let n = rows::<f64>(registers);
            assert!(n.is_multiple_of(AT_ONCE) && (AT_ONCE..=MOST_ROWS).contains(&n));
            assert!(n * registers <= CAPACITY, "{registers}");
        }
    }
}
