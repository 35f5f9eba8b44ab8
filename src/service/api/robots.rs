//! `/robots`: those that come with the program and those of the lab.

use super::schemas::RobotSchema;
use crate::app::Error;
use crate::app::Problem;
use crate::io::{BaseParametersDocument, Parsed, RobotDocument, robot_document};
use crate::model::FieldProblem;
use crate::service::document::RobotBody;
use crate::service::problem::{Failure, internal_error};
use crate::service::state::{LabRobot, ListedRobot, Service};
use axum::Json;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::Value;

/// A robot in short.
#[derive(Serialize, utoipa::ToSchema)]
pub struct RobotSummary {
    /// What requests call it.
    #[schema(example = "iiwa14")]
    pub id: String,
    pub name: String,
    pub joints: Vec<String>,
    /// Comes with the program and cannot be changed.
    pub shipped: bool,
    /// What to know about how it was read.
    pub notes: Vec<String>,
}

#[derive(Serialize, utoipa::ToSchema)]
pub struct RobotList {
    pub robots: Vec<RobotSummary>,
}

impl RobotSummary {
    fn of(robot: &ListedRobot) -> Self {
        let joints = robot.read.robot.joints();
        Self {
            id: robot.id.clone(),
            name: robot.read.robot.name().to_string(),
            joints: joints.iter().map(|j| j.name.clone()).collect(),
            shipped: robot.shipped,
            notes: robot.read.notes.clone(),
        }
    }
}

/// All robots.
#[utoipa::path(get, path = "/robots", tag = "robots", operation_id = "list_robots", responses((status = 200, body = RobotList)))]
pub async fn list(State(service): State<Service>) -> Json<RobotList> {
    Json(RobotList {
        robots: service.list_robots().iter().map(RobotSummary::of).collect(),
    })
}

/// The document of a robot, as it was given.
#[utoipa::path(
    get, path = "/robots/{id}", tag = "robots", operation_id = "get_robot",
    params(("id" = String, Path, description = "Name of the robot", example = "iiwa14")),
    responses(
        (status = 200, body = RobotSchema),
        (status = 404, description = "Unknown robot", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn get(State(service): State<Service>, Path(id): Path<String>) -> Result<Json<Value>, Failure> {
    Ok(Json(service.robot(&id)?.document))
}

/// Names, expressions and numeric map of the base parameters.
#[utoipa::path(
    get, path = "/robots/{id}/base-parameters", tag = "robots", operation_id = "get_base_parameters",
    params(("id" = String, Path, description = "Name of the robot", example = "iiwa14")),
    responses(
        (status = 200, body = BaseParametersDocument),
        (status = 404, description = "Unknown robot", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn base_parameters(
    State(service): State<Service>,
    Path(id): Path<String>,
) -> Result<Json<BaseParametersDocument>, Failure> {
    let robot = service.robot(&id)?.read.robot;
    let computed = tokio::task::spawn_blocking(move || BaseParametersDocument::of(&robot)).await;
    Ok(Json(computed.map_err(|_| internal_error())?))
}

async fn read(parsed: Parsed) -> Result<LabRobot, Failure> {
    let document = parsed.value.clone();
    let read = tokio::task::spawn_blocking(move || robot_document(&parsed))
        .await
        .map_err(|_| internal_error())?;
    let read = read.map_err(|errors| Error::invalid("the robot", errors))?;
    Ok(LabRobot { document, read })
}

/// Keep a robot of the lab; its id is made from its name.
#[utoipa::path(
    post, path = "/robots", tag = "robots", operation_id = "add_robot",
    request_body(content((RobotSchema = "application/json"), (String = "application/xml"))),
    responses(
        (status = 201, description = "Kept; its address is in `Location`", body = RobotSummary,
            headers(("Location" = String, description = "Address of the robot"))),
        (status = 400, description = "Neither JSON nor XML", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "A robot of that name exists", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Wrong type", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn post(State(service): State<Service>, RobotBody(parsed): RobotBody) -> Result<Response, Failure> {
    let robot = read(parsed).await?;
    let id = slug(robot.read.robot.name());
    keep(&service, &id, robot, false)
}

/// Keep a robot of the lab under a name of your choice, in the place of the one that had it.
#[utoipa::path(
    put, path = "/robots/{id}", tag = "robots", operation_id = "put_robot",
    params(("id" = String, Path, description = "Name: letters, digits, `-` and `_`")),
    request_body(content((RobotSchema = "application/json"), (String = "application/xml"))),
    responses(
        (status = 200, description = "Replaced", body = RobotSummary),
        (status = 201, description = "Kept", body = RobotSummary),
        (status = 400, description = "Neither JSON nor XML", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "Comes with the program", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Wrong type", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn put(
    State(service): State<Service>,
    Path(id): Path<String>,
    RobotBody(parsed): RobotBody,
) -> Result<Response, Failure> {
    if id != slug(&id) {
        let problem = FieldProblem::new("/path/id", "is not a name").with_hint(format!("names are like `{}`", slug(&id)));
        return Err(Failure(Error::invalid("the address", vec![problem])));
    }
    let robot = read(parsed).await?;
    keep(&service, &id, robot, true)
}

fn keep(service: &Service, id: &str, robot: LabRobot, replace: bool) -> Result<Response, Failure> {
    let RobotDocument { robot: read, notes } = robot.read.clone();
    let new = service.put_robot(id, robot, replace)?;
    let summary = RobotSummary::of(&ListedRobot {
        id: id.into(),
        shipped: false,
        read: RobotDocument { robot: read, notes },
    });
    let status = if new { StatusCode::CREATED } else { StatusCode::OK };
    Ok((status, [(header::LOCATION, format!("/robots/{id}"))], Json(summary)).into_response())
}

/// Forget a robot of the lab.
#[utoipa::path(
    delete, path = "/robots/{id}", tag = "robots", operation_id = "delete_robot",
    params(("id" = String, Path, description = "Name of the robot")),
    responses(
        (status = 204, description = "Forgotten"),
        (status = 404, description = "Unknown robot", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "Comes with the program", body = Problem, content_type = "application/problem+json"),
    )
)]
pub async fn delete(State(service): State<Service>, Path(id): Path<String>) -> Result<StatusCode, Failure> {
    service.remove_robot(&id)?;
    Ok(StatusCode::NO_CONTENT)
}

/// A name as a path segment: letters and digits in lower case, everything else a hyphen; 64 characters at most.
fn slug(name: &str) -> String {
    let mapped: String = name
        .to_lowercase()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' })
        .take(64)
        .collect();
    let parts: Vec<&str> = mapped.split('-').filter(|p| !p.is_empty()).collect();
    if parts.is_empty() {
        "robot".to_string()
    } else {
        parts.join("-")
    }
}
