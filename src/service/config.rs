//! What an operator may choose.

use std::time::Duration;

/// Bounds of the service.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Searches that run at the same time. A search uses all cores, so more than one shares them.
    pub concurrent_jobs: usize,
    /// Jobs that may wait; further ones are refused with `too_many_jobs`.
    pub waiting_jobs: usize,
    /// Finished jobs whose results are kept; the oldest go first.
    pub kept_jobs: usize,
    /// Longest time that `Prefer: wait` holds an answer back.
    pub longest_wait: Duration,
    /// Largest document accepted (bytes). URDF files with many links reach a few hundred kilobytes.
    pub largest_document: usize,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            concurrent_jobs: 1,
            waiting_jobs: 100,
            kept_jobs: 1000,
            longest_wait: Duration::from_secs(600),
            largest_document: 8 << 20,
        }
    }
}
