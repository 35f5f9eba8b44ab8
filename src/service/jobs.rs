//! Jobs in memory: a queue served first come, first served, by a bounded number of workers.

use super::config::Config;
use super::problem::internal_error;
use super::work::{Outcome, Told, Work};
use crate::app::{CancelFlag, Code, Error, Excited, Step};
use crate::excitation::Progress;
use std::collections::{HashMap, VecDeque};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::SystemTime;
use tokio::sync::{Semaphore, mpsc, watch};
use uuid::Uuid;

/// Where a job stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    Queued,
    Running,
    Finished,
    /// Ended on request; with the best result found if it had begun.
    Cancelled,
    Failed,
}

impl State {
    pub fn name(self) -> &'static str {
        match self {
            State::Queued => "queued",
            State::Running => "running",
            State::Finished => "finished",
            State::Cancelled => "cancelled",
            State::Failed => "failed",
        }
    }

    pub fn is_final(self) -> bool {
        matches!(self, State::Finished | State::Cancelled | State::Failed)
    }
}

/// What is told about a job while it goes on.
#[derive(Debug, Clone)]
pub struct Status {
    /// Grows with every change: the id of the event.
    pub sequence: u64,
    pub state: State,
    pub progress: Option<Progress>,
    pub step: Option<Step>,
    pub started: Option<SystemTime>,
    pub finished: Option<SystemTime>,
    pub error: Option<Error>,
}

/// One piece of work.
pub struct Job {
    pub id: String,
    pub created: SystemTime,
    cancel: CancelFlag,
    work: Mutex<Option<Work>>,
    kind: &'static str,
    result_address: String,
    result: OnceLock<Outcome>,
    status: watch::Sender<Status>,
}

impl Job {
    fn new(work: Work) -> Self {
        let id = Uuid::new_v4().to_string();
        let status = Status {
            sequence: 1,
            state: State::Queued,
            progress: None,
            step: None,
            started: None,
            finished: None,
            error: None,
        };
        Self {
            kind: work.kind(),
            result_address: work.result_address(&id),
            id,
            created: SystemTime::now(),
            cancel: CancelFlag::default(),
            work: Mutex::new(Some(work)),
            result: OnceLock::new(),
            status: watch::channel(status).0,
        }
    }

    pub fn status(&self) -> Status {
        self.status.borrow().clone()
    }

    pub fn watch(&self) -> watch::Receiver<Status> {
        self.status.subscribe()
    }

    pub fn outcome(&self) -> Option<&Outcome> {
        self.result.get()
    }

    /// The design, if this job was to make one and has.
    pub fn excited(&self) -> Option<&Excited> {
        match self.outcome() {
            Some(Outcome::Excited(excited)) => Some(excited),
            _ => None,
        }
    }

    /// `excitation`, `identification` or `validation`.
    pub fn kind(&self) -> &'static str {
        self.kind
    }

    /// Where the result is.
    pub fn result_address(&self) -> String {
        self.result_address.clone()
    }

    pub fn cancel_requested(&self) -> bool {
        self.cancel.is_cancelled()
    }

    /// Ends the job: at once if it waits, within a second if it runs, and not at all if it has ended.
    pub fn cancel(&self) {
        self.cancel.cancel();
        self.change(|s| {
            if s.state == State::Queued {
                s.state = State::Cancelled;
                s.finished = Some(SystemTime::now());
            }
        });
    }

    /// Resolves when the job has ended.
    pub async fn ended(&self) {
        // The sender lives in self: the wait cannot fail.
        let _ = self.watch().wait_for(|s| s.state.is_final()).await;
    }

    /// Changes the status unless it is final.
    fn change(&self, change: impl FnOnce(&mut Status)) {
        self.status.send_if_modified(|status| {
            if status.state.is_final() {
                return false;
            }
            change(status);
            status.sequence += 1;
            true
        });
    }

    /// Does the work on the calling thread.
    fn run(&self) {
        let mut begun = false;
        self.change(|s| {
            s.state = State::Running;
            s.started = Some(SystemTime::now());
            begun = true;
        });
        if !begun {
            return;
        }
        // Taken out: uploaded files go when the work is done, whatever becomes of the job.
        let Some(work) = self.work.lock().unwrap_or_else(PoisonError::into_inner).take() else {
            return;
        };
        let tell = |told: Told| {
            self.change(|s| match told {
                Told::Search(progress) => s.progress = Some(progress),
                Told::Step(step) => s.step = Some(step),
            });
        };
        match work.run(&self.cancel, &tell) {
            Ok(outcome) => {
                let cancelled = outcome.status() == "Cancelled";
                // Set before the final state is told: whoever sees that finds the result.
                let _ = self.result.set(outcome);
                self.finish(if cancelled { State::Cancelled } else { State::Finished }, None);
            }
            Err(_) if self.cancel_requested() => self.finish(State::Cancelled, None),
            Err(error) => self.finish(State::Failed, Some(error)),
        }
    }

    fn finish(&self, state: State, error: Option<Error>) {
        self.change(|s| {
            s.state = state;
            s.finished = Some(SystemTime::now());
            s.error = error;
        });
    }
}

