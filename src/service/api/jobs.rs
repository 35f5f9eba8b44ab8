//! `/jobs`: where work stands, progress as it happens, cancelling.

use super::query::QueryFields;
use crate::app::ProblemDetails;
use crate::app::{Code, Error};
use crate::formats::Parsed;
use crate::model::FieldProblem;
use crate::service::access::Access;
use crate::service::document::JsonBody;
use crate::service::problem::Failure;
use crate::service::progress::{ProgressDocument, StepDocument};
use crate::service::state::Service;
use crate::service::store::{JobFilter, JobPlace, JobRow, Role, State as JobState, rfc3339};
use crate::service::submit::error_of;
use crate::service::work::JobKind;
use axum::Json;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};
use serde::Serialize;
use serde_json::Value;
use std::convert::Infallible;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

/// A job.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
#[schema(as = Job)]
pub struct JobDocument {
    /// ID of the job, in every address about it.
    pub id: String,
    /// `excitation`, `identification` or `validation`.
    #[schema(example = "excitation")]
    pub kind: &'static str,
    /// The robot that it is for, and whose tokens see it.
    #[schema(example = "iiwa14")]
    pub robot: String,
    /// `queued`, `running`, `finished`, `cancelled` or `failed`.
    #[schema(example = "running")]
    pub state: &'static str,
    /// How the search ended, where there is a result: `Converged`, `BudgetExhausted`, `Stalled`, `Infeasible`, `Cancelled`.
    pub outcome: Option<String>,
    /// Whether a cancellation was requested; the job ends soon after.
    pub cancel_requested: bool,
    /// What people call it, as `PATCH /jobs/{id}` says.
    pub name: Option<String>,
    /// Free text about the job; null if there is none.
    pub note: Option<String>,
    /// Name of the token that asked for it.
    pub owner: Option<String>,
    /// Names of the log files that came with it: those to identify from, then those to validate with.
    pub logs: Vec<String>,
    /// RFC 3339, UTC.
    pub created_at: String,
    /// When a worker first began it (RFC 3339, UTC); null while it is queued.
    pub started_at: Option<String>,
    /// When it ended (RFC 3339, UTC); null until then.
    pub finished_at: Option<String>,
    /// News of a running search; null before the first and for other jobs.
    #[schema(value_type = Option<ProgressDocument>)]
    pub progress: Option<Value>,
    /// Of an identification.
    #[schema(value_type = Option<StepDocument>)]
    pub step: Option<Value>,
    /// Why the job failed; null unless it did.
    pub error: Option<ProblemDetails>,
    /// Addresses around the job.
    pub links: Links,
}

/// Addresses around a job.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
pub struct Links {
    /// The job.
    #[serde(rename = "self")]
    pub this: String,
    /// Its stream of server-sent events.
    pub events: String,
    /// Its result, once it is finished.
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
    /// The jobs of this page, newest first.
    pub jobs: Vec<JobDocument>,
    /// Address of the older ones, where there may be any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next: Option<String>,
}

impl JobDocument {
    /// The document for a row of the database.
    pub fn from_row(job: &JobRow) -> Self {
        let id = &job.id;
        Self {
            id: id.clone(),
            kind: job.kind.name(),
            robot: job.robot.clone(),
            state: job.state.name(),
            // A result that is stored before its predictions are made is not handed out yet.
            outcome: job.outcome.clone().filter(|_| job.state.is_final()),
            cancel_requested: job.cancel_requested,
            name: job.name.clone(),
            note: job.note.clone(),
            owner: job.owner.clone(),
            logs: job.logs.clone(),
            created_at: rfc3339(job.created_us),
            started_at: job.started_us.map(rfc3339),
            finished_at: job.finished_us.map(rfc3339),
            progress: job.progress.clone(),
            step: job.step.clone(),
            error: error_of(job).as_ref().map(ProblemDetails::from),
            links: Links {
                this: format!("/jobs/{id}"),
                events: format!("/jobs/{id}/events"),
                result: job.kind.result_address(id),
                trajectory: (job.kind == JobKind::Excitation).then(|| format!("/excitation/{id}/trajectory")),
                model: (job.kind == JobKind::Identification).then(|| format!("/identify/{id}/model")),
            },
        }
    }
}

/// One server-sent event.
#[derive(utoipa::ToSchema)]
#[allow(dead_code)] // for the documentation: events are written field by field
pub struct JobEvent {
    /// `progress`, or `end` with the last.
    #[schema(example = "progress")]
    event: String,
    /// Grows from event to event: to be sent as `Last-Event-ID` after a break.
    #[schema(example = "7")]
    id: String,
    /// The job, as JSON text.
    data: String,
}

async fn find(service: &Service, access: &Access, id: &str) -> Result<JobRow, Failure> {
    let unknown = || Error::new(Code::UnknownJob, format!("there is no job `{id}`")).with_hint("GET /jobs lists them");
    Ok(service.find_job(id, access).await?.ok_or_else(unknown)?)
}

/// Jobs in one answer, unless the request says otherwise.
const LISTED: usize = 200;

