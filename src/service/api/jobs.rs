//! `/jobs`: where work stands, progress as it happens, cancelling.

use crate::app::Problem;
use crate::app::{Code, Error};
use crate::io::StartDocument;
use crate::service::jobs::{Job, State as JobState, Status};
use crate::service::problem::Failure;
use crate::service::state::Service;
use axum::Json;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::{Duration, SystemTime};
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

/// A job.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
#[schema(as = Job)]
pub struct JobDocument {
    pub id: String,
    /// `excitation`, `identification` or `validation`.
    #[schema(example = "excitation")]
    pub kind: &'static str,
    /// `queued`, `running`, `finished`, `cancelled` or `failed`.
    #[schema(example = "running")]
    pub state: &'static str,
    /// How the search ended, where there is a result: `Converged`, `BudgetExhausted`, `Stalled`, `Infeasible`, `Cancelled`.
    pub outcome: Option<&'static str>,
    pub cancel_requested: bool,
    /// RFC 3339, UTC.
    pub created_at: String,
    pub started_at: Option<String>,
    pub finished_at: Option<String>,
    pub progress: Option<ProgressDocument>,
    /// Of an identification.
    pub step: Option<StepDocument>,
    pub error: Option<Problem>,
    pub links: Links,
}

/// State of a running search.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
#[schema(as = Progress)]
pub struct ProgressDocument {
    /// Value of the criterion at the best trajectory so far; null before the first.
    #[schema(example = 63.1)]
    pub best: Option<f64>,
    pub starts_finished: usize,
    pub starts: usize,
    pub evaluations: u64,
    pub rounds_finished: usize,
    pub elapsed_s: f64,
    /// Random starts that have ended since the news before.
    pub ended: Vec<StartDocument>,
}

/// Where an identification stands.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
#[schema(as = Step)]
pub struct StepDocument {
    #[schema(example = "reading logs")]
    pub what: &'static str,
    pub done: usize,
    pub of: usize,
}

/// Addresses around a job.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
pub struct Links {
    #[serde(rename = "self")]
    pub this: String,
    pub events: String,
    pub result: String,
    /// Of an excitation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trajectory: Option<String>,
    /// Of an identification.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
}

/// A list of jobs, the newest first.
#[derive(Serialize, utoipa::ToSchema)]
pub struct JobList {
    pub jobs: Vec<JobDocument>,
}

impl JobDocument {
    pub fn of(job: &Job) -> Self {
        Self::at(job, &job.status())
    }

    fn at(job: &Job, status: &Status) -> Self {
        let id = &job.id;
        let elapsed = |since: SystemTime| {
            status
                .finished
                .unwrap_or_else(SystemTime::now)
                .duration_since(since)
                .unwrap_or_default()
        };
        Self {
            id: id.clone(),
            kind: job.kind(),
            state: status.state.name(),
            outcome: job.outcome().map(|o| o.status()),
            cancel_requested: job.cancel_requested(),
            created_at: rfc3339(job.created),
            started_at: status.started.map(rfc3339),
            finished_at: status.finished.map(rfc3339),
            progress: status.progress.as_ref().map(|p| ProgressDocument {
                best: p.best.is_finite().then_some(p.best),
                starts_finished: p.starts_finished,
                starts: p.starts,
                evaluations: p.evaluations,
                rounds_finished: p.rounds_finished,
                elapsed_s: status.started.map_or(0.0, |s| elapsed(s).as_secs_f64()),
                ended: p.start.iter().map(StartDocument::of).collect(),
            }),
            step: status.step.as_ref().map(|s| StepDocument {
                what: s.what,
                done: s.done,
                of: s.of,
            }),
            error: status.error.as_ref().map(Problem::from),
            links: Links {
                this: format!("/jobs/{id}"),
                events: format!("/jobs/{id}/events"),
                result: job.result_address(),
                trajectory: (job.kind() == "excitation").then(|| format!("/excitation/{id}/trajectory")),
                model: (job.kind() == "identification").then(|| format!("/identify/{id}/model")),
            },
        }
    }
}

fn rfc3339(time: SystemTime) -> String {
    humantime::format_rfc3339_millis(time).to_string()
}

