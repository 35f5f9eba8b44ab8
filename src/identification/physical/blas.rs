//! OpenBLAS, which the solver of semidefinite programmes calls, without threads of its own.

use std::ffi::c_int;
use std::sync::Once;

static ONCE: Once = Once::new();

/// Matrices of four by four gain nothing from threads, and one thread gives one answer.
///
/// The library starts its threads when the program is loaded; `OPENBLAS_NUM_THREADS=1` in the environment keeps it from that, as
/// for the children of a server.
pub(super) fn single_threaded_blas() {
    ONCE.call_once(|| {
        // The system's library, which the solver's calls are resolved from too.
        #[link(name = "openblas")]
        unsafe extern "C" {
            fn openblas_set_num_threads(count: c_int);
        }
        // SAFETY: a plain setter of OpenBLAS, which this crate links; it has no preconditions.
        unsafe { openblas_set_num_threads(1) }
    });
}
