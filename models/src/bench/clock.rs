//! CPU time of the process: other programs on the machine do not count.
use std::time::Duration;

#[cfg(target_os = "linux")]
pub fn cpu() -> Duration {
    #[repr(C)]
    struct Time {
        seconds: i64,
        nanoseconds: i64,
    }
    unsafe extern "C" {
        fn clock_gettime(clock: i32, time: *mut Time) -> i32;
    }
    const PROCESS: i32 = 2;
    let mut t = Time {
        seconds: 0,
        nanoseconds: 0,
    };
    // SAFETY: the C library's function fills the two numbers.
    unsafe { clock_gettime(PROCESS, &mut t) };
    Duration::new(t.seconds as u64, t.nanoseconds as u32)
}

/// Elsewhere the time that passed.
#[cfg(not(target_os = "linux"))]
pub fn cpu() -> Duration {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed()
}
