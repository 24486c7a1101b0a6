//! Large arrays in large pages, where the system has them: who walks through gigabytes then asks a thousandth as often where
//! a page lies.

/// From here on an array is large [bytes].
#[cfg(target_os = "linux")]
const LARGE: usize = 4 << 20;

/// Zeros that nobody has touched yet.
pub fn zeros<T: Copy + Default>(len: usize) -> Vec<T> {
    let zeros = vec![T::default(); len];
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 4096;
        let bytes = size_of_val(&zeros[..]);
        if bytes >= LARGE {
            let from = zeros.as_ptr().cast::<u8>();
            let skipped = from.align_offset(PAGE);
            let to = from.wrapping_add(skipped).cast_mut();
            // SAFETY: whole pages of the array. It is a request that changes no value, and that may be refused.
            unsafe {
                libc::madvise(
                    to.cast(),
                    (bytes - skipped) / PAGE * PAGE,
                    libc::MADV_HUGEPAGE,
                )
            };
        }
    }
    zeros
}
