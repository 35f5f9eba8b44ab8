//! `/health`: for whoever watches the process.

use crate::app::Problem;
use crate::app::{Code, Error};
use crate::service::problem::Failure;
use crate::service::state::Service;
use axum::Json;
use axum::extract::State;
use serde::Serialize;

#[derive(Serialize, utoipa::ToSchema)]
pub struct Health {
    #[schema(example = "ok")]
    pub status: &'static str,
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

/// The process takes work.
#[utoipa::path(
    get, path = "/health/ready", tag = "health", operation_id = "ready",
    responses(
        (status = 200, body = Health),
        (status = 503, description = "Shutting down", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn ready(State(service): State<Service>) -> Result<Json<Health>, Failure> {
    if service.jobs().is_closing() {
        return Err(Failure(Error::new(Code::ShuttingDown, "the server is shutting down")));
    }
    Ok(Json(OK))
}
