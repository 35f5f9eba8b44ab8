//! `/identify` and `/validate`: from logs to a model, and a model against logs.

use super::jobs::JobDocument;
use super::query::QueryFields;
use super::schemas::{IdentifyUpload, ValidateUpload};
use crate::app::{Code, Error, Identified, Problem};
use crate::io::{IdentifyDocument, NamedExcitations, ValidateDocument, read_identify_request, read_validate_request};
use crate::service::jobs::Job;
use crate::service::prefer::PreferWait;
use crate::service::problem::{Failure, internal_error};
use crate::service::state::Service;
use crate::service::upload::Upload;
use crate::service::work::{Outcome, Work};
use crate::trajectory::Trajectory;
use axum::Json;
use axum::extract::multipart::MultipartRejection;
use axum::extract::{Multipart, Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use std::sync::Arc;

/// The result of an identification, under the id of its job.
#[derive(Serialize, utoipa::ToSchema)]
pub struct IdentificationResult {
    pub id: String,
    #[serde(flatten)]
    pub result: IdentifyDocument,
}

/// The result of a validation, under the id of its job.
#[derive(Serialize, utoipa::ToSchema)]
pub struct ValidationResult {
    pub id: String,
    #[serde(flatten)]
    pub result: ValidateDocument,
}

impl NamedExcitations for Service {
    fn excitation(&self, id: &str) -> Option<(f64, usize)> {
        let job = self.jobs().get(id)?;
        let series = job.excited()?.series.as_ref()?;
        Some((series.duration(), series.order()))
    }
}

/// Identify a robot from logs.
///
/// Logs are CSV files, plain or gzip. Answers 202 with the job, whose address is in `Location`; with `Prefer: wait=N` 200 and the
/// result if that comes within N seconds. A log that is too poor for the model is an outcome (`quality`), not an error.
#[utoipa::path(
    post, path = "/identify", tag = "identification", operation_id = "identify",
    request_body(content = IdentifyUpload, content_type = "multipart/form-data"),
    params(
        ("Prefer" = Option<String>, Header, description = "`wait=N`: hold the answer back up to N seconds for the result"),
        ("Idempotency-Key" = Option<String>, Header, description = "Any text; a retry with it finds the job that was begun"),
    ),
    responses(
        (status = 200, description = "The result, with `Prefer: wait`", body = IdentificationResult),
        (status = 202, description = "The job; its address is in `Location`", body = JobDocument,
            headers(("Location" = String, description = "Address of the job"))),
        (status = 400, description = "No multipart body with a JSON part", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "Logs too large", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Not multipart/form-data", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them; or a log that cannot be used", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "Too many jobs; see `Retry-After`", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn post(
    State(service): State<Service>,
    wait: PreferWait,
    headers: HeaderMap,
    body: Result<Multipart, MultipartRejection>,
) -> Result<Response, Failure> {
    let upload = Upload::read(body.map_err(not_multipart)?, true).await?;
    let Upload {
        request,
        files,
        fingerprint,
    } = upload;
    let reader = service.clone();
    let read = tokio::task::spawn_blocking(move || read_identify_request(&request, &reader, &reader)).await;
    let request = read
        .map_err(|_| internal_error())?
        .map_err(|e| Error::invalid("the identification request", e))?;
    submit(
        &service,
        Work::Identify(Box::new(request), files),
        &headers,
        &fingerprint,
        wait,
    )
    .await
}

/// Hold a model against logs.
///
/// The model is the JSON model of an identification, or any robot with parameters for every link.
#[utoipa::path(
    post, path = "/validate", tag = "identification", operation_id = "validate",
    request_body(content = ValidateUpload, content_type = "multipart/form-data"),
    params(
        ("Prefer" = Option<String>, Header, description = "`wait=N`: hold the answer back up to N seconds for the result"),
        ("Idempotency-Key" = Option<String>, Header, description = "Any text; a retry with it finds the job that was begun"),
    ),
    responses(
        (status = 200, description = "The result, with `Prefer: wait`", body = ValidationResult),
        (status = 202, description = "The job; its address is in `Location`", body = JobDocument,
            headers(("Location" = String, description = "Address of the job"))),
        (status = 400, description = "No multipart body with a JSON part", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "Logs too large", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Not multipart/form-data", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them; or a log that cannot be used", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "Too many jobs; see `Retry-After`", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn post_validation(
    State(service): State<Service>,
    wait: PreferWait,
    headers: HeaderMap,
    body: Result<Multipart, MultipartRejection>,
) -> Result<Response, Failure> {
    let Upload {
        request,
        files,
        fingerprint,
    } = Upload::read(body.map_err(not_multipart)?, false).await?;
    let reader = service.clone();
    let read = tokio::task::spawn_blocking(move || read_validate_request(&request, &reader, &reader)).await;
    let request = read
        .map_err(|_| internal_error())?
        .map_err(|e| Error::invalid("the validation request", e))?;
    submit(
        &service,
        Work::Validate(Box::new(request), files),
        &headers,
        &fingerprint,
        wait,
    )
    .await
}

pub(super) fn not_multipart(rejection: MultipartRejection) -> Failure {
    let error = Error::new(
        Code::UnsupportedMediaType,
        format!("the body is no multipart form: {}", rejection.body_text()),
    );
    Failure(error.with_hint("send `Content-Type: multipart/form-data` with a boundary"))
}

async fn submit(
    service: &Service,
    work: Work,
    headers: &HeaderMap,
    fingerprint: &[u8],
    wait: PreferWait,
) -> Result<Response, Failure> {
    let key = headers
        .get("idempotency-key")
        .and_then(|v| v.to_str().ok())
        .map(|k| (k.to_string(), fingerprint));
    let job = service.jobs().submit(work, key)?;
    Ok(answer(service, &job, wait).await)
}

async fn answer(service: &Service, job: &Arc<Job>, wait: PreferWait) -> Response {
    if let Some(limit) = wait.0 {
        let _ = tokio::time::timeout(limit.min(service.config().longest_wait), job.ended()).await;
    }
    let applied = wait.applied().map(|v| [("preference-applied", v)]);
    match ended(job) {
        Some(Ok(result)) => {
            let place = [(header::CONTENT_LOCATION, job.result_address())];
            (StatusCode::OK, applied, place, result).into_response()
        }
        Some(Err(failure)) => failure.into_response(),
        None => {
            let place = [
                (header::LOCATION, format!("/jobs/{}", job.id)),
                (header::RETRY_AFTER, "1".to_string()),
            ];
            (StatusCode::ACCEPTED, applied, place, Json(JobDocument::of(job))).into_response()
        }
    }
}

/// `None` while the job goes on.
fn ended(job: &Job) -> Option<Result<Response, Failure>> {
    let status = job.status();
    if !status.state.is_final() {
        return None;
    }
    let id = job.id.clone();
    Some(match (job.outcome(), status.error) {
        (Some(Outcome::Identified(found)), _) => Ok(Json(IdentificationResult {
            id,
            result: found.document.clone(),
        })
        .into_response()),
        (Some(Outcome::Validated(found)), _) => Ok(Json(ValidationResult {
            id,
            result: (**found).clone(),
        })
        .into_response()),
        (_, Some(error)) => Err(Failure(error)),
        _ => Err(Failure(Error::new(
            Code::NoResult,
            "the job was cancelled before it had a result",
        ))),
    })
}

pub(super) fn find(service: &Service, id: &str, kind: &str) -> Result<Arc<Job>, Failure> {
    let unknown =
        || Error::new(Code::UnknownIdentification, format!("there is no {kind} `{id}`")).with_hint("GET /jobs lists them");
    Ok(service.jobs().get(id).filter(|job| job.kind() == kind).ok_or_else(unknown)?)
}

/// The result of an identification.
///
/// While it goes on, 202 with the job; `Prefer: wait=N` waits for the result as in the POST.
#[utoipa::path(
    get, path = "/identify/{id}", tag = "identification", operation_id = "get_identification",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("Prefer" = Option<String>, Header, description = "`wait=N`: hold the answer back up to N seconds for the result"),
    ),
    responses(
        (status = 200, description = "The result", body = IdentificationResult),
        (status = 202, description = "The job, which goes on", body = JobDocument),
        (status = 404, description = "Unknown id", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "Cancelled before it had a result", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "A log that cannot be used", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn get(State(service): State<Service>, Path(id): Path<String>, wait: PreferWait) -> Result<Response, Failure> {
    let job = find(&service, &id, "identification")?;
    Ok(answer(&service, &job, wait).await)
}

/// The result of a validation.
#[utoipa::path(
    get, path = "/validate/{id}", tag = "identification", operation_id = "get_validation",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("Prefer" = Option<String>, Header, description = "`wait=N`: hold the answer back up to N seconds for the result"),
    ),
    responses(
        (status = 200, description = "The result", body = ValidationResult),
        (status = 202, description = "The job, which goes on", body = JobDocument),
        (status = 404, description = "Unknown id", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "Cancelled before it had a result", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "A log that cannot be used", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn get_validation(
    State(service): State<Service>,
    Path(id): Path<String>,
    wait: PreferWait,
) -> Result<Response, Failure> {
    let job = find(&service, &id, "validation")?;
    Ok(answer(&service, &job, wait).await)
}

/// The identified model as a file.
#[utoipa::path(
    get, path = "/identify/{id}/model", tag = "identification", operation_id = "get_model",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("format" = Option<String>, Query, description = "`json` (default; taken by POST /validate) or `urdf`"),
    ),
    responses(
        (status = 200, description = "The model", content((Object = "application/json"), (String = "application/xml"))),
        (status = 400, description = "Unknown format", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "Unknown id", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "No result yet, or no model that is a physical robot", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn model(State(service): State<Service>, Path(id): Path<String>, mut query: QueryFields) -> Result<Response, Failure> {
    let urdf = query.take("format", false, "json or urdf", |t| match t {
        "json" => Some(false),
        "urdf" => Some(true),
        _ => None,
    });
    query.finish()?;
    let job = find(&service, &id, "identification")?;
    let found: &Identified = match job.outcome() {
        Some(Outcome::Identified(found)) => found,
        _ => {
            return Err(ended(&job)
                .and_then(Result::err)
                .unwrap_or_else(|| Failure(Error::new(Code::NoModel, "the identification goes on"))));
        }
    };
    let files = found.model()?;
    let place = |extension: &str| {
        (
            header::CONTENT_DISPOSITION,
            format!("attachment; filename=\"model-{id}.{extension}\""),
        )
    };
    Ok(match urdf {
        true => (
            [place("urdf"), (header::CONTENT_TYPE, "application/xml".to_string())],
            files.urdf.clone(),
        )
            .into_response(),
        false => ([place("json")], Json(files.json.clone())).into_response(),
    })
}
