//! Bodies of requests.

use super::blocking::sized;
use super::problem::Failure;
use super::state::Service;
use crate::app::{Code, Error};
use crate::formats::{Parsed, parse, robot_file};
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, FromRequest, Request};
use axum::http::{HeaderMap, header};

/// A JSON body, read as far as possible: what is wrong with its numbers is listed, not refused yet.
pub struct JsonBody {
    pub parsed: Parsed,
    pub bytes: Bytes,
}

/// A robot: JSON or a URDF file.
pub struct RobotBody(pub Parsed);

/// A robot that is to be kept: as [`RobotBody`], or a ZIP archive of a robot's file with its meshes, which is still to be
/// unpacked.
pub enum RobotUpload {
    Document(Parsed),
    Archive(Bytes),
}

/// A ZIP archive of a robot's file with its meshes, which is still to be unpacked.
pub struct ArchiveBody(pub Bytes);

/// Bytes of an archive of a robot: meshes of an arm have tens of megabytes. Other documents are held to less, being held in
/// memory several times.
const LARGEST_ARCHIVE: usize = 64 << 20;

fn media_type(headers: &HeaderMap) -> String {
    let text = headers
        .get(header::CONTENT_TYPE)
        .and_then(|v| v.to_str().ok())
        .unwrap_or_default();
    text.split(';').next().unwrap_or_default().trim().to_ascii_lowercase()
}

fn is_json(media_type: &str) -> bool {
    media_type == "application/json" || (media_type.starts_with("application/") && media_type.ends_with("+json"))
}

fn is_xml(media_type: &str) -> bool {
    matches!(media_type, "application/xml" | "text/xml") || media_type.ends_with("+xml")
}

fn unsupported(found: &str, expected: &str) -> Failure {
    let found = if found.is_empty() {
        "no Content-Type".to_string()
    } else {
        format!("the Content-Type `{found}`")
    };
    Failure(
        Error::new(Code::UnsupportedMediaType, format!("the request has {found}"))
            .with_hint(format!("send `Content-Type: {expected}`")),
    )
}

impl<S: Send + Sync> FromRequest<S> for JsonBody {
    type Rejection = Failure;

    async fn from_request(request: Request, state: &S) -> Result<Self, Failure> {
        let media_type = media_type(request.headers());
        if !is_json(&media_type) {
            return Err(unsupported(&media_type, "application/json"));
        }
        let bytes = Bytes::from_request(request, state).await?;
        let text = bytes.clone();
        let parsed = sized(text.len(), move || parse(&text)).await?.map_err(Error::from)?;
        Ok(Self { parsed, bytes })
    }
}

fn is_zip(media_type: &str) -> bool {
    matches!(media_type, "application/zip" | "application/x-zip-compressed")
}

impl FromRequest<Service> for ArchiveBody {
    type Rejection = Failure;

    async fn from_request(mut request: Request, service: &Service) -> Result<Self, Failure> {
        let found = media_type(request.headers());
        if !is_zip(&found) {
            return Err(unsupported(&found, "application/zip"));
        }
        DefaultBodyLimit::max(LARGEST_ARCHIVE).apply(&mut request);
        Ok(Self(Bytes::from_request(request, service).await?))
    }
}

impl FromRequest<Service> for RobotUpload {
    type Rejection = Failure;

    async fn from_request(request: Request, service: &Service) -> Result<Self, Failure> {
        let found = media_type(request.headers());
        if is_zip(&found) {
            let ArchiveBody(bytes) = ArchiveBody::from_request(request, service).await?;
            return Ok(Self::Archive(bytes));
        }
        if !is_json(&found) && !is_xml(&found) {
            let expected =
                "application/json, application/xml for URDF or MJCF, or application/zip for a robot's file with its meshes";
            return Err(unsupported(&found, expected));
        }
        let RobotBody(parsed) = RobotBody::from_request(request, service).await?;
        Ok(Self::Document(parsed))
    }
}

impl<S: Send + Sync> FromRequest<S> for RobotBody {
    type Rejection = Failure;

    async fn from_request(request: Request, state: &S) -> Result<Self, Failure> {
        let media_type = media_type(request.headers());
        if !is_json(&media_type) && !is_xml(&media_type) {
            return Err(unsupported(&media_type, "application/json, or application/xml for URDF"));
        }
        let bytes = Bytes::from_request(request, state).await?;
        let read = sized(bytes.len(), move || robot_file(&bytes)).await?;
        Ok(Self(read.map_err(Error::from)?))
    }
}
