//! `/identify` and `/validate`: from logs to a model, and a model against logs.

use super::common::{Begun, NoResultOfLogs, UploadRefused, WaitHeader, WorkHeaders};
use super::query::QueryFields;
use super::results::{AnswerForm, answer, answer_as, begin, document, find, not_multipart};
use crate::app::{Code, Error, ModelFiles, ProblemDetails};
use crate::documents::requests::{IdentifyUpload, ModelFormat, ValidateUpload};
use crate::documents::{IdentifyDocument, ValidateDocument};
use crate::formats::ModelFormat as Format;
use crate::service::access::Access;
use crate::service::blocking::read_stored;
use crate::service::document::RobotBody;
use crate::service::prefer::PreferWait;
use crate::service::problem::Failure;
use crate::service::state::Service;
use crate::service::store::Role;
use crate::service::submit::Asked;
use crate::service::upload::Upload;
use crate::service::work::JobKind;
use axum::Json;
use axum::extract::multipart::MultipartRejection;
use axum::extract::{Multipart, Path, State};
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::Value;

/// The result of an identification, under the id of its job.
#[derive(Serialize, utoipa::ToSchema)]
pub struct IdentificationResult {
    /// ID of the job.
    pub id: String,
    /// The identification.
    #[serde(flatten)]
    pub result: IdentifyDocument,
}

/// The result of a validation, under the id of its job.
#[derive(Serialize, utoipa::ToSchema)]
pub struct ValidationResult {
    /// ID of the job.
    pub id: String,
    /// The validation.
    #[serde(flatten)]
    pub result: ValidateDocument,
}

/// Identify a robot from logs.
///
/// Logs are CSV, NPZ, MATLAB, Parquet, MCAP or rosbag2 files, plain, gzip or Zstandard. The folder of a rosbag2 recording is sent
/// as one ZIP archive. Answers 202 with the job, whose address is in `Location`; with `Prefer: wait=N` 200 and the result if that
/// comes within N seconds. A log that is too poor for the model is an outcome (`quality`), not an error.
#[utoipa::path(
    post, path = "/identify", tag = "identification", operation_id = "identify",
    request_body(content = IdentifyUpload, content_type = "multipart/form-data"),
    params(WorkHeaders),
    responses(
        (status = 200, description = "The result, with `Prefer: wait`", body = IdentificationResult),
        Begun,
        UploadRefused,
    )
)]
pub async fn post(
    State(service): State<Service>,
    access: Access,
    wait: PreferWait,
    headers: HeaderMap,
    body: Result<Multipart, MultipartRejection>,
) -> Result<Response, Failure> {
    let asked = read(&service, &access, body, JobKind::Identification).await?;
    begin(&service, &access, &headers, wait, asked).await
}

/// Hold a model against logs.
///
/// The model is the JSON model of an identification, or any robot with parameters for every link.
#[utoipa::path(
    post, path = "/validate", tag = "identification", operation_id = "validate",
    request_body(content = ValidateUpload, content_type = "multipart/form-data"),
    params(WorkHeaders),
    responses(
        (status = 200, description = "The result, with `Prefer: wait`", body = ValidationResult),
        Begun,
        UploadRefused,
    )
)]
pub async fn post_validation(
    State(service): State<Service>,
    access: Access,
    wait: PreferWait,
    headers: HeaderMap,
    body: Result<Multipart, MultipartRejection>,
) -> Result<Response, Failure> {
    let asked = read(&service, &access, body, JobKind::Validation).await?;
    begin(&service, &access, &headers, wait, asked).await
}

/// Reads a multipart body; who may not run anything need not send logs.
async fn read(
    service: &Service,
    access: &Access,
    body: Result<Multipart, MultipartRejection>,
    kind: JobKind,
) -> Result<Asked, Failure> {
    access.require(Role::Run)?;
    let held_out = kind == JobKind::Identification;
    let upload = Upload::read(body.map_err(not_multipart)?, held_out, service.files()).await?;
    Ok(Asked {
        kind,
        parsed: upload.request,
        logs: upload.logs,
        validation: upload.validation,
        body: upload.body,
    })
}

/// The result of an identification.
///
/// While it goes on, 202 with the job; `Prefer: wait=N` waits for the result as in the POST.
#[utoipa::path(
    get, path = "/identify/{id}", tag = "identification", operation_id = "get_identification",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("predictions" = Option<bool>, Query, description = "`false`: without the series to draw, which are most of the answer"),
        WaitHeader,
    ),
    responses(
        (status = 200, description = "The result", body = IdentificationResult),
        (status = 400, description = "Bad query", body = ProblemDetails, content_type = "application/problem+json"),
        NoResultOfLogs,
    )
)]
pub async fn get(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
    wait: PreferWait,
    mut query: QueryFields,
) -> Result<Response, Failure> {
    let drawn = query.take("predictions", true, "true or false", |t| t.parse().ok());
    query.finish()?;
    let job = find(&service, &access, &id, JobKind::Identification).await?;
    let form = if drawn {
        AnswerForm::Whole
    } else {
        AnswerForm::WithoutPredictions
    };
    answer_as(&service, job, wait, form).await
}

