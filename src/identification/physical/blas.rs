//! OpenBLAS, which the solver of semidefinite programmes calls, without its threads.

use std::ffi::{c_char, c_int, c_void};
use std::sync::Once;

static ONCE: Once = Once::new();

/// Matrices of four by four gain nothing from threads, and one thread gives one answer.
///
/// The library starts its threads when the program is loaded, and they look for work without pause for a tenth of a second before they
/// sleep, on cores that others could use: the earlier this is called the better.
pub(crate) fn single_threaded_blas() {
    ONCE.call_once(|| {
        unsafe extern "C" {
            fn openblas_set_num_threads(count: c_int);
        }
        // SAFETY: a plain setter of OpenBLAS, which this crate links; it has no preconditions.
        unsafe { openblas_set_num_threads(1) }
        end_threads();
    });
}

/// Ends the threads that are there, as the library does itself before a process forks. Its builds without threads have nothing to end: the
/// function is looked up by name.
#[cfg(target_os = "linux")]
fn end_threads() {
    unsafe extern "C" {
        fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
    }
    // SAFETY: null stands for all libraries of the process, and the name ends with a zero.
    let found = unsafe { dlsym(std::ptr::null_mut(), c"blas_thread_shutdown_".as_ptr()) };
    if found.is_null() {
        return;
    }
    // SAFETY: OpenBLAS declares it as `int blas_thread_shutdown_(void)`. Nothing of the library runs: all calls come after this one.
    let shutdown = unsafe { std::mem::transmute::<*mut c_void, extern "C" fn() -> c_int>(found) };
    shutdown();
}

#[cfg(not(target_os = "linux"))]
fn end_threads() {}
