//! What a program that reads long logs sets once, before it does.

/// Keeps memory that was freed for the next columns, for the beginning of a command; results do not depend on it. Children of a server have the same from
/// their environment.
pub fn keep_freed_memory() {
    memory::keep_freed();
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod memory {
    use std::ffi::c_int;

    /// Up to this much freed memory stays with the process, and blocks up to this size come from it (bytes): several columns of a log of
    /// an hour. By default the C library hands every long column back to the system, which clears the pages of the next one again: a sixth of
    /// the processor time of a log of five minutes, seven joints and 1 kHz.
    const KEPT: c_int = 32 << 20;
    // malloc.h.
    const M_TRIM_THRESHOLD: c_int = -1;
    const M_MMAP_THRESHOLD: c_int = -3;

    unsafe extern "C" {
        fn mallopt(parameter: c_int, value: c_int) -> c_int;
    }

    pub fn keep_freed() {
        for parameter in [M_TRIM_THRESHOLD, M_MMAP_THRESHOLD] {
            // SAFETY: a setter of the C library without preconditions; what it refuses stays as it was.
            unsafe { mallopt(parameter, KEPT) };
        }
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
mod memory {
    pub fn keep_freed() {}
}
