//! Numerical work in processes of their own: one that aborts, runs out of memory or never ends costs the work that it did, and
//! nothing else.
//!
//! A child is this program again (`dynident child`), connected by one socket: a `Task` goes in, news and the answer come out, as
//! MessagePack. It ends when the other end of the socket is closed, however the server ended. Children are used again, so that a
//! short task does not wait for a start; one that has grown is replaced. What they have in common with the server is files: logs
//! go in by their paths.
//!
//! Routes use `Service::compute`, which ends the child when the client has gone; jobs use `Service::child` and follow its
//! `Event`s.

mod confine;
mod fault;
mod inside;
mod message;
mod pool;
mod process;

pub use inside::main;
pub(super) use message::{Advance, FromChild, JobTask, Latest, RobotRead, Series, ShareOf, Spot, Task, ToChild};
pub(super) use pool::Children;
pub(super) use process::{Child, Death, Event};

use self::confine::memory_of_machine;
use super::blocking::ended;
use super::config::Config;
use super::problem::internal_error;
use super::state::Service;
use super::submit::error_from;
use crate::app::{Code, Error};
use std::time::Duration;
use tokio::time::{Instant, sleep_until};

/// Longest time that the work of a request may take; most of it takes some milliseconds.
pub(super) const REQUEST: Duration = Duration::from_secs(30);

/// What the children of a service may take.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Limits {
    /// Program to start; `None` for a thread of this process, which nothing confines.
    pub program: Option<std::path::PathBuf>,
    pub memory: u64,
}

impl Limits {
    pub fn from_config(config: &Config) -> Self {
        Self {
            program: config.program.clone(),
            memory: config.job_memory.unwrap_or_else(|| memory_of_machine() / 2),
        }
    }
}

impl Service {
    /// A child that waits for a task.
    ///
    /// # Errors
    /// None can be started just now: no handles, no memory for it.
    pub(super) async fn child(&self) -> Result<Child, Error> {
        self.children().take().await
    }

    /// Does `task` in a child, and hands back the bytes of its answer. Whoever drops the future ends the work: the child of a
    /// task that was not finished is killed.
    ///
    /// # Errors
    /// Those of the task; `time_limit` where it takes longer than `limit`, `memory_limit` and `job_crashed` where its child died.
    pub(super) async fn compute(&self, task: Task, limit: Duration) -> Result<Vec<u8>, Error> {
        let _place = self.interactive().acquire_owned().await.map_err(|_| internal_error())?;
        let mut child = self.child().await?;
        child.begin(task);
        let until = Instant::now() + limit;
        loop {
            // Listening before looking: a server that closes in between is heard of.
            let news = self.work().notified();
            tokio::pin!(news);
            news.as_mut().enable();
            if self.is_closing() {
                return Err(ended());
            }
            let event = tokio::select! {
                event = child.event() => event,
                () = sleep_until(until) => Event::Died(Death::TooLong(limit)),
                () = news => continue,
            };
            match event {
                Event::Notice(FromChild::Answer(bytes)) => {
                    self.children().give_back(child);
                    return Ok(bytes);
                }
                Event::Notice(FromChild::Failed(error)) => {
                    self.children().give_back(child);
                    return Err(error_from(&error));
                }
                Event::Notice(_) => {}
                Event::Died(death) => {
                    self.metrics().child_died(&death);
                    return Err(death.error("the request"));
                }
            }
        }
    }

    /// [`Service::compute`] for an answer that is a document.
    pub(super) async fn compute_document<T: serde::de::DeserializeOwned>(&self, task: Task, limit: Duration) -> Result<T, Error> {
        let bytes = self.compute(task, limit).await?;
        let unreadable = |e| Error::new(Code::Internal, format!("an answer of a child cannot be read: {e}"));
        serde_json::from_slice(&bytes).map_err(unreadable)
    }
}
