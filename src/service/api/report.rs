//! `/identify/{id}/report`: an identification to print and to keep.

use super::jobs::JobDocument;
use super::results::{document, find};
use crate::app::{CancelFlag, Code, Error, ProblemDetails};
use crate::service::access::Access;
use crate::service::blocking::read_stored;
use crate::service::child::{REQUEST, Task};
use crate::service::problem::{Failure, internal_error};
use crate::service::state::Service;
use crate::service::store::JobRow;
use crate::service::work::JobKind;
use crate::web::REPORT_POLICY;
use axum::extract::{Path, State};
use axum::http::header;
use axum::response::{Html, IntoResponse};
use serde_json::Value;

/// The report of an identification.
///
/// One HTML file that stands alone and prints: parameters, errors, findings, pictures, and what is needed to do it again
/// (request, robot, version, logs by their SHA-256, the executed design with its seed).
#[utoipa::path(
    get, path = "/identify/{id}/report", tag = "identification", operation_id = "get_report",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The report", body = String, content_type = "text/html"),
        (status = 404, description = "Unknown id", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "No result yet", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 422, description = "A log that cannot be used", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn get(State(service): State<Service>, access: Access, Path(id): Path<String>) -> Result<impl IntoResponse, Failure> {
    let job = find(&service, &access, &id, JobKind::Identification).await?;
    if !job.state.is_final() {
        return Err(Failure(Error::new(Code::NoResult, "the identification goes on")));
    }
    let bytes = document(&service, &job).await?;
    let executed = move |_: &CancelFlag| {
        let result: Value = serde_json::from_slice(&bytes).map_err(|_| internal_error())?;
        Ok((result["provenance"]["request"]["excitation"].clone(), bytes))
    };
    let (executed, bytes) = service.blocking(executed).await?;
    let design = match &executed {
        Value::String(id) => match service.find_job(id, &access).await? {
            Some(job) => read(&service, &job).await.ok(),
            None => None,
        },
        Value::Object(_) => Some(executed),
        _ => None,
    };
    let task = Task::Report {
        result: bytes,
        id,
        ended: JobDocument::from_row(&job).finished_at,
        design,
    };
    let page = String::from_utf8(service.compute(task, REQUEST).await?).map_err(|_| internal_error())?;
    let policy = format!("{REPORT_POLICY}; frame-ancestors 'none'");
    Ok(([(header::CONTENT_SECURITY_POLICY, policy)], Html(page)))
}

/// The stored result of a job.
async fn read(service: &Service, job: &JobRow) -> Result<Value, Failure> {
    let bytes = document(service, job).await?;
    Ok(read_stored(bytes).await?)
}