/// All jobs that are kept, the newest first.
#[utoipa::path(
    get, path = "/jobs", tag = "jobs", operation_id = "list_jobs",
    params(
        ("limit" = Option<u32>, Query, description = "At most so many, 200 if left out", minimum = 1, maximum = 1000),
        ("before" = Option<String>, Query, description = "As in `next` of the answer before: microseconds since 1970 and the id of a job, behind \
            which the list goes on; without an id, only what is older", pattern = "^[0-9]{1,18}([.][0-9A-Za-z-]{0,64})?$"),
        ("robot" = Option<String>, Query, description = "Only jobs of this robot", max_length = 64),
        ("kind" = Option<String>, Query, description = "`excitation`, `identification` or `validation`", pattern = "^(excitation|identification|validation)$"),
        ("state" = Option<String>, Query, description = "`queued`, `running`, `finished`, `cancelled` or `failed`",
            pattern = "^(queued|running|finished|cancelled|failed)$"),
        ("search" = Option<String>, Query, description = "Part of the name, the note, the robot, the id or the name of a log, in whatever case", max_length = 200),
    ),
    responses(
        (status = 200, body = JobList),
        (status = 400, description = "Bad query", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn list(State(service): State<Service>, access: Access, mut query: QueryFields) -> Result<Json<JobList>, Failure> {
    let most = query.take("limit", LISTED, "a whole number from 1 to 1000", |t| {
        t.parse().ok().filter(|n| (1..=1000).contains(n))
    });
    let expected = "a time in microseconds, or `TIME.ID` as in `next` of the answer before";
    let before = query.take("before", JobPlace::first(), expected, JobPlace::read);
    let text = |most: usize| move |t: &str| (t.chars().count() <= most && !t.contains('\0')).then(|| Some(t.to_string()));
    let filter = JobFilter {
        robot: query.take("robot", None, "the id of a robot", text(64)),
        kind: query.take("kind", None, "excitation, identification or validation", |t| {
            JobKind::named(t).map(Some)
        }),
        state: query.take("state", None, "queued, running, finished, cancelled or failed", |t| {
            JobState::ALL.into_iter().find(|s| s.name() == t).map(Some)
        }),
        search: query.take("search", None, "a text of at most 200 characters", text(200)),
    };
    query.finish()?;
    let jobs = service.store().jobs(access.robots(), &filter, &before, most).await?;
    let last = jobs.last().filter(|_| jobs.len() == most);
    Ok(Json(JobList {
        next: last.map(|job| format!("/jobs?limit={most}&before={}{}", JobPlace::behind(job), continued(&filter))),
        jobs: jobs.iter().map(JobDocument::from_row).collect(),
    }))
}

/// The conditions of a list, for the address of its next part.
fn continued(filter: &JobFilter) -> String {
    let parts = [
        ("robot", filter.robot.as_deref()),
        ("kind", filter.kind.map(JobKind::name)),
        ("state", filter.state.map(JobState::name)),
        ("search", filter.search.as_deref()),
    ];
    let given = parts.into_iter().filter_map(|(name, value)| Some((name, value?)));
    given
        .map(|(name, value)| format!("&{name}={}", utf8_percent_encode(value, NON_ALPHANUMERIC)))
        .collect()
}

/// What is said about a job; what is left out stays, null takes away.
#[derive(Serialize, utoipa::ToSchema)]
#[schema(as = JobDescription)]
#[allow(dead_code)] // for the documentation: the fields are read one by one
pub struct DescriptionSchema {
    #[schema(required = false, max_length = 200)]
    name: Option<String>,
    #[schema(required = false, max_length = 10000)]
    note: Option<String>,
}

/// Name a job, and write about it.
#[utoipa::path(
    patch, path = "/jobs/{id}", tag = "jobs", operation_id = "describe_job",
    params(("id" = String, Path, description = "Id of the job")),
    request_body(content = DescriptionSchema, content_type = "application/json"),
    responses(
        (status = 200, body = JobDocument),
        (status = 400, description = "No JSON document", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 404, description = "Unknown id", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 413, description = "Document too large", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 415, description = "Not application/json", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn describe(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
    body: JsonBody,
) -> Result<Json<JobDocument>, Failure> {
    let job = find(&service, &access, &id).await?;
    access.require(Role::Run)?;
    let (name, note) = read_description(&body.parsed)?;
    service.store().describe_job(&id, name.as_deref(), note.as_deref()).await?;
    service.note(&access, "describe_job", &job.robot, &id).await?;
    Ok(Json(JobDocument::from_row(&find(&service, &access, &id).await?)))
}

/// Name and note; an empty text takes away, `None` leaves what there is.
fn read_description(parsed: &Parsed) -> Result<(Option<String>, Option<String>), Error> {
    let mut problems = parsed.problems.clone();
    let Some(fields) = parsed.value.as_object() else {
        problems.push(FieldProblem::new("", "is not an object with `name` and `note`"));
        return Err(Error::invalid("the description", problems));
    };
    let mut text = |field: &str, most: usize| match fields.get(field) {
        None => None,
        Some(Value::Null) => Some(String::new()),
        Some(Value::String(t)) if t.chars().count() <= most && !t.contains('\0') => Some(t.trim().to_string()),
        Some(_) => {
            problems.push(FieldProblem::new(
                format!("/{field}"),
                format!("is not a text of at most {most} characters"),
            ));
            None
        }
    };
    let read = (text("name", 200), text("note", 10_000));
    let unknown = fields.keys().filter(|k| !["name", "note"].contains(&k.as_str()));
    problems.extend(unknown.map(|k| {
        FieldProblem::new(
            format!("/{}", k.replace('~', "~0").replace('/', "~1")),
            "is not a field of it",
        )
        .with_hint("`name` and `note` are")
    }));
    match problems.is_empty() {
        true => Ok(read),
        false => Err(Error::invalid("the description", problems)),
    }
}

/// Where a job stands.
#[utoipa::path(
    get, path = "/jobs/{id}", tag = "jobs", operation_id = "get_job",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 200, body = JobDocument),
        (status = 404, description = "Unknown id", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn get(State(service): State<Service>, access: Access, Path(id): Path<String>) -> Result<Json<JobDocument>, Failure> {
    Ok(Json(JobDocument::from_row(&find(&service, &access, &id).await?)))
}

/// Cancel a job.
///
/// A running search ends within a second and keeps the best trajectory found: its result stays at `/excitation/{id}`. Cancelling
/// a job that has ended changes nothing, unless `forget=true` says that it shall go with its result.
#[utoipa::path(
    delete, path = "/jobs/{id}", tag = "jobs", operation_id = "cancel_job",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("forget" = Option<bool>, Query, description = "`true`: remove an ended job with its result"),
    ),
    responses(
        (status = 204, description = "Forgotten"),
        (status = 400, description = "Bad query", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "To be forgotten, and still waiting or running", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 200, description = "The job has ended", body = JobDocument),
        (status = 202, description = "The job will end within a second", body = JobDocument),
        (status = 404, description = "Unknown id", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn cancel(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
    mut query: QueryFields,
) -> Result<Response, Failure> {
    let forget = query.take("forget", false, "true or false", |t| t.parse().ok());
    query.finish()?;
    let job = find(&service, &access, &id).await?;
    access.require(Role::Run)?;
    if forget {
        if !service.store().forget_job(&id).await? {
            let running = Error::new(Code::NoResult, "the job waits or runs");
            return Err(Failure(running.with_hint("cancel it first: DELETE without `forget`")));
        }
        service.note(&access, "forget_job", &job.robot, &id).await?;
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let job = service.cancel_job(&job, &access).await?;
    let status = match job.state.is_final() {
        true => StatusCode::OK,
        false => StatusCode::ACCEPTED,
    };
    Ok((status, Json(JobDocument::from_row(&job))).into_response())
}

/// Progress as server-sent events.
///
/// `progress` events while the job waits and runs, one `end` event with the final state, then the stream ends; the data of each
/// is the job. After a break, `Last-Event-ID` continues from there, also with another server of the same database; 204 when there
/// is nothing more to come.
#[utoipa::path(
    get, path = "/jobs/{id}/events", tag = "jobs", operation_id = "follow_job",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("Last-Event-ID" = Option<String>, Header, description = "Id of the last event seen"),
    ),
    responses(
        (status = 200, description = "Events, each of this form", body = JobEvent, content_type = "text/event-stream"),
        (status = 204, description = "The last event was seen already"),
        (status = 404, description = "Unknown id", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn events(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Result<Response, Failure> {
    let job = find(&service, &access, &id).await?;
    let seen = headers
        .get("last-event-id")
        .and_then(|v| v.to_str().ok())
        .and_then(|v| v.trim().parse().ok())
        .unwrap_or(0);
    if job.state.is_final() && job.sequence <= seen {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let (sender, receiver) = mpsc::channel(1);
    tokio::spawn(tell(service, job.id, seen, sender));
    let keep_alive = KeepAlive::new().interval(Duration::from_secs(15));
    Ok(Sse::new(ReceiverStream::new(receiver)).keep_alive(keep_alive).into_response())
}

/// Sends every change that the client has time for: a slow client misses states in between, never the last one.
async fn tell(service: Service, id: String, mut seen: i64, client: mpsc::Sender<Result<Event, Infallible>>) {
    loop {
        let job = tokio::select! {
            job = service.next_change(&id, seen, None) => job,
            () = client.closed() => return,
        };
        // The client comes back by itself, with the last event it saw, when the database or another server does.
        let Ok(Some(job)) = job else { return };
        if job.sequence > seen && client.send(Ok(event(&job))).await.is_err() {
            return;
        }
        if job.sequence <= seen || job.state.is_final() {
            return;
        }
        seen = job.sequence;
    }
}

fn event(job: &JobRow) -> Event {
    let name = if job.state.is_final() { "end" } else { "progress" };
    let data = serde_json::to_string(&JobDocument::from_row(job)).unwrap_or_default();
    Event::default().event(name).id(job.sequence.to_string()).data(data)
}
