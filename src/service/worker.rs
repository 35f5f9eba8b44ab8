//! Doing jobs: claim, run under a lease, hand in.

use super::exchange::Link;
use super::problem::internal_error;
use super::progress::News;
use super::spread;
use super::state::Service;
use super::store::{Claimed, Dialect, Ended, Spent, State};
use super::submit::stored_error;
use super::work::{Class, Input, Outcome, Request, StoredLog};
use crate::app::{CancelFlag, Code, Error, Exchange, LogFile};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::oneshot;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep, timeout};

/// How often the queue is looked at for jobs that came in elsewhere.
const LOOK_AGAIN: Duration = Duration::from_millis(500);
/// How often news of a job is written down.
pub(super) const NEWS: Duration = Duration::from_millis(200);
/// Pause after the database failed.
const PAUSE: Duration = Duration::from_secs(1);
/// Time in which logs are fetched or a result is written, shares gathered and all: a gigabyte comes over a line of 100 Mbit/s in 80 s.
const HANDING_IN: Duration = Duration::from_secs(120);
/// A job whose worker died this often is what kills them.
const MOST_ATTEMPTS: i64 = 25;
/// Searches step back behind everything else on the machine: what is asked for meanwhile gets the processor first.
const NICE: i32 = 10;

/// Starts as many workers of each class as configured; needs a running tokio runtime.
pub fn start(service: &Service) {
    let config = service.config();
    let brief = usize::from(config.short_jobs > 0);
    let places = [
        (Class::Long, config.concurrent_jobs),
        (Class::Brief, brief),
        (Class::Short, config.short_jobs),
    ];
    for (class, count) in places {
        for _ in 0..count {
            tokio::spawn(place(service.clone(), class));
        }
    }
}

/// One worker: does the next job of its class as long as the service is open.
async fn place(service: Service, class: Class) {
    loop {
        // Listening before looking: work that comes in between is heard of.
        let told = service.work().notified();
        tokio::pin!(told);
        told.as_mut().enable();
        let Ok(permit) = service.idle().acquire().await else { return };
        if service.is_closing() {
            return;
        }
        let config = service.config();
        let claim = service
            .store()
            .claim(class, service.worker(), config.lease, config.running_per_robot);
        let claimed = in_time(config.lease, claim).await;
        let found = matches!(claimed, Ok(Some(_)));
        if let Ok(Some(job)) = claimed {
            service.changed(&job.id);
            do_job(&service, &job, class).await;
        }
        let helped = !found && class == Class::Long && spread::help(&service).await;
        drop(permit);
        if !found && !helped {
            let _ = timeout(LOOK_AGAIN, told).await;
        }
    }
}

async fn do_job(service: &Service, job: &Claimed, class: Class) {
    let started = Instant::now();
    service.metrics().claimed(job);
    let cancel = CancelFlag::default();
    service.running().insert(job.id.clone(), cancel.clone());
    if service.is_closing() {
        cancel.cancel();
    }
    let done = match refused(service, job).await {
        Some(ended) => Done::Ended(ended, None),
        None => run(service, job, class, &cancel).await,
    };
    hand_in(service, job, done).await;
    service.metrics().done(job, started.elapsed());
    // Only now: whoever waits for the end of a service that closes sees the job end first.
    service.running().remove(&job.id);
    service.changed(&job.id);
    service.work().notify_waiters();
}

/// A job that is not even begun.
async fn refused(service: &Service, job: &Claimed) -> Option<Ended> {
    if job.cancel_requested {
        // What an earlier life of it has found is handed out.
        let found = in_time(HANDING_IN, service.store().spent(&job.id)).await;
        return found.ok().flatten().is_none().then(|| without_result(State::Cancelled, None));
    }
    let detail = format!("the job was begun {MOST_ATTEMPTS} times, and each time the process that did it ended");
    let deadly = || Error::new(Code::Internal, detail).with_hint("it may need more memory than the machine has");
    (job.attempts > MOST_ATTEMPTS).then(|| without_result(State::Failed, Some(&deadly())))
}

fn without_result(state: State, error: Option<&Error>) -> Ended {
    Ended {
        state,
        outcome: None,
        result: None,
        model: None,
        error: error.map(stored_error),
    }
}

/// A database behind a cut cable does not even fail: what takes longer than this has.
pub(super) async fn in_time<T>(time: Duration, work: impl Future<Output = Result<T, Error>>) -> Result<T, Error> {
    let late = |_| Error::new(Code::StorageUnavailable, "the database does not answer");
    timeout(time, work).await.map_err(late)?
}

