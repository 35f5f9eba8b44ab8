//! What a program sets once, when it starts.

use crate::identification::physical::single_threaded_blas;

/// Settings of the process that suit long columns of numbers: OpenBLAS without threads of its own, and memory that was freed is kept for the
/// next columns. For the beginning of `main`; results do not depend on it.
pub fn settle_process() {
    single_threaded_blas();
    keep_freed_memory();
}

/// Up to this much freed memory stays with the process, and blocks up to this size come from it (bytes): several columns of a log of
/// an hour. By default the C library hands every long column back to the system, which clears the pages of the next one again: a sixth of the time
/// that a log takes.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const KEPT: std::ffi::c_int = 32 << 20;

#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn keep_freed_memory() {
    use std::ffi::c_int;
    // malloc.h.
    const M_TRIM_THRESHOLD: c_int = -1;
    const M_MMAP_THRESHOLD: c_int = -3;
    unsafe extern "C" {
        fn mallopt(parameter: c_int, value: c_int) -> c_int;
    }
    for parameter in [M_TRIM_THRESHOLD, M_MMAP_THRESHOLD] {
        // SAFETY: a setter of the C library without preconditions; what it refuses stays as it was.
        unsafe { mallopt(parameter, KEPT) };
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn keep_freed_memory() {}
