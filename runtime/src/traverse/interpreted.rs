//! Instances of the interpreted sweep.
use super::{Call, cloud, lattice};
use crate::kernel::{Run, Singles};
use crate::lane::Isa;
#[cfg(target_arch = "x86_64")]
use crate::lane::{Avx2, Avx512, Single, Wide};

macro_rules! instance {
    ($(#[$attr:meta])* $name:ident, $traversal:ident, $lane:ty) => {
        $(#[$attr])*
        unsafe fn $name<const D: usize, const MASKED: bool>(call: &Call, from: usize, to: usize) {
            unsafe { $traversal::chunks::<$lane, _, D, MASKED>(&*call.tape, call, from, to) }
        }
    };
}
instance!(lattice_in_scalar, lattice, f64);
instance!(cloud_in_scalar, cloud, f64);
#[cfg(target_arch = "x86_64")]
instance!(
    #[target_feature(enable = "avx2,fma")]
    lattice_in_avx2,
    lattice,
    Avx2
);
#[cfg(target_arch = "x86_64")]
instance!(
    #[target_feature(enable = "avx2,fma")]
    cloud_in_avx2,
    cloud,
    Avx2
);
#[cfg(target_arch = "x86_64")]
instance!(
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    lattice_in_avx512,
    lattice,
    Avx512
);
#[cfg(target_arch = "x86_64")]
instance!(
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    cloud_in_avx512,
    cloud,
    Avx512
);

#[cfg(target_arch = "x86_64")]
instance!(
    #[target_feature(enable = "avx2,fma")]
    lattice_in_single,
    lattice,
    Single
);

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
unsafe fn lattice_in_wide<const D: usize, const MASKED: bool>(call: &Call, from: usize, to: usize) {
    unsafe { lattice::twos::<Wide, Single, _, D, MASKED>(&*call.tape, call, from, to) }
}

/// On a lattice, in single precision.
pub(crate) fn interpreted_single(dim: usize) -> Option<Singles> {
    #[cfg(target_arch = "x86_64")]
    return Some(match dim {
        1 => single_at::<1>(),
        2 => single_at::<2>(),
        _ => single_at::<3>(),
    });
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = dim;
        None
    }
}

#[cfg(target_arch = "x86_64")]
fn single_at<const D: usize>() -> Singles {
    Singles {
        avx2: [lattice_in_single::<D, false>, lattice_in_single::<D, true>],
        wide: [lattice_in_wide::<D, false>, lattice_in_wide::<D, true>],
    }
}

/// The two instances (whole families, any) for a dimension, an instruction set and a traversal.
pub(crate) fn interpreted(dim: usize, isa: Isa, lattice: bool) -> [Run; 2] {
    match dim {
        1 => at::<1>(isa, lattice),
        2 => at::<2>(isa, lattice),
        _ => at::<3>(isa, lattice),
    }
}

fn at<const D: usize>(isa: Isa, lattice: bool) -> [Run; 2] {
    match (isa, lattice) {
        #[cfg(target_arch = "x86_64")]
        (Isa::Avx2, true) => [lattice_in_avx2::<D, false>, lattice_in_avx2::<D, true>],
        #[cfg(target_arch = "x86_64")]
        (Isa::Avx2, false) => [cloud_in_avx2::<D, false>, cloud_in_avx2::<D, true>],
        #[cfg(target_arch = "x86_64")]
        (Isa::Avx512, true) => [lattice_in_avx512::<D, false>, lattice_in_avx512::<D, true>],
        #[cfg(target_arch = "x86_64")]
        (Isa::Avx512, false) => [cloud_in_avx512::<D, false>, cloud_in_avx512::<D, true>],
        (_, true) => [lattice_in_scalar::<D, false>, lattice_in_scalar::<D, true>],
        (_, false) => [cloud_in_scalar::<D, false>, cloud_in_scalar::<D, true>],
    }
}
