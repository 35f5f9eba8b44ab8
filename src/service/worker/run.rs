//! Running a claimed job: what it needs is fetched, and it works on a thread of its own.

use super::lease::Lease;
use super::{Done, HANDING_IN, NEWS, in_time, without_result};
use crate::app::{CancelFlag, Code, Error, Exchange, LogFile};
use crate::service::exchange::Link;
use crate::service::problem::internal_error;
use crate::service::progress::News;
use crate::service::state::Service;
use crate::service::store::{Claimed, Spent, State};
use crate::service::work::{Class, Input, Outcome, Request, StoredLog};
use crate::service::{rows, spread};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use tokio::sync::oneshot;

/// Searches step back behind everything else on the machine: what is asked for meanwhile gets the processor first.
const NICE: i32 = 10;

pub(super) async fn run(service: &Service, job: &Claimed, class: Class, cancel: &CancelFlag) -> Done {
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
pub(in super::super) fn on_a_thread(
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

impl Prepared {
    fn run(&self, most_rows: usize, cancel: &CancelFlag, news: &News) -> Result<Outcome, Error> {
        for log in self.logs.iter().chain(&self.validation) {
            rows::check(log, most_rows, cancel)?;
        }
        let started = std::time::Instant::now();
        let tell = |told| news.tell(told, started.elapsed());
        let exchange = self.link.as_deref().map(|link| link as &dyn Exchange);
        self.request.run(&self.logs, &self.validation, exchange, cancel, &tell)
    }
}
