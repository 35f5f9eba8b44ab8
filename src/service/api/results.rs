//! What all routes that begin work and hand out its results have in common.

use super::jobs::JobDocument;
use crate::app::{Code, Error};
use crate::service::access::Access;
use crate::service::blocking::sized;
use crate::service::prefer::PreferWait;
use crate::service::problem::Failure;
use crate::service::state::Service;
use crate::service::store::JobRow;
use crate::service::submit::{Asked, Wishes, error_of, has_result};
use crate::service::work::JobKind;
use axum::Json;
use axum::extract::multipart::MultipartRejection;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::Value;

/// Begins the work, and answers with its result if that comes in the time the client would wait, else with the job.
pub async fn begin(
    service: &Service,
    access: &Access,
    headers: &HeaderMap,
    wait: PreferWait,
    asked: Asked,
) -> Result<Response, Failure> {
    let job = service.submit(asked, Wishes::read(headers), access).await?;
    answer(service, job, wait).await
}

/// The result if it is there or comes in the time the client would wait, else the job.
pub async fn answer(service: &Service, job: JobRow, wait: PreferWait) -> Result<Response, Failure> {
    answer_as(service, job, wait, AnswerForm::Whole).await
}

/// In which form a document goes out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnswerForm {
    /// The document as it is stored.
    Whole,
    /// Without the series to draw: a hundredth of its size.
    WithoutPredictions,
}

impl AnswerForm {
    fn of(self, whole: Vec<u8>) -> Vec<u8> {
        if self == Self::Whole {
            return whole;
        }
        let Ok(Value::Object(mut fields)) = serde_json::from_slice(&whole) else {
            return whole;
        };
        fields.insert("predictions".into(), Value::Array(Vec::new()));
        Value::Object(fields).to_string().into_bytes()
    }
}

/// [`answer`], with the document put into another form on its way out.
pub async fn answer_as(service: &Service, job: JobRow, wait: PreferWait, form: AnswerForm) -> Result<Response, Failure> {
    let job = match wait.0 {
        Some(limit) => service.wait(job, limit.min(service.config().longest_wait)).await?,
        None => job,
    };
    let applied = wait.applied().map(|v| [("preference-applied", v)]);
    if job.state.is_final() {
        let place = [
            (header::CONTENT_LOCATION, job.kind.result_address(&job.id)),
            (header::CONTENT_TYPE, "application/json".to_string()),
        ];
        let document = document(service, &job).await?;
        let document = sized(document.len(), move || with_id(&job.id, &form.of(document))).await?;
        return Ok((StatusCode::OK, applied, place, document).into_response());
    }
    let place = [
        (header::LOCATION, format!("/jobs/{}", job.id)),
        (header::RETRY_AFTER, "1".to_string()),
    ];
    Ok((StatusCode::ACCEPTED, applied, place, Json(JobDocument::from_row(&job))).into_response())
}

/// The document of a job that has ended.
///
/// # Errors
/// That of the job; `no_result` where it was cancelled before it had one.
pub async fn document(service: &Service, job: &JobRow) -> Result<Vec<u8>, Failure> {
    if let Some(hash) = job.result.as_ref().filter(|_| has_result(job)) {
        return Ok(service.files().read(hash).await?);
    }
    let none = || Error::new(Code::NoResult, "the job was cancelled before it had a result");
    Err(Failure(error_of(job).unwrap_or_else(none)))
}

/// A JSON document that a child has made.
pub fn computed(document: Vec<u8>) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], document).into_response()
}

/// A stored JSON object with `id` as its first field.
fn with_id(id: &str, object: &[u8]) -> Vec<u8> {
    let id = format!("{{\"id\":\"{id}\",");
    [id.as_bytes(), object.get(1..).unwrap_or_default()].concat()
}

/// A job of one kind that `access` sees.
pub async fn find(service: &Service, access: &Access, id: &str, kind: JobKind) -> Result<JobRow, Failure> {
    let unknown = || Error::new(kind.unknown(), format!("there is no {} `{id}`", kind.name())).with_hint("GET /jobs lists them");
    let job = service.find_job(id, access).await?;
    Ok(job.filter(|job| job.kind == kind).ok_or_else(unknown)?)
}

/// The error for a body that is no multipart form.
pub fn not_multipart(rejection: MultipartRejection) -> Failure {
    let error = Error::new(
        Code::UnsupportedMediaType,
        format!("the body is no multipart form: {}", rejection.body_text()),
    );
    Failure(error.with_hint("send `Content-Type: multipart/form-data` with a boundary"))
}

#[cfg(test)]
mod tests {
    use super::with_id;

    #[test]
    fn the_id_comes_first() {
        assert_eq!(with_id("x", b"{\"a\":1}"), b"{\"id\":\"x\",\"a\":1}");
    }
}
