//! Values that are made when they are first asked for, and kept.

use std::sync::OnceLock;

/// A value made once and kept.
///
/// No thread waits for another that makes it. A worker of rayon that waits inside the making may be handed a task that asks for
/// the same value, and would wait for itself without end. Threads that ask at the same time all make it; what they make is equal,
/// and the first is kept.
pub(crate) struct Kept<T>(OnceLock<T>);

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Self(OnceLock::new())
    }
}

impl<T> Kept<T> {
    /// The value, by `make` where it is not there yet.
    pub fn get(&self, make: impl FnOnce() -> T) -> &T {
        if let Some(known) = self.0.get() {
            return known;
        }
        let made = make();
        self.0.get_or_init(|| made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;
    use std::time::Duration;

    /// What is made in parallel is asked for in parallel, beside tasks that do not ask: workers that have nothing else to do help
    /// to make it, and whoever waits for them is handed tasks that ask for it.
    #[test]
    fn regress_tasks_that_ask_while_it_is_made_do_not_wait_for_themselves() {
        let nap = |microseconds| std::thread::sleep(Duration::from_micros(microseconds));
        let (done, finished) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
            let value = |i: u64| {
                nap(100);
                i
            };
            for _ in 0..20 {
                let kept = Kept::<u64>::default();
                let make = || (0..640_u64).into_par_iter().map(value).sum();
                let task = |i: u64| match i % 5 {
                    0 => *kept.get(make),
                    _ => {
                        nap(50);
                        204_480
                    }
                };
                let got: Vec<u64> = pool.install(|| (0..256).into_par_iter().map(task).collect());
                assert_eq!(got, vec![204_480; 256]);
            }
            done.send(()).unwrap();
        });
        finished
            .recv_timeout(Duration::from_secs(120))
            .expect("no worker waits for itself");
    }
}
