//! `/identify/preview`: what is understood of logs, before anything is estimated.

use super::common::UploadRefused;
use super::results::not_multipart;
use super::schemas::IdentifyUpload;
use crate::app::{CancelFlag, Error, inspect};
use crate::io::{InspectDocument, read_identify_request};
use crate::service::access::Access;
use crate::service::blocking::{JsonDocument, ended, go_on, json_document};
use crate::service::known::Known;
use crate::service::problem::Failure;
use crate::service::rows;
use crate::service::state::Service;
use crate::service::store::Role;
use crate::service::upload::Upload;
use crate::service::worker::local;
use axum::extract::multipart::MultipartRejection;
use axum::extract::{Multipart, State};

/// What is understood of logs.
///
/// The body is that of `POST /identify`. Columns, rate, periods, gaps and garbage, inverted signs and mixed-up units, and every joint's
/// motion in SI units; nothing is estimated and nothing is kept.
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
) -> Result<JsonDocument, Failure> {
    access.require(Role::Run)?;
    // Logs that no job names are swept away later.
    let upload = Upload::read(body.map_err(not_multipart)?, true, service.files()).await?;
    let known = Known::of(&upload.request.value, &service, &access).await?;
    let (logs, held_out) = (
        local(&service, &upload.logs).await?,
        local(&service, &upload.validation).await?,
    );
    let most_rows = service.config().most_rows;
    let work = move |cancel: &CancelFlag| {
        let request = read_identify_request(&upload.request, &known, &known);
        let request = request.map_err(|e| Error::invalid("the identification request", e))?;
        for log in logs.iter().chain(&held_out) {
            go_on(cancel)?;
            rows::check(log, most_rows, cancel)?;
        }
        let seen = inspect(&request, &logs, &held_out, cancel)?.ok_or_else(ended)?;
        Ok(json_document(&seen))
    };
    Ok(service.blocking(work).await?)
}