/// The result of a validation.
#[utoipa::path(
    get, path = "/validate/{id}", tag = "identification", operation_id = "get_validation",
    params(
        ("id" = String, Path, description = "Id of the job"),
        WaitHeader,
    ),
    responses(
        (status = 200, description = "The result", body = ValidationResult),
        NoResultOfLogs,
    )
)]
pub async fn get_validation(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
    wait: PreferWait,
) -> Result<Response, Failure> {
    let job = find(&service, &access, &id, JobKind::Validation).await?;
    answer(&service, job, wait).await
}

/// The identified model as a file.
///
/// Every format is made from the JSON model. What a format cannot hold stands at the top of its file with the torque that is
/// missing along the identification logs, and in `formats` of the JSON model.
#[utoipa::path(
    get, path = "/identify/{id}/model", tag = "identification", operation_id = "get_model",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("format" = inline(Option<ModelFormat>), Query, description = "`json` (default; taken by POST /validate), `urdf`, `mjcf`, `sdf`, `csv`, `c` or `python`"),
    ),
    responses(
        (status = 200, description = "The model", content((Object = "application/json"), (String = "application/xml"), (String = "text/csv"), (String = "text/x-c"), (String = "text/x-python"))),
        (status = 400, description = "Unknown format", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 404, description = "Unknown id", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "No result yet, or no model that is a physical robot", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 422, description = "A log that cannot be used", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn model(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
    mut query: QueryFields,
) -> Result<Response, Failure> {
    let by_name = |t: &str| Format::ALL.iter().find(|(name, _)| *name == t).map(|(_, f)| *f);
    let format = query.take("format", Format::Json, "json, urdf, mjcf, sdf, csv, c or python", by_name);
    query.finish()?;
    let json = stored_model(&service, &access, &id).await?;
    if format == Format::Json {
        return Ok((attachment(&id, format), Json(json)).into_response());
    }
    let text = service.blocking(move |_| Ok(ModelFiles::of_json(json)?.text(format))).await?;
    Ok((attachment(&id, format), text).into_response())
}

/// The identified bodies in a URDF file of your own.
///
/// Mass, centre of mass, inertia and friction of the arm's links and joints are put into the file; meshes, materials, comments
/// and all other links stay as they are. Joints have the names of the identified robot, and the same places.
#[utoipa::path(
    post, path = "/identify/{id}/model", tag = "identification", operation_id = "patch_urdf",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("tip" = Option<String>, Query, description = "Last link of the arm, where the file has more"),
        ("base" = Option<String>, Query, description = "Link that stands still, where it is not the root of the file"),
    ),
    request_body(content = String, content_type = "application/xml"),
    responses(
        (status = 200, description = "The file with the bodies", body = String, content_type = "application/xml"),
        (status = 400, description = "No XML", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 404, description = "Unknown id", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "No result yet, or no model that is a physical robot", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 413, description = "File too large", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 415, description = "Wrong type", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 422, description = "No URDF, or another arm", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn patch_model(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
    mut query: QueryFields,
    RobotBody(parsed): RobotBody,
) -> Result<Response, Failure> {
    let named = |text: &str| Some(Some(text.to_string())).filter(|_| !text.is_empty());
    let [tip, base] = ["tip", "base"].map(|end| query.take(end, None, "the name of a link", named));
    query.finish()?;
    let json = stored_model(&service, &access, &id).await?;
    let patched = service.blocking(move |_| {
        let Some(xml) = parsed.value["urdf"].as_str() else {
            return Err(Error::new(Code::InvalidDocument, "the body is no URDF file")
                .with_hint("send the file as it is, as application/xml"));
        };
        Ok(ModelFiles::of_json(json)?.patched(xml, base.as_deref(), tip.as_deref())?.urdf)
    });
    Ok((attachment(&id, Format::Urdf), patched.await?).into_response())
}

fn attachment(id: &str, format: Format) -> [(header::HeaderName, String); 2] {
    let (kind, ending) = format.kind();
    let name = format!("attachment; filename=\"model-{id}.{ending}\"");
    [(header::CONTENT_DISPOSITION, name), (header::CONTENT_TYPE, kind.to_string())]
}

/// The JSON model of a finished identification.
async fn stored_model(service: &Service, access: &Access, id: &str) -> Result<Value, Failure> {
    let job = find(service, access, id, JobKind::Identification).await?;
    if !job.state.is_final() {
        return Err(Failure(Error::new(Code::NoModel, "the identification goes on")));
    }
    let Some(file) = &job.model else {
        document(service, &job).await?;
        let none = Error::new(
            Code::NoModel,
            "the identification has no physical parameters that make a robot",
        );
        return Err(Failure(
            none.with_hint("ask for `feasible`, and see `feasibility` in the result"),
        ));
    };
    let mut forms: Value = read_stored(service.files().read(file).await?).await?;
    Ok(forms["json"].take())
}
