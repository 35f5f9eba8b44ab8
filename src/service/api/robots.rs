//! `/robots`: those that come with the program and those of the lab.

use super::query::QueryFields;
use super::results::computed;
use crate::app::{Code, Error, ProblemDetails};
use crate::documents::requests;
use crate::documents::{BaseParametersDocument, RobotReport};
use crate::formats::{Parsed, RobotArchive};
use crate::model::FieldProblem;
use crate::service::access::{Access, slug};
use crate::service::child::{REQUEST, RobotRead, Task};
use crate::service::document::RobotUpload;
use crate::service::known::{Known, is_shipped};
use crate::service::problem::Failure;
use crate::service::state::Service;
use crate::service::store::{Role, unreadable_robot};
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
    /// Name of the robot, in addresses and requests.
    pub name: String,
    /// Names of the joints from the base on.
    pub joints: Vec<String>,
    /// Comes with the program and cannot be changed.
    pub shipped: bool,
    /// What to know about how it was read.
    pub notes: Vec<String>,
    /// What was understood of the document, where it was just given.
    #[schema(value_type = Option<RobotReport>)]
    pub understood: Option<Value>,
}

/// The robots that the token may see.
#[derive(Serialize, utoipa::ToSchema)]
pub struct RobotList {
    /// One entry per robot.
    pub robots: Vec<RobotSummary>,
}

impl RobotSummary {
    fn from_read(id: &str, read: RobotRead) -> Self {
        Self {
            id: id.to_string(),
            name: read.name,
            joints: read.joints,
            shipped: is_shipped(id),
            notes: read.notes,
            understood: None,
        }
    }
}

/// Reads a document where it can do no harm.
async fn read(service: &Service, parsed: Parsed) -> Result<RobotRead, Error> {
    let known = Known::for_robot(&parsed.value, service).await?.into();
    let document = parsed.into();
    service.compute_document(Task::Robot { document, known }, REQUEST).await
}

async fn stored(service: &Service, id: &str, access: &Access) -> Result<Parsed, Error> {
    Ok(Parsed {
        value: service.robot(id, access).await?,
        problems: Vec::new(),
    })
}

/// What is wrong with the document of a robot that is kept is not the client's, who has only called it by its name.
fn unreadable(id: &str, error: Error) -> Error {
    match error.code {
        Code::InvalidDocument => Error {
            errors: error.errors,
            ..unreadable_robot(id, &error.detail)
        },
        _ => error,
    }
}

/// All robots. One that is kept and cannot be read is left out; asked for by its name, it is said why.
#[utoipa::path(get, path = "/robots", tag = "robots", operation_id = "list_robots", responses((status = 200, body = RobotList)))]
pub async fn list(State(service): State<Service>, access: Access) -> Result<Json<RobotList>, Failure> {
    let mut robots = Vec::new();
    for id in service.robot_names(&access).await? {
        let read = match stored(&service, &id, &access).await {
            Ok(parsed) => read(&service, parsed).await.map_err(|e| unreadable(&id, e)),
            Err(e) => Err(e),
        };
        match read {
            Ok(read) => robots.push(RobotSummary::from_read(&id, read)),
            // A robot that was removed meanwhile is not listed.
            Err(e) if e.code == Code::UnknownRobot => {}
            Err(e) if e.code == Code::RobotUnreadable => {
                tracing::error!(robot = id, detail = e.detail, errors = ?e.errors, "left out of the list of robots");
            }
            Err(e) => return Err(Failure(e)),
        }
    }
    Ok(Json(RobotList { robots }))
}

