//! `/robot-archive`: a robot's file with its meshes as a robot document.

use super::results::computed;
use crate::app::ProblemDetails;
use crate::formats::RobotArchive;
use crate::service::access::Access;
use crate::service::child::{REQUEST, Task};
use crate::service::document::ArchiveBody;
use crate::service::problem::Failure;
use crate::service::state::Service;
use crate::service::store::Role;
use axum::extract::State;
use axum::response::Response;

/// The robot document of an archive.
///
/// A ZIP archive has one URDF or MJCF file and the meshes that it names (STL, OBJ, COLLADA). The answer has the text of the file
/// as `urdf` or `mjcf`, and `geometry` with capsules around the meshes of links that are described by meshes alone. At most 64
/// MiB; nothing is kept.
#[utoipa::path(
    post, path = "/robot-archive", tag = "robots", operation_id = "read_archive",
    request_body(content((Vec<u8> = "application/zip"))),
    responses(
        (status = 200, body = RobotArchive),
        (status = 400, description = "No ZIP archive of one robot", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 413, description = "Archive too large", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 415, description = "Not application/zip", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn post(State(service): State<Service>, access: Access, ArchiveBody(bytes): ArchiveBody) -> Result<Response, Failure> {
    access.require(Role::Run)?;
    let task = Task::RobotArchive { bytes: bytes.into() };
    Ok(computed(service.compute(task, REQUEST).await?))
}
