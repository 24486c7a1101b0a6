//! Running packed code at many places at once, over `f64`: what set-up asks bond by bond.
//!
//! The same operations in the same order as [`super::numbers`], so the same bits.
use super::block::{AT_ONCE, Blocks, File, rows};
use super::pack::{Leaf, Step};
use super::{Code, Influence};

/// Room for the registers.
pub(crate) struct Many(Box<File<f64>>);

impl Many {
    pub fn new() -> Many {
        Many(Box::new(File::new()))
    }

    /// Most places of one call.
    pub fn most(code: &Code) -> usize {
        rows::<f64>(code.registers)
    }

    /// Runs `code` at `count` places. `leaf` fills in what the tape reads there, `out` takes the outputs by position.
    pub fn run(
        &mut self,
        code: &Code,
        count: usize,
        leaf: &mut dyn FnMut(Leaf, usize, &mut [f64]),
        out: &mut dyn FnMut(usize, &[f64]),
    ) {
        assert!((1..=Many::most(code)).contains(&count));
        let columns = self.0.columns(Many::most(code));
        let padded = count.next_multiple_of(AT_ONCE);
        let mut steps = &code.steps[..];
        // SAFETY: columns have `most` rows, of which `padded` are used; code writes a register before it reads it.
        let column = |r: u8| unsafe { std::slice::from_raw_parts_mut(columns.number(r), padded) };
        loop {
            // SAFETY: as above; the scalar lane needs no instruction set.
            let done = unsafe { f64::arithmetic(steps, columns, padded) };
            let Some((step, rest)) = steps[done..].split_first() else {
                break;
            };
            match *step {
                Step::Lit(d, v) => column(d).fill(v),
                Step::Leaf(d, kind, k) => {
                    let values = column(d);
                    values.fill(0.0);
                    leaf(kind, k as usize, &mut values[..count]);
                    let last = values[count - 1];
                    values[count..].fill(last);
                }
                // The others are of tapes of bonds.
                _ => {}
            }
            steps = rest;
        }
        for (position, &r) in code.outs.iter().enumerate() {
            out(position, &column(r)[..count]);
        }
    }
}

impl Influence {
    /// Values at reference distances [m].
    pub(crate) fn each(&self, many: &mut Many, r: &[f64], to: &mut [f64]) {
        let most = Many::most(&self.code);
        for (r, to) in r.chunks(most).zip(to.chunks_mut(most)) {
            let mut leaf = |leaf: Leaf, k: usize, values: &mut [f64]| match leaf {
                Leaf::Var if k == 0 => values.copy_from_slice(r),
                Leaf::Var => values.fill(self.variables[k]),
                Leaf::Delta => values.fill(self.delta),
                _ => {}
            };
            many.run(&self.code, r.len(), &mut leaf, &mut |_, values| {
                to.copy_from_slice(values)
            });
        }
    }
}