/// The document of a robot, as it was given.
#[utoipa::path(
    get, path = "/robots/{id}", tag = "robots", operation_id = "get_robot",
    params(("id" = String, Path, description = "Name of the robot", example = "iiwa14")),
    responses(
        (status = 200, body = requests::Robot),
        (status = 404, description = "Unknown robot", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 500, description = "Kept, but its document cannot be read", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn get(State(service): State<Service>, access: Access, Path(id): Path<String>) -> Result<Json<Value>, Failure> {
    Ok(Json(service.robot(&id, &access).await?))
}

/// Names, expressions and numeric map of the base parameters.
#[utoipa::path(
    get, path = "/robots/{id}/base-parameters", tag = "robots", operation_id = "get_base_parameters",
    params(("id" = String, Path, description = "Name of the robot", example = "iiwa14")),
    responses(
        (status = 200, body = BaseParametersDocument),
        (status = 404, description = "Unknown robot", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 500, description = "Kept, but its document cannot be read", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn base_parameters(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
) -> Result<Response, Failure> {
    let parsed = stored(&service, &id, &access).await?;
    let known = Known::for_robot(&parsed.value, &service).await?.into();
    let document = parsed.into();
    let made = service.compute(Task::BaseParameters { document, known }, REQUEST).await;
    Ok(computed(made.map_err(|e| unreadable(&id, e))?))
}

/// `tip` and `base` of the query string, for URDF files as they are.
fn put_ends(parsed: &mut Parsed, mut query: QueryFields) -> Result<(), Failure> {
    let named = |text: &str| Some(Some(text.to_string())).filter(|_| !text.is_empty());
    let ends = ["tip", "base"].map(|end| (end, query.take(end, None, "the name of a link", named)));
    query.finish()?;
    for (end, link) in ends.into_iter().filter_map(|(end, link)| Some((end, link?))) {
        match parsed
            .value
            .as_object_mut()
            .filter(|f| f.contains_key("urdf") || f.contains_key("mjcf"))
        {
            Some(fields) => fields.insert(end.to_string(), link.into()),
            None => {
                let problem = FieldProblem::new(format!("/query/{end}"), "goes with a robot from a URDF or MJCF file");
                return Err(Failure(Error::invalid("the address", vec![problem])));
            }
        };
    }
    Ok(())
}

/// The document that is kept, and what there is to say of its robot.
async fn read_upload(service: &Service, upload: RobotUpload, query: QueryFields) -> Result<(Value, RobotRead), Failure> {
    let (mut parsed, notes) = match upload {
        RobotUpload::Document(parsed) => (parsed, Vec::new()),
        RobotUpload::Archive(bytes) => {
            let task = Task::RobotArchive { bytes: bytes.into() };
            let RobotArchive { document, notes } = service.compute_document(task, REQUEST).await?;
            let problems = Vec::new();
            (
                Parsed {
                    value: document,
                    problems,
                },
                notes,
            )
        }
    };
    put_ends(&mut parsed, query)?;
    let document = parsed.value.clone();
    let mut robot = read(service, parsed).await?;
    robot.notes.extend(notes);
    Ok((document, robot))
}

/// Keep a robot of the lab; its id is made from its name.
///
/// A ZIP archive has one URDF or MJCF file and the meshes that it names (STL, OBJ, COLLADA): links that are described by meshes
/// alone get capsules around them. At most 64 MiB.
#[utoipa::path(
    post, path = "/robots", tag = "robots", operation_id = "add_robot",
    params(
        ("tip" = Option<String>, Query, description = "Last link of the arm in a URDF or MJCF file that has more"),
        ("base" = Option<String>, Query, description = "Link that stands still, where it is not the root of the file"),
    ),
    request_body(content((requests::Robot = "application/json"), (String = "application/xml"), (Vec<u8> = "application/zip"))),
    responses(
        (status = 201, description = "Kept; its address is in `Location`", body = RobotSummary,
            headers(("Location" = String, description = "Address of the robot"))),
        (status = 400, description = "Neither JSON nor XML nor a ZIP archive of one robot", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 404, description = "The token is not for a robot of this name", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "A robot of that name exists", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 413, description = "Document too large", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 415, description = "Wrong type", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn post(
    State(service): State<Service>,
    access: Access,
    query: QueryFields,
    upload: RobotUpload,
) -> Result<Response, Failure> {
    access.require(Role::Admin)?;
    let (document, robot) = read_upload(&service, upload, query).await?;
    let id = slug(&robot.name);
    keep(&service, &access, &id, (document, robot), false).await
}

/// Keep a robot of the lab under a name of your choice, in the place of the one that had it.
#[utoipa::path(
    put, path = "/robots/{id}", tag = "robots", operation_id = "put_robot",
    params(
        ("id" = String, Path, description = "Name: letters, digits, `-` and `_`"),
        ("tip" = Option<String>, Query, description = "Last link of the arm in a URDF or MJCF file that has more"),
        ("base" = Option<String>, Query, description = "Link that stands still, where it is not the root of the file"),
    ),
    request_body(content((requests::Robot = "application/json"), (String = "application/xml"), (Vec<u8> = "application/zip"))),
    responses(
        (status = 200, description = "Replaced", body = RobotSummary),
        (status = 201, description = "Kept", body = RobotSummary),
        (status = 400, description = "Neither JSON nor XML nor a ZIP archive of one robot", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 404, description = "The token is not for a robot of this name", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "Comes with the program", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 413, description = "Document too large", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 415, description = "Wrong type", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn put(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
    query: QueryFields,
    upload: RobotUpload,
) -> Result<Response, Failure> {
    access.require(Role::Admin)?;
    if id != slug(&id) {
        let problem = FieldProblem::new("/path/id", "is not a name").with_hint(format!("names are like `{}`", slug(&id)));
        return Err(Failure(Error::invalid("the address", vec![problem])));
    }
    let read = read_upload(&service, upload, query).await?;
    keep(&service, &access, &id, read, true).await
}

async fn keep(
    service: &Service,
    access: &Access,
    id: &str,
    (document, read): (Value, RobotRead),
    replace: bool,
) -> Result<Response, Failure> {
    let new = service.put_robot(id, &document, replace, access).await?;
    let status = if new { StatusCode::CREATED } else { StatusCode::OK };
    let understood = Some(read.understood.clone());
    let summary = RobotSummary {
        understood,
        ..RobotSummary::from_read(id, read)
    };
    Ok((status, [(header::LOCATION, format!("/robots/{id}"))], Json(summary)).into_response())
}

/// Forget a robot of the lab.
#[utoipa::path(
    delete, path = "/robots/{id}", tag = "robots", operation_id = "delete_robot",
    params(("id" = String, Path, description = "Name of the robot")),
    responses(
        (status = 204, description = "Forgotten"),
        (status = 404, description = "Unknown robot", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "Comes with the program", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn delete(State(service): State<Service>, access: Access, Path(id): Path<String>) -> Result<StatusCode, Failure> {
    access.require(Role::Admin)?;
    service.remove_robot(&id, &access).await?;
    Ok(StatusCode::NO_CONTENT)
}
