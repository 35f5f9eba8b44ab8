//! Doing jobs: claim, run under a lease, hand in.

mod course;
mod lease;
mod run;

pub(super) use course::{Course, Ending};
pub(super) use run::local;

use self::run::run;
use super::exchange::Link;
use super::spread;
use super::state::Service;
use super::store::{Claimed, Ended, Spent, State};
use super::submit::stored_error;
use super::work::{Class, JobOutcome};
use crate::app::{CancelFlag, Code, Error};
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{Instant, sleep, timeout};

/// How often the queue is looked at for jobs that came in elsewhere.
const LOOK_AGAIN: Duration = Duration::from_millis(500);
/// How often news of a job is written down.
pub(super) const NEWS: Duration = Duration::from_millis(200);
/// Pause after the database failed.
const PAUSE: Duration = Duration::from_secs(1);
/// Time in which logs are fetched or a result is written, shares gathered and all: a gigabyte comes over a line of 100 Mbit/s in
/// 80 s.
const HANDING_IN: Duration = Duration::from_secs(120);

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
        let woken = service.work().notified();
        tokio::pin!(woken);
        woken.as_mut().enable();
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
            let _ = timeout(LOOK_AGAIN, woken).await;
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
    if !job.cancel_requested {
        return None;
    }
    // What an earlier life of it has found is handed out.
    let found = in_time(HANDING_IN, service.store().spent(&job.id)).await;
    found.ok().flatten().is_none().then(|| without_result(State::Cancelled, None))
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
    Ended(Ended, Option<(Box<JobOutcome>, Spent)>),
    /// To be done by another, later, who continues from what the link knows.
    PutBack(Option<Arc<Link>>),
    /// Another has it.
    Lost,
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
        ended.outcome = Some(outcome.status.clone());
        let document = spread::gather(service, job, outcome, *before).await?;
        ended.result = Some(service.files().put(&document).await?);
        if let Some(model) = &outcome.model {
            ended.model = Some(service.files().put(model).await?);
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
