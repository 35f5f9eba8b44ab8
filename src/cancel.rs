//! Ending a long computation early.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A switch that ends a running computation; clones are the same switch.
///
/// Loops that may take long call [`leave_if_set`](Self::leave_if_set), and whoever started them gets the end as a value by
/// [`run`](Self::run).
#[derive(Debug, Clone, Default)]
pub struct CancelFlag(Arc<AtomicBool>);

/// What a computation ends with that was cancelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cancelled;

impl CancelFlag {
    /// Asks whoever looks at this flag to end.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the work is to end.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Ends the computation around it where the switch is set: the stack is unwound to [`run`](Self::run), over threads of a pool
    /// too. No half result is made that somebody could take for a whole one, and nothing is printed: this is no panic.
    pub fn leave_if_set(&self) {
        if self.is_cancelled() {
            resume_unwind(Box::new(Cancelled));
        }
    }

    /// The result of `work`, which may leave early by [`leave_if_set`](Self::leave_if_set) of any switch.
    ///
    /// # Errors
    /// [`Cancelled`] where it did. Panics go on.
    pub fn run<T>(work: impl FnOnce() -> T) -> Result<T, Cancelled> {
        // What `work` had half done is dropped with it.
        catch_unwind(AssertUnwindSafe(work)).map_err(|payload| match payload.downcast::<Cancelled>() {
            Ok(cancelled) => *cancelled,
            Err(panic) => resume_unwind(panic),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn leaving_ends_all_threads_with_a_value() {
        let flag = CancelFlag::default();
        let sum = |flag: &CancelFlag| -> u64 {
            let step = |i: u64| {
                flag.leave_if_set();
                i
            };
            (0..1000u64).into_par_iter().map(step).sum()
        };
        assert_eq!(CancelFlag::run(|| sum(&flag)), Ok(499_500));
        flag.clone().cancel();
        assert_eq!(CancelFlag::run(|| sum(&flag)), Err(Cancelled));
    }

    #[test]
    #[should_panic(expected = "of its own")]
    fn panics_stay_panics() {
        let _ = CancelFlag::run(|| panic!("of its own"));
    }
}
