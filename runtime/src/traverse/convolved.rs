//! Nodes of a sweep whose sums over bonds are known as convolutions: prologue, sums, epilogue.
use super::{CHUNK, Call, Nodes};
use crate::lane::Isa;
#[cfg(target_arch = "x86_64")]
use crate::lane::{Avx2, Avx512};
use crate::tape::Blocks;

/// `factor` times numbers of the node times an array adds to a sum.
#[derive(Clone, Debug)]
pub(crate) struct Term {
    pub sum: usize,
    pub factor: f64,
    /// In layout order, as all arrays here.
    pub array: *const f64,
    /// Its factors, by position in [`Convolved::factors`].
    pub from: usize,
    pub to: usize,
}

/// A number of the node.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Factor {
    Pre(usize),
    Array(*const f64),
}

/// What takes the place of the bonds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Convolved {
    pub terms: Vec<Term>,
    pub factors: Vec<Factor>,
}

// SAFETY: arrays are read only while it is in use.
unsafe impl Sync for Convolved {}

/// Runs the chunks `from..to` of a call.
///
/// # Safety
/// As [`crate::kernel::Run`]; all arrays have the length of the layout.
pub(crate) type RunConvolved = unsafe fn(&Call, &Convolved, usize, usize);

pub(crate) fn convolved(isa: Isa) -> RunConvolved {
    match isa {
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => in_avx2,
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => in_avx512,
        _ => chunks::<f64>,
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
unsafe fn in_avx2(call: &Call, sums: &Convolved, from: usize, to: usize) {
    unsafe { chunks::<Avx2>(call, sums, from, to) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
unsafe fn in_avx512(call: &Call, sums: &Convolved, from: usize, to: usize) {
    unsafe { chunks::<Avx512>(call, sums, from, to) }
}

#[inline(always)]
unsafe fn chunks<L: Blocks>(call: &Call, sums: &Convolved, from: usize, to: usize) {
    let mut chunk = from;
    while chunk < to {
        let mut part = 0;
        while part < CHUNK / L::W {
            unsafe {
                let at = *call.base.add(chunk) as usize + part * L::W;
                let mut nodes = Nodes::<true>::new::<L>(call, chunk, part, at);
                let tape = &*call.tape;
                let pre = tape.prologue::<L, _>(&nodes);
                let mut acc = tape.zeros::<L>();
                for term in &sums.terms {
                    let mut v = L::load(term.array.add(at));
                    for factor in &sums.factors[term.from..term.to] {
                        v = v.mul(match *factor {
                            Factor::Pre(k) => pre[k],
                            Factor::Array(a) => L::load(a.add(at)),
                        });
                    }
                    acc[term.sum] = v.fma(L::splat(term.factor), acc[term.sum]);
                }
                tape.epilogue(&pre, &acc, &mut nodes);
            }
            part += 1;
        }
        chunk += 1;
    }
}
