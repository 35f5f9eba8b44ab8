//! `/identify/{id}/report`: an identification to print and to keep.

use super::identify::find;
use crate::app::{Code, Error, Problem};
use crate::service::jobs::Job;
use crate::service::problem::{Failure, internal_error};
use crate::service::state::Service;
use crate::service::work::Outcome;
use crate::web::{Circumstances, report};
use axum::extract::{Path, State};
use axum::response::Html;
use serde_json::Value;

/// The report of an identification.
///
/// One HTML file that stands alone and prints: parameters, errors, findings, pictures, and what is needed to do it again (request,
/// robot, version, logs by their SHA-256, the executed design with its seed).
#[utoipa::path(
    get, path = "/identify/{id}/report", tag = "identification", operation_id = "get_report",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The report", body = String, content_type = "text/html"),
        (status = 404, description = "Unknown id", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "No result yet", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn get(State(service): State<Service>, Path(id): Path<String>) -> Result<Html<String>, Failure> {
    let job = find(&service, &id, "identification")?;
    let (result, ended) = result_of(&job)?;
    let executed = result["provenance"]["request"]["excitation"].clone();
    let design = match &executed {
        Value::String(id) => service
            .jobs()
            .get(id)
            .and_then(|job| serde_json::to_value(&job.excited()?.document).ok()),
        Value::Object(_) => Some(executed),
        _ => None,
    };
    let circumstances = Circumstances {
        id: Some(id),
        ended,
        design,
    };
    let page = tokio::task::spawn_blocking(move || report(&result, &circumstances)).await;
    Ok(Html(page.map_err(|_| internal_error())?))
}

/// The result as a document, and when it came.
fn result_of(job: &Job) -> Result<(Value, Option<String>), Failure> {
    let status = job.status();
    let Some(Outcome::Identified(found)) = job.outcome() else {
        let none = || Error::new(Code::NoResult, "the identification has no result to report");
        return Err(Failure(status.error.unwrap_or_else(none)));
    };
    let document = serde_json::to_value(&found.document).map_err(|_| internal_error())?;
    let ended = status.finished.map(|t| humantime::format_rfc3339_seconds(t).to_string());
    Ok((document, ended))
}
