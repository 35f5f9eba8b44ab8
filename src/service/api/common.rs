//! Headers and answers that several addresses share, documented once. The headers are read by `service/prefer.rs` and
//! `service/submit.rs`.
// Nobody makes these: they are what the documentation is made from.
#![allow(dead_code, clippy::large_enum_variant)]

use super::jobs::JobDocument;
use crate::app::ProblemDetails;
use utoipa::{IntoParams, IntoResponses};

/// Of requests that wait for a result.
#[derive(IntoParams)]
#[into_params(parameter_in = Header)]
pub struct WaitHeader {
    /// `wait=N`: hold the answer back up to N seconds for the result
    #[param(rename = "Prefer")]
    prefer: Option<String>,
}

/// Of requests that begin work.
#[derive(IntoParams)]
#[into_params(parameter_in = Header)]
pub struct WorkHeaders {
    /// `wait=N`: hold the answer back up to N seconds for the result
    #[param(rename = "Prefer")]
    prefer: Option<String>,
    /// Any text; a retry with it finds the job that was begun
    #[param(rename = "Idempotency-Key")]
    idempotency_key: Option<String>,
    /// RFC 9218: `u=0` (urgent) to `u=7`, `u=3` if left out
    #[param(rename = "Priority")]
    priority: Option<String>,
    /// `no-cache`: do it again, even if the same was done before
    #[param(rename = "Cache-Control")]
    cache_control: Option<String>,
}

/// What becomes of a request that begins work, beside its result.
#[derive(IntoResponses)]
pub enum Begun {
    /// The job; its address is in `Location`
    #[response(status = 202, headers(("Location" = String, description = "Address of the job")))]
    Job(JobDocument),
    /// Cancelled before it had a result
    #[response(status = 409, content_type = "application/problem+json")]
    Cancelled(ProblemDetails),
    /// Too many jobs; see `Retry-After`
    #[response(status = 503, content_type = "application/problem+json")]
    TooMany(ProblemDetails),
}

/// What may be wrong with logs that are sent.
#[derive(IntoResponses)]
pub enum UploadRefused {
    /// No multipart body with a JSON part
    #[response(status = 400, content_type = "application/problem+json")]
    Malformed(ProblemDetails),
    /// Logs too large
    #[response(status = 413, content_type = "application/problem+json")]
    TooLarge(ProblemDetails),
    /// Not multipart/form-data
    #[response(status = 415, content_type = "application/problem+json")]
    NoForm(ProblemDetails),
    /// Bad fields, all of them; or a log that cannot be used
    #[response(status = 422, content_type = "application/problem+json")]
    Invalid(ProblemDetails),
}

/// What is answered in place of a result of logs.
#[derive(IntoResponses)]
pub enum NoResultOfLogs {
    /// The job, which goes on
    #[response(status = 202)]
    GoesOn(JobDocument),
    /// Unknown id
    #[response(status = 404, content_type = "application/problem+json")]
    Unknown(ProblemDetails),
    /// Cancelled before it had a result
    #[response(status = 409, content_type = "application/problem+json")]
    Cancelled(ProblemDetails),
    /// A log that cannot be used
    #[response(status = 422, content_type = "application/problem+json")]
    Unusable(ProblemDetails),
}
