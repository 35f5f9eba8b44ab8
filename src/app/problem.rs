//! Errors as RFC 9457 problem documents, the same from the service and the command line.

use super::error::Error;
use crate::model::FieldProblem;
use serde::Serialize;

/// An error (RFC 9457, `application/problem+json`).
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Problem))]
pub struct ProblemDetails {
    /// `urn:dynident:error:` and the code.
    #[serde(rename = "type")]
    pub kind: String,
    /// Title of the error code, the same for every error of the code.
    pub title: &'static str,
    /// HTTP status.
    pub status: u16,
    /// Stable name of the error, the same as on the command line.
    #[cfg_attr(feature = "service", schema(example = "invalid_document"))]
    pub code: &'static str,
    /// What happened.
    pub detail: String,
    /// What to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
    /// Every bad field.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<FieldError>,
}

/// One bad field.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct FieldError {
    /// JSON pointer into the document that was sent; `/query/…` for the query string.
    #[cfg_attr(feature = "service", schema(example = "/robot/joints/0/limits/position"))]
    pub pointer: String,
    /// What is wrong.
    pub detail: String,
    /// What to do about it, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
}

impl From<&Error> for ProblemDetails {
    fn from(error: &Error) -> Self {
        Self {
            kind: format!("urn:dynident:error:{}", error.code.name()),
            title: error.code.title(),
            status: error.code.http_status(),
            code: error.code.name(),
            detail: error.detail.clone(),
            hint: error.hint.clone(),
            errors: error.errors.iter().map(FieldError::from).collect(),
        }
    }
}

impl From<&FieldProblem> for FieldError {
    fn from(p: &FieldProblem) -> Self {
        Self {
            pointer: p.pointer.clone(),
            detail: p.detail.clone(),
            hint: p.hint.clone(),
        }
    }
}
