//! `/identify/preview` and `/logs/columns`: what is understood of logs, before anything is estimated.

use super::common::UploadRefused;
use super::results::{computed, not_multipart};
use crate::documents::InspectDocument;
use crate::documents::requests::{IdentifyUpload, LogUpload};
use crate::formats::logs::LogOverview;
use crate::service::access::Access;
use crate::service::child::Task;
use crate::service::known::Known;
use crate::service::problem::Failure;
use crate::service::state::Service;
use crate::service::store::Role;
use crate::service::upload::{Upload, read_log};
use crate::service::worker::local;
use axum::extract::multipart::MultipartRejection;
use axum::extract::{Multipart, State};
use axum::response::Response;

/// What is understood of logs.
///
/// The body is that of `POST /identify`. Columns, rate, periods, gaps and garbage, inverted signs and mixed-up units, and every
/// joint's motion in SI units; nothing is estimated and nothing is kept.
#[utoipa::path(
    post, path = "/identify/preview", tag = "identification", operation_id = "preview_logs",
    request_body(content = IdentifyUpload, content_type = "multipart/form-data"),
    responses(
        (status = 200, body = InspectDocument),
        UploadRefused,
    )
)]
pub async fn post(
    State(service): State<Service>,
    access: Access,
    body: Result<Multipart, MultipartRejection>,
) -> Result<Response, Failure> {
    access.require(Role::Run)?;
    // Logs that no job names are swept away later.
    let upload = Upload::read(body.map_err(not_multipart)?, true, service.files()).await?;
    let known = Known::for_request(&upload.request.value, &service, &access).await?;
    let (logs, held_out) = (
        local(&service, &upload.logs).await?,
        local(&service, &upload.validation).await?,
    );
    let task = Task::Preview {
        document: upload.request.into(),
        known: known.into(),
        logs: logs.into_iter().map(Into::into).collect(),
        validation: held_out.into_iter().map(Into::into).collect(),
        most_rows: service.config().most_rows,
    };
    // It reads the same logs as an identification.
    Ok(computed(service.compute(task, service.config().job_time).await?))
}

/// The columns of a log.
///
/// The body has one part, `log`: a file of any format that is read. Names, units, first values and a thinned series of every
/// column; nothing is taken for anything, and nothing is kept.
#[utoipa::path(
    post, path = "/logs/columns", tag = "identification", operation_id = "log_columns",
    request_body(content = LogUpload, content_type = "multipart/form-data"),
    responses(
        (status = 200, body = LogOverview),
        UploadRefused,
    )
)]
pub async fn columns(
    State(service): State<Service>,
    access: Access,
    body: Result<Multipart, MultipartRejection>,
) -> Result<Response, Failure> {
    access.require(Role::Run)?;
    let log = read_log(body.map_err(not_multipart)?, service.files()).await?;
    let mut logs = local(&service, std::slice::from_ref(&log)).await?;
    let log = logs.pop().expect("one for one").into();
    Ok(computed(
        service.compute(Task::Columns { log }, service.config().job_time).await?,
    ))
}
