//! `/identify/{id}/report`: an identification to print and to keep.

use super::results::{document, find};
use crate::app::Problem;
use crate::service::access::Access;
use crate::service::problem::{Failure, internal_error};
use crate::service::state::Service;
use crate::service::work::Kind;
use crate::web::{Circumstances, report};
use axum::extract::{Path, State};
use axum::response::Html;
use serde_json::Value;
use std::time::{Duration, SystemTime};

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
pub async fn get(State(service): State<Service>, access: Access, Path(id): Path<String>) -> Result<Html<String>, Failure> {
    let job = find(&service, &access, &id, Kind::Identification).await?;
    let result = value(&document(&service, &job).await?)?;
    let executed = result["provenance"]["request"]["excitation"].clone();
    let design = match &executed {
        Value::String(id) => design_of(&service, &access, id).await,
        Value::Object(_) => Some(executed),
        _ => None,
    };
    let ended = |us: i64| SystemTime::UNIX_EPOCH + Duration::from_micros(us.max(0) as u64);
    let circumstances = Circumstances {
        id: Some(id),
        ended: job
            .finished_us
            .map(|us| humantime::format_rfc3339_seconds(ended(us)).to_string()),
        design,
    };
    let page = tokio::task::spawn_blocking(move || report(&result, &circumstances)).await;
    Ok(Html(page.map_err(|_| internal_error())?))
}

/// The design that was executed, where it is still kept and whoever asks may see it.
async fn design_of(service: &Service, access: &Access, id: &str) -> Option<Value> {
    let job = find(service, access, id, Kind::Excitation).await.ok()?;
    value(&document(service, &job).await.ok()?).ok()
}

fn value(document: &[u8]) -> Result<Value, Failure> {
    Ok(serde_json::from_slice(document).map_err(|_| internal_error())?)
}
