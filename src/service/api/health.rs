//! `/health` and `/metrics`: for whoever watches the process.

use crate::app::ProblemDetails;
use crate::app::{Code, Error};
use crate::service::access::Access;
use crate::service::problem::Failure;
use crate::service::state::Service;
use axum::Json;
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use serde::Serialize;

/// State of the server.
#[derive(Serialize, utoipa::ToSchema)]
pub struct Health {
    /// `ok` while the server answers.
    #[schema(example = "ok")]
    pub status: &'static str,
    /// Version of the program.
    pub version: &'static str,
}

const OK: Health = Health {
    status: "ok",
    version: env!("CARGO_PKG_VERSION"),
};

/// The process answers.
#[utoipa::path(get, path = "/health/live", tag = "health", operation_id = "live", responses((status = 200, body = Health)))]
pub async fn live() -> Json<Health> {
    Json(OK)
}

/// The process takes work: its database answers, and its disk takes files.
#[utoipa::path(
    get, path = "/health/ready", tag = "health", operation_id = "ready",
    responses(
        (status = 200, body = Health),
        (status = 503, description = "Shutting down, or database or disk fail", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn ready(State(service): State<Service>) -> Result<Json<Health>, Failure> {
    if service.is_closing() {
        return Err(Failure(Error::new(Code::ShuttingDown, "the server is shutting down")));
    }
    service.store().ping().await?;
    service.files().probe().await?;
    Ok(Json(OK))
}

/// Counters and gauges for Prometheus.
///
/// With tokens, one for all robots is needed.
#[utoipa::path(
    get, path = "/metrics", tag = "health", operation_id = "metrics",
    responses(
        (status = 200, description = "OpenMetrics text", body = String, content_type = "application/openmetrics-text"),
        (status = 403, description = "The token is not for all robots", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn metrics(State(service): State<Service>, access: Access) -> Result<Response, Failure> {
    if access.robots().is_some() {
        return Err(Failure(Error::new(Code::Forbidden, "this needs a token for all robots")));
    }
    let kind = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    let text = service.metrics().text(service.store()).await?;
    Ok(([(header::CONTENT_TYPE, kind)], text).into_response())
}
