//! Running a claimed job: what it needs is fetched, and a child does it; one that dies of it is given another, once.

use super::course::{Course, Ending, Keeping};
use super::lease::Lease;
use super::{Done, HANDING_IN, PAUSE, in_time, without_result};
use crate::app::{CancelFlag, Code, Error, LogFile};
use crate::service::child::{Advance, Child, Death, JobTask, Task};
use crate::service::exchange::Link;
use crate::service::state::Service;
use crate::service::store::{Claimed, Ended, Spent, State};
use crate::service::work::{Class, Input, JobKind, JobOutcome, StoredLog};
use std::sync::{Arc, OnceLock};
use tokio::time::sleep;

/// A job whose own process has died this often has failed: the first time may have been bad luck.
const MOST_DEATHS: i64 = 2;

pub(super) async fn run(service: &Service, job: &Claimed, class: Class, cancel: &CancelFlag) -> Done {
    let mut lease = Lease::new(service, job, cancel);
    let link = match lease.kept_while(in_time(HANDING_IN, link(service, job, class))).await {
        Ok(link) => link,
        Err(_) => return Done::PutBack(None),
    };
    lease.link.clone_from(&link);
    if job.cancel_requested {
        cancel.cancel();
    }
    let attempt = Attempt {
        service,
        job,
        class,
        cancel,
        link,
        kept: OnceLock::new(),
    };
    loop {
        let ending = attempt.once(&mut lease).await;
        lease.keep().await;
        if lease.lost {
            return Done::Lost;
        }
        // What was cancelled ends here; what only stopped because the process does goes back.
        let given_up = service.is_closing() && !lease.cancel_requested && !service.is_temporary();
        let done = match ending {
            Ok(Ending::Died(death)) if !given_up && !cancel.is_cancelled() => attempt.after(&death).await,
            ending => Some(attempt.end(ending, given_up)),
        };
        if let Some(done) = done {
            return done;
        }
    }
}

/// Of a search that may be long: with what earlier lives have spent.
async fn link(service: &Service, job: &Claimed, class: Class) -> Result<Option<Arc<Link>>, Error> {
    match (job.kind, class) {
        (JobKind::Excitation, Class::Long) => Link::of_job(service, &job.id, job.lease).await.map(|l| Some(Arc::new(l))),
        _ => Ok(None),
    }
}

/// A job and those who do it.
struct Attempt<'a> {
    service: &'a Service,
    job: &'a Claimed,
    class: Class,
    cancel: &'a CancelFlag,
    link: Option<Arc<Link>>,
    /// Its result, where all that is missing are predictions.
    kept: OnceLock<JobOutcome>,
}