/// What became of a claimed job.
enum Done {
    /// To be handed in, with its documents and what earlier lives have spent.
    Ended(Ended, Option<(Box<Outcome>, Spent)>),
    /// To be done by another, later, who goes on from what the link knows.
    PutBack(Option<Arc<Link>>),
    /// Another has it.
    Lost,
}

async fn run(service: &Service, job: &Claimed, class: Class, cancel: &CancelFlag) -> Done {
    let mut lease = Lease::new(service, job, cancel);
    let preparing = in_time(HANDING_IN, prepare(service, job, class));
    let prepared = match lease.kept_while(preparing).await {
        Ok(prepared) => prepared,
        Err(e) if e.code == Code::StorageUnavailable => return Done::PutBack(None),
        Err(e) => return Done::Ended(without_result(State::Failed, Some(&e)), None),
    };
    if let Some(time) = spread::time_to_spread(&prepared.request, class) {
        // Without it the search is merely not shared.
        let _ = in_time(NEWS, service.store().spread(&job.id, job.lease, time)).await;
    }
    if job.cancel_requested {
        cancel.cancel();
    }
    let link = prepared.link.clone();
    let before = link.as_ref().map_or_else(Spent::default, |link| link.before);
    lease.link = link.clone();
    lease.news = News::after(before);
    let (flag, told, most_rows) = (cancel.clone(), lease.news.clone(), service.config().most_rows);
    let result = on_a_thread(class, move || prepared.run(most_rows, &flag, &told));
    let outcome = lease.kept_while(result).await.unwrap_or_else(|_| Err(internal_error()));
    lease.keep().await;
    if lease.lost {
        return Done::Lost;
    }
    // What was cancelled ends here; what only stopped because the process does goes back.
    let given_up = service.is_closing() && !lease.cancel_requested && !service.is_temporary();
    match outcome {
        Ok(outcome) if given_up && outcome.status() == "Cancelled" => Done::PutBack(link),
        Err(_) if given_up => Done::PutBack(link),
        Ok(outcome) => {
            let state = if outcome.status() == "Cancelled" {
                State::Cancelled
            } else {
                State::Finished
            };
            Done::Ended(without_result(state, None), Some((Box::new(outcome), before)))
        }
        Err(_) if cancel.is_cancelled() => Done::Ended(without_result(State::Cancelled, None), None),
        Err(error) => Done::Ended(without_result(State::Failed, Some(&error)), None),
    }
}

/// Runs work on a thread of its own.
pub(super) fn on_a_thread(
    class: Class,
    work: impl FnOnce() -> Result<Outcome, Error> + Send + 'static,
) -> oneshot::Receiver<Result<Outcome, Error>> {
    let (sender, result) = oneshot::channel();
    std::thread::spawn(move || {
        if class != Class::Short {
            // Of this thread and those it starts; where it is not possible the search merely competes.
            let _ = rustix::process::setpriority_process(None, NICE);
        }
        let outcome = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| Err(internal_error()));
        // A service that is gone needs no result.
        let _ = sender.send(outcome);
    });
    result
}

/// Keeps a job while it runs.
struct Lease<'a> {
    service: &'a Service,
    job: &'a Claimed,
    cancel: &'a CancelFlag,
    news: News,
    /// Of a search that another can go on with.
    link: Option<Arc<Link>>,
    renewed: Instant,
    cancel_requested: bool,
    lost: bool,
}

impl<'a> Lease<'a> {
    fn new(service: &'a Service, job: &'a Claimed, cancel: &'a CancelFlag) -> Self {
        Self {
            service,
            job,
            cancel,
            news: News::default(),
            link: None,
            renewed: Instant::now(),
            cancel_requested: job.cancel_requested,
            lost: false,
        }
    }

    /// Keeps the job until `work` is done.
    async fn kept_while<T>(&mut self, work: impl Future<Output = T>) -> T {
        tokio::pin!(work);
        let mut ticks = interval(NEWS);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                done = &mut work => return done,
                _ = ticks.tick() => self.keep().await,
            }
        }
    }

    /// Writes news down and renews the lease when a third of it is over: two failures may come between.
    async fn keep(&mut self) {
        if let Some(link) = self.link.as_ref().filter(|_| !self.lost) {
            link.write(false).await;
        }
        let time = self.service.config().lease;
        let (progress, step) = self.news.take();
        let told = progress.is_some() || step.is_some();
        if self.lost || (!told && self.renewed.elapsed() < time / 3) {
            return;
        }
        let store = self.service.store();
        let progress = match progress {
            Some(progress) if store.dialect() == Dialect::Postgres => {
                Some(spread::with_shares(self.service, self.job, progress).await)
            }
            own => own,
        };
        let renew = store.renew(&self.job.id, self.job.lease, time, progress.as_ref(), step.as_ref());
        match in_time(time / 3, renew).await {
            Ok(Some(answer)) => {
                self.renewed = Instant::now();
                self.cancel_requested |= answer.cancel_requested;
                if answer.cancel_requested {
                    self.cancel.cancel();
                }
            }
            Ok(None) => {
                tracing::warn!(job = self.job.id, "another worker has this job now");
                self.service.metrics().lost_lease();
                self.lost = true;
                self.cancel.cancel();
            }
            // The work goes on: if nobody else took the job until the database is back, its result counts.
            Err(_) => {}
        }
        if told {
            self.service.changed(&self.job.id);
        }
    }
}

