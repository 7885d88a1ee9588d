//! CPU time.

/// Seconds and nanoseconds, as the system has them.
#[repr(C)]
struct Time {
    seconds: i64,
    nanoseconds: i64,
}

unsafe extern "C" {
    fn clock_gettime(clock: i32, to: *mut Time) -> i32;
}

/// Linux's number of the clock of a thread's CPU time.
const THREAD: i32 = 3;

/// Of this thread [s]; other work on the machine doesn't count.
pub fn thread() -> f64 {
    let mut time = Time { seconds: 0, nanoseconds: 0 };
    // SAFETY: the system's own function, which writes one `Time`.
    let failed = unsafe { clock_gettime(THREAD, &mut time) };
    assert_eq!(failed, 0, "a Linux kernel knows this clock");
    time.seconds as f64 + 1e-9 * time.nanoseconds as f64
}

/// The middle of some numbers.
pub fn median(mut x: Vec<f64>) -> f64 {
    x.sort_by(f64::total_cmp);
    x[x.len() / 2]
}