impl Attempt<'_> {
    fn before(&self) -> Spent {
        self.link.as_ref().map_or_else(Spent::default, |link| link.before)
    }

    /// Gives the job to a child and follows it.
    async fn once(&self, lease: &mut Lease<'_>) -> Result<Ending, Error> {
        let task = lease.kept_while(in_time(HANDING_IN, self.task())).await?;
        let Some(mut child) = lease.kept_while(self.child()).await else {
            return Ok(Ending::Deaf);
        };
        let news = lease.news.clone();
        let course = Course {
            service: self.service,
            cancel: self.cancel,
            link: self.link.as_deref(),
            news: &news,
            job: Some(Keeping {
                claimed: self.job,
                kept: &self.kept,
            }),
        };
        child.begin(task);
        let ending = lease.kept_while(course.follow(&mut child)).await;
        if matches!(ending, Ending::Done(_) | Ending::Failed(_)) {
            self.service.children().give_back(child);
        }
        Ok(ending)
    }

    async fn task(&self) -> Result<Task, Error> {
        let content = self.service.files().read(&self.job.input).await?;
        let input: Input = serde_json::from_slice(&content)
            .map_err(|e| Error::new(Code::Internal, format!("a stored request cannot be read: {e}")))?;
        let before = self.before();
        Ok(Task::Job(Box::new(JobTask {
            kind: self.job.kind,
            logs: local(self.service, &input.logs).await?.into_iter().map(Into::into).collect(),
            validation: local(self.service, &input.validation)
                .await?
                .into_iter()
                .map(Into::into)
                .collect(),
            input,
            most_rows: self.service.config().most_rows,
            long: self.class == Class::Long,
            nice: self.class != Class::Short,
            advance: Advance {
                lease: self.job.lease,
                seconds: before.time.as_secs_f64(),
                evaluations: before.evaluations,
            },
            share: None,
        })))
    }

    /// A child, as soon as there is one: a machine without room for another process has one later. `None` if the work is to end
    /// before.
    async fn child(&self) -> Option<Child> {
        loop {
            match self.service.child().await {
                Ok(child) => return Some(child),
                Err(_) if self.cancel.is_cancelled() => return None,
                Err(_) => sleep(PAUSE).await,
            }
        }
    }

    /// What comes after a death: the end, or another attempt.
    async fn after(&self, death: &Death) -> Option<Done> {
        let (store, job) = (self.service.store(), self.job);
        self.service.metrics().child_died(death);
        tracing::error!(job = job.id, ?death, "the process that did a job died");
        if let Some(kept) = self.kept.get() {
            let outcome = kept.clone().without_predictions(&death.error("the predictions"));
            return Some(self.finished(outcome));
        }
        match in_time(HANDING_IN, store.child_died(&job.id, job.lease)).await {
            Ok(Some(deaths)) if deaths >= MOST_DEATHS => Some(self.failed(&death.error("the job"))),
            Ok(Some(_)) => None,
            Ok(None) => Some(Done::Lost),
            Err(_) => {
                // The lease runs out unless the database comes back.
                sleep(PAUSE).await;
                Some(Done::PutBack(self.link.clone()))
            }
        }
    }

    fn end(&self, ending: Result<Ending, Error>, given_up: bool) -> Done {
        match ending {
            Err(e) if e.code == Code::StorageUnavailable => Done::PutBack(self.link.clone()),
            Err(e) => self.failed(&e),
            Ok(Ending::Done(outcome)) if given_up && outcome.status == "Cancelled" => Done::PutBack(self.link.clone()),
            Ok(Ending::Done(outcome)) => self.finished(outcome),
            Ok(_) if given_up => Done::PutBack(self.link.clone()),
            Ok(Ending::Failed(error)) if !self.cancel.is_cancelled() => self.failed(&error),
            Ok(_) => match self.kept.get() {
                Some(kept) => self.finished(kept.clone()),
                None => Done::Ended(without_result(State::Cancelled, None), None),
            },
        }
    }

    fn finished(&self, outcome: JobOutcome) -> Done {
        let state = match outcome.status.as_str() {
            "Cancelled" => State::Cancelled,
            _ => State::Finished,
        };
        Done::Ended(without_result(state, None), Some((Box::new(outcome), self.before())))
    }

    /// A job that has a result of an earlier life does not fail: what went wrong then is no more than its predictions.
    fn failed(&self, error: &Error) -> Done {
        let Some(kept) = &self.job.kept else {
            return Done::Ended(without_result(State::Failed, Some(error)), None);
        };
        let ended = Ended {
            outcome: kept.outcome.clone(),
            result: Some(kept.result.clone()),
            model: kept.model.clone(),
            ..without_result(State::Finished, None)
        };
        Done::Ended(ended, None)
    }
}

/// Files that have come with a request, by their paths here.
pub(in super::super) async fn local(service: &Service, logs: &[StoredLog]) -> Result<Vec<LogFile>, Error> {
    let mut files = Vec::new();
    for log in logs {
        files.push(LogFile {
            name: log.name.clone(),
            path: service.files().path(&log.hash).await?,
        });
    }
    Ok(files)
}