fn find(service: &Service, id: &str) -> Result<Arc<Job>, Failure> {
    let unknown = || Error::new(Code::UnknownJob, format!("there is no job `{id}`")).with_hint("GET /jobs lists them");
    Ok(service.jobs().get(id).ok_or_else(unknown)?)
}

/// All jobs that are kept, the newest first.
#[utoipa::path(get, path = "/jobs", tag = "jobs", operation_id = "list_jobs", responses((status = 200, body = JobList)))]
pub async fn list(State(service): State<Service>) -> Json<JobList> {
    Json(JobList {
        jobs: service.jobs().list().iter().map(|job| JobDocument::of(job)).collect(),
    })
}

/// Where a job stands.
#[utoipa::path(
    get, path = "/jobs/{id}", tag = "jobs", operation_id = "get_job",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 200, body = JobDocument),
        (status = 404, description = "Unknown id", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn get(State(service): State<Service>, Path(id): Path<String>) -> Result<Json<JobDocument>, Failure> {
    Ok(Json(JobDocument::of(&*find(&service, &id)?)))
}

/// Cancel a job.
///
/// A running search ends within a second and keeps the best trajectory found: its result stays at `/excitation/{id}`. Cancelling a job
/// that has ended changes nothing.
#[utoipa::path(
    delete, path = "/jobs/{id}", tag = "jobs", operation_id = "cancel_job",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The job has ended", body = JobDocument),
        (status = 202, description = "The job will end within a second", body = JobDocument),
        (status = 404, description = "Unknown id", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn cancel(State(service): State<Service>, Path(id): Path<String>) -> Result<Response, Failure> {
    let job = find(&service, &id)?;
    if !job.status().state.is_final() {
        job.cancel();
    }
    let ended = job.status().state.is_final();
    let status = if ended { StatusCode::OK } else { StatusCode::ACCEPTED };
    Ok((status, Json(JobDocument::of(&job))).into_response())
}

/// Progress as server-sent events.
///
/// `progress` events while the job waits and runs, one `end` event with the final state, then the stream ends; the data of each is the
/// job. After a break, `Last-Event-ID` goes on from there; 204 when there is nothing more to come.
#[utoipa::path(
    get, path = "/jobs/{id}/events", tag = "jobs", operation_id = "follow_job",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("Last-Event-ID" = Option<String>, Header, description = "Id of the last event seen"),
    ),
    responses(
        (status = 200, description = "Events `progress` and `end`", body = JobDocument, content_type = "text/event-stream"),
        (status = 204, description = "The last event was seen already"),
        (status = 404, description = "Unknown id", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn events(State(service): State<Service>, Path(id): Path<String>, headers: HeaderMap) -> Result<Response, Failure> {
    let job = find(&service, &id)?;
    let seen = headers
        .get("last-event-id")
        .and_then(|v| v.to_str().ok())
        .and_then(|v| v.trim().parse().ok())
        .unwrap_or(0);
    let status = job.status();
    if status.state.is_final() && status.sequence <= seen {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let (sender, receiver) = mpsc::channel(1);
    tokio::spawn(tell(job, seen, sender));
    let keep_alive = KeepAlive::new().interval(Duration::from_secs(15));
    Ok(Sse::new(ReceiverStream::new(receiver)).keep_alive(keep_alive).into_response())
}

/// Sends every change that the client has time for: a slow client misses states in between, never the last one.
async fn tell(job: Arc<Job>, mut seen: u64, client: mpsc::Sender<Result<Event, Infallible>>) {
    let mut status = job.watch();
    loop {
        let now = match status.wait_for(|s| s.sequence > seen).await {
            Ok(now) => now.clone(),
            Err(_) => return,
        };
        seen = now.sequence;
        if client.send(Ok(event(&job, &now))).await.is_err() || now.state.is_final() {
            return;
        }
    }
}

fn event(job: &Job, status: &Status) -> Event {
    let name = if status.state.is_final() { "end" } else { "progress" };
    debug_assert!(status.state != JobState::Finished || job.outcome().is_some());
    let data = serde_json::to_string(&JobDocument::at(job, status)).unwrap_or_default();
    Event::default().event(name).id(status.sequence.to_string()).data(data)
}
