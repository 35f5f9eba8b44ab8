//! What a program sets once, when it starts.

use crate::identification::physical::single_threaded_blas;

/// Settings of the process that suit long columns of numbers: OpenBLAS without threads of its own, and memory that was freed is kept for the
/// next columns. For the beginning of `main`; results do not depend on it.
pub fn settle_process() {
    single_threaded_blas();
    memory::keep_freed();
}

/// Hands memory that was freed back to the system, for programs that run on when their work is done.
pub fn hand_back_memory() {
    memory::hand_back();
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod memory {
    use std::ffi::c_int;
    use std::thread::available_parallelism;

    /// Up to this much freed memory stays with the process, and blocks up to this size come from it (bytes): several columns of a log of
    /// an hour. By default the C library hands every long column back to the system, which clears the pages of the next one again: a sixth of
    /// the time that a log takes.
    const KEPT: c_int = 32 << 20;
    // malloc.h.
    const M_TRIM_THRESHOLD: c_int = -1;
    const M_MMAP_THRESHOLD: c_int = -3;
    const M_ARENA_MAX: c_int = -8;

    unsafe extern "C" {
        fn mallopt(parameter: c_int, value: c_int) -> c_int;
        fn malloc_trim(pad: usize) -> c_int;
    }

    pub fn keep_freed() {
        // Every arena keeps what it was once filled with: as many as threads that work at the same time, not eight times as many.
        let arenas = available_parallelism().map_or(2, |n| n.get().clamp(2, 64)) as c_int;
        for (parameter, value) in [(M_TRIM_THRESHOLD, KEPT), (M_MMAP_THRESHOLD, KEPT), (M_ARENA_MAX, arenas)] {
            // SAFETY: a setter of the C library without preconditions; what it refuses stays as it was.
            unsafe { mallopt(parameter, value) };
        }
    }

    pub fn hand_back() {
        // SAFETY: works on memory that nobody has.
        unsafe { malloc_trim(0) };
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
mod memory {
    pub fn keep_freed() {}

    pub fn hand_back() {}
}