/// All jobs of the service. Clones share.
#[derive(Clone)]
pub struct Jobs(Arc<Shared>);

struct Shared {
    table: Mutex<Table>,
    kept: usize,
    workers: usize,
    idle: Arc<Semaphore>,
}

#[derive(Default)]
struct Table {
    jobs: HashMap<String, Arc<Job>>,
    /// Ids by age.
    order: VecDeque<String>,
    /// Job that an `Idempotency-Key` began, and the hash of the body it came with.
    keys: HashMap<String, (u64, String)>,
    /// `None` once the service is closing.
    queue: Option<mpsc::Sender<Arc<Job>>>,
}

impl Jobs {
    pub fn start(config: &Config) -> Self {
        let (queue, waiting) = mpsc::channel::<Arc<Job>>(config.waiting_jobs.max(1));
        let workers = config.concurrent_jobs.max(1);
        let idle = Arc::new(Semaphore::new(workers));
        tokio::spawn(dispatch(waiting, idle.clone()));
        let table = Mutex::new(Table {
            queue: Some(queue),
            ..Table::default()
        });
        Self(Arc::new(Shared {
            table,
            kept: config.kept_jobs.max(1),
            workers,
            idle,
        }))
    }

    fn table(&self) -> MutexGuard<'_, Table> {
        // No function panics with the table half changed.
        self.0.table.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts a job into the queue; with a key that was used before for the same body, hands back the job it began.
    pub fn submit(&self, work: impl Into<Work>, key: Option<(String, &[u8])>) -> Result<Arc<Job>, Error> {
        let key = key.map(|(key, body)| (key, hash(body)));
        let mut table = self.table();
        if let Some((key, body)) = &key
            && let Some((known_body, id)) = table.keys.get(key)
            && let Some(job) = table.jobs.get(id)
        {
            return match known_body == body {
                true => Ok(job.clone()),
                false => Err(Error::new(
                    Code::IdempotencyKeyReused,
                    format!("the key `{key}` came with another document before"),
                )),
            };
        }
        let Some(queue) = &table.queue else {
            return Err(Error::new(
                Code::ShuttingDown,
                "the server is shutting down and takes no new jobs",
            ));
        };
        let job = Arc::new(Job::new(work.into()));
        queue
            .try_send(job.clone())
            .map_err(|_| Error::new(Code::TooManyJobs, "too many jobs are waiting already"))?;
        table.jobs.insert(job.id.clone(), job.clone());
        table.order.push_back(job.id.clone());
        if let Some((key, body)) = key {
            table.keys.insert(key, (body, job.id.clone()));
        }
        table.forget_oldest(self.0.kept);
        Ok(job)
    }

    pub fn get(&self, id: &str) -> Option<Arc<Job>> {
        self.table().jobs.get(id).cloned()
    }

    /// All jobs, the newest first.
    pub fn list(&self) -> Vec<Arc<Job>> {
        let table = self.table();
        table
            .order
            .iter()
            .rev()
            .filter_map(|id| table.jobs.get(id).cloned())
            .collect()
    }

    /// Takes no further jobs and cancels all there are.
    pub fn close(&self) {
        let mut table = self.table();
        table.queue = None;
        table.jobs.values().for_each(|job| job.cancel());
    }

    pub fn is_closing(&self) -> bool {
        self.table().queue.is_none()
    }

    /// Resolves when no job runs any more.
    pub async fn drained(&self) {
        let _ = self.0.idle.acquire_many(self.0.workers as u32).await;
    }
}

fn hash(body: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    body.hash(&mut hasher);
    hasher.finish()
}

impl Table {
    /// Forgets the oldest ended jobs beyond `kept`.
    fn forget_oldest(&mut self, kept: usize) {
        let ended: Vec<String> = self
            .order
            .iter()
            .filter(|id| self.jobs.get(*id).is_none_or(|j| j.status().state.is_final()))
            .cloned()
            .collect();
        for id in ended.iter().take(ended.len().saturating_sub(kept)) {
            self.jobs.remove(id);
            self.order.retain(|other| other != id);
            self.keys.retain(|_, (_, job)| job != id);
        }
    }
}

/// Hands jobs to threads in the order of their arrival, as many at a time as `idle` has permits.
async fn dispatch(mut waiting: mpsc::Receiver<Arc<Job>>, idle: Arc<Semaphore>) {
    while let Some(job) = waiting.recv().await {
        let permit = idle.clone().acquire_owned().await;
        tokio::spawn(async move {
            let worker = job.clone();
            if let Err(panic) = tokio::task::spawn_blocking(move || worker.run()).await {
                tracing::error!(job = job.id, %panic, "job failed");
                job.finish(State::Failed, Some(internal_error()));
            }
            drop(permit);
        });
    }
}