/// A job with all it needs on this machine.
struct Prepared {
    request: Request,
    link: Option<Arc<Link>>,
    logs: Vec<LogFile>,
    validation: Vec<LogFile>,
}

async fn prepare(service: &Service, job: &Claimed, class: Class) -> Result<Prepared, Error> {
    let content = service.files().read(&job.input).await?;
    let input: Input = serde_json::from_slice(&content)
        .map_err(|e| Error::new(Code::Internal, format!("a stored request cannot be read: {e}")))?;
    let logs = local(service, &input.logs).await?;
    let validation = local(service, &input.validation).await?;
    let kind = job.kind;
    let request = tokio::task::spawn_blocking(move || Request::of(kind, &input)).await;
    let mut request = request.map_err(|_| internal_error())??;
    let mut link = None;
    if spread::time_to_spread(&request, class).is_some()
        && let Request::Excite(search) = &mut request
    {
        let own = Link::of_job(service, &job.id, job.lease).await?;
        if own.before != Spent::default() {
            spread::go_on(search, job.lease, own.before);
        }
        link = Some(Arc::new(own));
    }
    Ok(Prepared {
        request,
        link,
        logs,
        validation,
    })
}

/// Files that have come with a request, by their paths here.
pub(super) async fn local(service: &Service, logs: &[StoredLog]) -> Result<Vec<LogFile>, Error> {
    let mut files = Vec::new();
    for log in logs {
        files.push(LogFile {
            name: log.name.clone(),
            path: service.files().path(&log.hash).await?,
        });
    }
    Ok(files)
}

impl Prepared {
    fn run(&self, most_rows: usize, cancel: &CancelFlag, news: &News) -> Result<Outcome, Error> {
        for log in self.logs.iter().chain(&self.validation) {
            super::rows::check(log, most_rows)?;
        }
        let started = std::time::Instant::now();
        let tell = |told| news.tell(told, started.elapsed());
        let exchange = self.link.as_deref().map(|link| link as &dyn Exchange);
        self.request.run(&self.logs, &self.validation, exchange, cancel, &tell)
    }
}

/// Hands the result in; as long as database or disk fail, again and again.
async fn hand_in(service: &Service, job: &Claimed, done: Done) {
    loop {
        let Err(error) = in_time(HANDING_IN, try_to_hand_in(service, job, &done)).await else {
            return;
        };
        tracing::error!(job = job.id, %error, "the result cannot be handed in; trying again");
        if service.is_closing() {
            // Its lease runs out, and it is done again.
            return;
        }
        sleep(PAUSE).await;
        // A full disk does not keep the lease from being renewed.
        let time = service.config().lease;
        let _ = in_time(time / 3, service.store().renew(&job.id, job.lease, time, None, None)).await;
    }
}

async fn try_to_hand_in(service: &Service, job: &Claimed, done: &Done) -> Result<(), Error> {
    let (ended, outcome) = match done {
        Done::Lost => return Ok(()),
        Done::PutBack(link) => {
            if let Some(link) = link {
                link.write(true).await;
            }
            return service.store().release(&job.id, job.lease).await;
        }
        Done::Ended(ended, outcome) => (ended, outcome),
    };
    let mut ended = ended.clone();
    if let Some((outcome, before)) = outcome {
        ended.outcome = Some(outcome.status().to_string());
        let document = spread::gather(service, job, outcome, *before).await?;
        ended.result = Some(service.files().put(&document).await?);
        if let Some(model) = outcome.model() {
            ended.model = Some(service.files().put(&model).await?);
        }
    }
    if !service.store().finish(&job.id, job.lease, &ended).await? {
        tracing::warn!(
            job = job.id,
            "another worker has this job: its result counts, this one does not"
        );
        service.metrics().lost_lease();
    }
    Ok(())
}
