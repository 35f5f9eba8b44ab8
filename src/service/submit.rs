//! Asking for jobs, looking at them and waiting for them.

use super::access::Access;
use super::child::{REQUEST, Task};
use super::known::{Known, robot_inside, robot_named};
use super::problem::internal_error;
use super::state::Service;
use super::store::{JobRow, Key, NewJob, Role, State, Submission, Waiting, sha256};
use super::work::{Input, JobKind, Measure, StoredLog};
use crate::app::{CancelFlag, Code, Error};
use crate::formats::Parsed;
use crate::model::FieldProblem;
use axum::http::HeaderMap;
use serde_json::json;
use std::time::Duration;
use tokio::sync::broadcast;
use tokio::time::Instant;
use uuid::Uuid;

/// How often a job is looked at that may change on another machine.
const LOOK_AGAIN: Duration = Duration::from_millis(500);
/// RFC 9218: what is not said to be more or less urgent.
const DEFAULT_URGENCY: u8 = 3;

/// What came with a request for work.
pub struct Asked {
    pub kind: JobKind,
    pub parsed: Parsed,
    pub logs: Vec<StoredLog>,
    pub validation: Vec<StoredLog>,
    /// Stands for all that was sent: the same bytes, the same hash.
    pub body: String,
}

/// What the headers say about a request for work.
#[derive(Debug, Clone)]
pub struct Wishes {
    key: Option<String>,
    urgency: u8,
    /// `Cache-Control: no-cache`: do it again, even if the same was done before.
    afresh: bool,
}

impl Wishes {
    pub fn read(headers: &HeaderMap) -> Self {
        let text = |name: &str| headers.get(name).and_then(|v| v.to_str().ok());
        let urgency = text("priority").and_then(|v| {
            let mut members = v.split(',').map(str::trim);
            members.find_map(|m| m.strip_prefix("u=")?.parse().ok().filter(|u| *u <= 7))
        });
        Self {
            key: text("idempotency-key").map(str::to_string),
            urgency: urgency.unwrap_or(DEFAULT_URGENCY),
            afresh: text("cache-control").is_some_and(|v| v.to_ascii_lowercase().contains("no-cache")),
        }
    }
}

impl Service {
    /// Reads a request and puts its job into the queue; hands back an earlier one that is the same.
    pub(super) async fn submit(&self, asked: Asked, wishes: Wishes, access: &Access) -> Result<JobRow, Error> {
        access.require(Role::Run)?;
        if self.is_closing() {
            return Err(Error::new(
                Code::ShuttingDown,
                "the server is shutting down and takes no new jobs",
            ));
        }
        let (body, kind) = (asked.body, asked.kind);
        let key = wishes.key.map(|name| Key { name, body, kind });
        if let Some(key) = &key
            && let Some(job) = self.store().begun_with(access.token(), key).await?
        {
            return Ok(job);
        }
        let known = Known::for_request(&asked.parsed.value, self, access).await?;
        let owner = known.owner().map(str::to_string);
        let input = Input {
            request: asked.parsed.value.clone(),
            known,
            logs: asked.logs,
            validation: asked.validation,
        };
        let check = Task::Check {
            kind,
            document: asked.parsed.into(),
            known: input.known.clone().into(),
        };
        let request: Measure = self.compute_document(check, REQUEST).await?;
        // Megabytes of JSON take a while.
        let write = move |_: &CancelFlag| {
            let content = serde_json::to_vec(&input).expect("plain data");
            let fingerprint = sha256(&[kind.name().as_bytes(), env!("CARGO_PKG_VERSION").as_bytes(), &content].concat());
            Ok((input, content, fingerprint))
        };
        let (input, content, fingerprint) = self.blocking(write).await?;
        self.check_limits(&request)?;
        let robot = access.owner(robot_named(&input.request).or(owner.as_deref()), robot_inside(&input.request))?;
        if key.is_none()
            && !wishes.afresh
            && let Some(job) = self.store().finished_before(&robot, &fingerprint).await?
        {
            return Ok(job);
        }
        let file = self.files().put(&content).await?;
        let named = input.logs.iter().chain(&input.validation).map(|l| l.hash.clone());
        let job = NewJob {
            id: Uuid::new_v4().to_string(),
            kind,
            class: request.class(self.config().shortest_long_s),
            token: access.token().to_string(),
            urgency: wishes.urgency,
            fingerprint,
            files: named.chain([file.clone()]).collect(),
            input: file,
            logs: input.logs.iter().chain(&input.validation).map(|l| l.name.clone()).collect(),
            robot,
        };
        self.enqueue(&job, key.as_ref(), access).await
    }

    async fn enqueue(&self, job: &NewJob, key: Option<&Key>, access: &Access) -> Result<JobRow, Error> {
        let config = self.config();
        let most = Waiting {
            in_all: config.waiting_jobs,
            per_robot: config.waiting_per_robot,
            per_token: config.waiting_per_token,
        };
        let entry = access.entry(&format!("run_{}", job.kind.name()), &job.robot, &job.id);
        let id = match self.store().submit(job, key, most, &entry).await? {
            Submission::Queued => {
                self.work().notify_waiters();
                job.id.clone()
            }
            Submission::Known(id) => id,
        };
        let row = self.store().job(&id).await?;
        row.ok_or_else(internal_error)
    }

