//! `/motion`: what a robot looks like, and what a motion asks of it.

use super::results::computed;
use crate::app::ProblemDetails;
use crate::documents::{MotionDocument, requests};
use crate::service::access::Access;
use crate::service::child::{REQUEST, Task};
use crate::service::document::JsonBody;
use crate::service::known::Known;
use crate::service::problem::Failure;
use crate::service::state::Service;
use axum::extract::State;
use axum::response::Response;

/// What a robot looks like, and what a motion asks of it.
///
/// The frames of its joints with their limits; with `trajectory` one period of it: q, qd, qdd, the path of the last frame, and
/// the torques to be expected where the robot has prior link parameters.
#[utoipa::path(
    post, path = "/motion", tag = "robots", operation_id = "draw_motion",
    request_body(content = requests::MotionRequest, content_type = "application/json"),
    responses(
        (status = 200, body = MotionDocument),
        (status = 400, description = "No JSON document", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 413, description = "Document too large", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 415, description = "Not application/json", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn post(State(service): State<Service>, access: Access, body: JsonBody) -> Result<Response, Failure> {
    let known = Known::for_request(&body.parsed.value, &service, &access).await?;
    let task = Task::Motion {
        document: body.parsed.into(),
        known: known.into(),
    };
    Ok(computed(service.compute(task, REQUEST).await?))
}
