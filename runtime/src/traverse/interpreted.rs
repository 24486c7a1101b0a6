//! Instances of the interpreted sweep.
use super::Call;
use crate::kernel::Run;
use crate::lane::Isa;
use crate::tape::TapeSweep;

macro_rules! instance {
    ($(#[$attr:meta])* $name:ident, $run:ident) => {
        $(#[$attr])*
        unsafe fn $name<const D: usize, const MASKED: bool>(call: &Call, from: usize, to: usize) {
            unsafe { super::$run::<TapeSweep, D, MASKED>(&*call.tape, call, from, to) }
        }
    };
}
instance!(lattice_in_scalar, lattice_scalar);
instance!(cloud_in_scalar, cloud_scalar);
#[cfg(target_arch = "x86_64")]
instance!(
    #[target_feature(enable = "avx2,fma")]
    lattice_in_avx2,
    lattice_avx2
);
#[cfg(target_arch = "x86_64")]
instance!(
    #[target_feature(enable = "avx2,fma")]
    cloud_in_avx2,
    cloud_avx2
);
#[cfg(target_arch = "x86_64")]
instance!(
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    lattice_in_avx512,
    lattice_avx512
);
#[cfg(target_arch = "x86_64")]
instance!(
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    cloud_in_avx512,
    cloud_avx512
);

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