    /// What a document may ask of this server, beyond what is right or wrong in itself.
    fn check_limits(&self, request: &Measure) -> Result<(), Error> {
        let config = self.config();
        let mut problems = Vec::new();
        let mut check = |pointer: &str, value: f64, most: f64| {
            if value > most {
                let problem = FieldProblem::new(pointer, format!("is {value}; this server takes at most {most}"));
                problems.push(problem.with_hint("ask its operator for more, or run it on the command line"));
            }
        };
        check("/robot/joints", request.joints as f64, config.most_joints as f64);
        if let Some((time_limit_s, order)) = request.search {
            check("/search/time_limit_s", time_limit_s, config.longest_search_s);
            check("/fourier/order", order as f64, config.highest_order as f64);
        }
        match problems.is_empty() {
            true => Ok(()),
            false => Err(Error::invalid("the request", problems)),
        }
    }

    /// A job that `access` sees.
    pub(super) async fn find_job(&self, id: &str, access: &Access) -> Result<Option<JobRow>, Error> {
        Ok(self.store().job(id).await?.filter(|job| access.sees(&job.robot)))
    }

    /// Ends a job: at once if it waits, within a second if it runs here, soon if it runs elsewhere, and not at all if it has
    /// ended.
    pub(super) async fn cancel_job(&self, job: &JobRow, access: &Access) -> Result<JobRow, Error> {
        if !job.state.is_final() {
            self.store().cancel(&job.id).await?;
            if let Some(flag) = self.running().get(&job.id) {
                CancelFlag::cancel(flag);
            }
            self.changed(&job.id);
            self.note(access, "cancel_job", &job.robot, &job.id).await?;
        }
        self.store().job(&job.id).await?.ok_or_else(internal_error)
    }

    /// Waits until the job has changed after `seen`, or `until`.
    pub(super) async fn next_change(&self, id: &str, seen: i64, until: Option<Instant>) -> Result<Option<JobRow>, Error> {
        // Listening before looking: a change in between is heard.
        let mut changes = self.changes().subscribe();
        loop {
            let job = self.store().job(id).await?;
            let closed = self.is_closing() && !self.running().contains_key(id);
            let over = closed || until.is_some_and(|until| Instant::now() >= until);
            if over || job.as_ref().is_none_or(|job| job.sequence > seen) {
                return Ok(job);
            }
            let look_again = Instant::now() + LOOK_AGAIN;
            let look_again = until.map_or(look_again, |until| until.min(look_again));
            let _ = tokio::time::timeout_at(look_again, changed(&mut changes, id)).await;
        }
    }

    /// The job when it has ended, or as it is after `limit`.
    pub(super) async fn wait(&self, job: JobRow, limit: Duration) -> Result<JobRow, Error> {
        let until = Instant::now() + limit;
        let mut job = job;
        // A server that ends answers with what there is, save for jobs that are just about to end with it.
        let goes_on = |id: &str| !self.is_closing() || self.running().contains_key(id);
        while !job.state.is_final() && Instant::now() < until && goes_on(&job.id) {
            let next = self.next_change(&job.id, job.sequence, Some(until)).await?;
            // A job that was forgotten meanwhile stays as it was last seen.
            let Some(next) = next else { break };
            job = next;
        }
        Ok(job)
    }
}

/// Resolves when the job has changed in this process, or when so much has changed that it may have.
async fn changed(changes: &mut broadcast::Receiver<std::sync::Arc<str>>, id: &str) {
    while let Ok(other) = changes.recv().await {
        if &*other == id {
            return;
        }
    }
}

/// A stored error, as it was reported.
pub(super) fn stored_error(error: &Error) -> serde_json::Value {
    let problems: Vec<_> = error
        .errors
        .iter()
        .map(|p| json!({"pointer": p.pointer, "detail": p.detail, "hint": p.hint}))
        .collect();
    json!({"code": error.code.name(), "detail": error.detail, "hint": error.hint, "errors": problems})
}

/// The error of a failed job.
pub(super) fn error_of(job: &JobRow) -> Option<Error> {
    job.error.as_ref().map(error_from)
}

/// An error as it was stored.
pub(super) fn error_from(stored: &serde_json::Value) -> Error {
    let text = |value: &serde_json::Value| value.as_str().map(str::to_string);
    let code = Code::ALL
        .into_iter()
        .find(|c| stored["code"] == c.name())
        .unwrap_or(Code::Internal);
    let problem = |p: &serde_json::Value| FieldProblem {
        pointer: text(&p["pointer"]).unwrap_or_default(),
        detail: text(&p["detail"]).unwrap_or_default(),
        hint: text(&p["hint"]),
    };
    Error {
        code,
        detail: text(&stored["detail"]).unwrap_or_default(),
        hint: text(&stored["hint"]),
        errors: stored["errors"]
            .as_array()
            .map(|all| all.iter().map(problem).collect())
            .unwrap_or_default(),
    }
}

/// Whether a job has a result to hand out.
pub(super) fn has_result(job: &JobRow) -> bool {
    matches!(job.state, State::Finished | State::Cancelled) && job.result.is_some()
}
