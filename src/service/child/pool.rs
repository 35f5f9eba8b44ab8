//! Children that wait for work.

use super::{Child, Limits};
use crate::app::{Code, Error};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A child that holds more than this when its work is done is replaced (bytes): an identification of some minutes of log stays
/// below it.
const GROWN: u64 = 192 << 20;

/// The children of a service.
pub struct Children {
    limits: Limits,
    idle: Mutex<Vec<Child>>,
}

impl Children {
    pub fn new(limits: Limits) -> Self {
        Self {
            limits,
            idle: Mutex::default(),
        }
    }

    fn idle(&self) -> MutexGuard<'_, Vec<Child>> {
        // The list is whole at every moment.
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One that waits, or a new one.
    pub async fn take(&self) -> Result<Child, Error> {
        let waiting = {
            let mut idle = self.idle();
            // What has died meanwhile is dropped.
            std::iter::from_fn(|| idle.pop()).find_map(|mut child| child.is_alive().then_some(child))
        };
        match waiting {
            Some(child) => Ok(child),
            None => self.start().await,
        }
    }

    async fn start(&self) -> Result<Child, Error> {
        let limits = self.limits.clone();
        let started = tokio::task::spawn_blocking(move || Child::start(&limits)).await;
        let started = started.unwrap_or_else(|e| Err(std::io::Error::other(e)));
        started.map_err(|error| {
            tracing::error!(%error, "no process can be started");
            Error::new(
                Code::TooManyJobs,
                format!("no process can be started for the work just now: {error}"),
            )
            .with_hint("try again later")
        })
    }

    /// Starts one that waits, so that the first work need not.
    pub async fn warm_up(&self) {
        if let Ok(child) = self.start().await {
            self.give_back(child);
        }
    }

    /// Takes back a child that has done its work.
    pub fn give_back(&self, child: Child) {
        if child.memory().is_none_or(|held| held <= GROWN) {
            self.idle().push(child);
        }
    }

    /// Ends all that wait but one.
    pub fn rest(&self) {
        let ended = {
            let mut idle = self.idle();
            let last = idle.len().saturating_sub(1);
            idle.drain(..last).collect::<Vec<_>>()
        };
        drop(ended);
    }

    /// Ends all that wait.
    pub fn end(&self) {
        let ended = std::mem::take(&mut *self.idle());
        drop(ended);
    }
}
