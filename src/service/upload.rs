//! Multipart bodies: one JSON part, any number of files, streamed to disk.

use super::blocking::sized;
use super::problem::{Failure, is_timeout, stalled};
use super::store::{Files, hex};
use super::work::StoredLog;
use crate::app::{Code, Error};
use crate::formats::{Parsed, parse};
use axum::extract::Multipart;
use axum::extract::multipart::{Field, MultipartError};
use sha2::{Digest, Sha256};
use std::time::Duration;
use tokio::time::timeout;

/// A multipart request, its files on disk. Those of a request that is not finished, or not accepted, are swept later.
pub struct Upload {
    pub request: Parsed,
    pub logs: Vec<StoredLog>,
    pub validation: Vec<StoredLog>,
    /// Stands for all that was sent: the same parts, the same hash.
    pub body: String,
}

/// How long the rest of a refused upload is listened to.
const DRAINING: Duration = Duration::from_secs(10);
/// The JSON part is small; a log is not.
const LARGEST_REQUEST: usize = 8 << 20;

impl Upload {
    /// Reads the parts `request` (JSON), `log` and, where `validation` says so, `validation` (files).
    pub async fn read(mut body: Multipart, validation: bool, files: &Files) -> Result<Self, Failure> {
        let read = Self::parts(&mut body, validation, files).await;
        if read.is_err() {
            // A client that is still sending when the connection closes never sees the answer.
            let _ = timeout(DRAINING, drain(&mut body)).await;
        }
        read
    }

    async fn parts(body: &mut Multipart, validation: bool, files: &Files) -> Result<Self, Failure> {
        let (mut request, mut logs, mut held_out) = (None, Vec::new(), Vec::new());
        let mut hasher = Sha256::new();
        while let Some(field) = body.next_field().await.map_err(broken)? {
            let name = field.name().unwrap_or_default().to_string();
            hasher.update([name.as_bytes(), b"\0"].concat());
            match name.as_str() {
                "request" => request = Some(json_part(field, &mut hasher).await?),
                "log" => logs.push(file_part(field, files, logs.len() + held_out.len(), &mut hasher).await?),
                "validation" if validation => {
                    held_out.push(file_part(field, files, logs.len() + held_out.len(), &mut hasher).await?);
                }
                other => return Err(unknown_part(other, validation)),
            }
        }
        if logs.is_empty() {
            let none = Error::new(Code::InvalidLog, "there is no log in the upload");
            return Err(Failure(none.with_hint("send at least one file in a part called `log`")));
        }
        let missing = || {
            Error::new(Code::MalformedDocument, "there is no part called `request`")
                .with_hint("send the request as JSON in a part called `request`")
        };
        Ok(Self {
            request: request.ok_or_else(missing)?,
            logs,
            validation: held_out,
            body: hex(&hasher.finalize()),
        })
    }
}

/// Reads the one part `log` of a body that has nothing else.
pub async fn read_log(mut body: Multipart, files: &Files) -> Result<StoredLog, Failure> {
    let read = only_log(&mut body, files).await;
    if read.is_err() {
        let _ = timeout(DRAINING, drain(&mut body)).await;
    }
    read
}

async fn only_log(body: &mut Multipart, files: &Files) -> Result<StoredLog, Failure> {
    let mut found = None;
    while let Some(field) = body.next_field().await.map_err(broken)? {
        if field.name() != Some("log") || found.is_some() {
            let detail = "the body has another part than one called `log`";
            return Err(Failure(
                Error::new(Code::MalformedDocument, detail).with_hint("send one file in a part called `log`"),
            ));
        }
        found = Some(file_part(field, files, 0, &mut Sha256::new()).await?);
    }
    found.ok_or_else(|| {
        Failure(Error::new(Code::InvalidLog, "there is no log in the upload").with_hint("send one file in a part called `log`"))
    })
}

/// Takes in what is still coming, and keeps nothing of it.
async fn drain(body: &mut Multipart) {
    while let Ok(Some(mut field)) = body.next_field().await {
        while let Ok(Some(_)) = field.chunk().await {}
    }
}

fn unknown_part(name: &str, validation: bool) -> Failure {
    let parts = if validation {
        "`request`, `log` and `validation`"
    } else {
        "`request` and `log`"
    };
    let name: String = name.chars().take(80).collect();
    Failure(
        Error::new(Code::MalformedDocument, format!("there is a part called `{name}`"))
            .with_hint(format!("parts are called {parts}")),
    )
}

async fn json_part(mut field: Field<'_>, hasher: &mut Sha256) -> Result<Parsed, Failure> {
    let mut bytes = Vec::new();
    while let Some(chunk) = field.chunk().await.map_err(broken)? {
        hasher.update(&chunk);
        bytes.extend_from_slice(&chunk);
        if bytes.len() > LARGEST_REQUEST {
            return Err(Failure(
                Error::new(Code::PayloadTooLarge, "the part `request` is larger than 8 MB")
                    .with_hint("logs go into parts called `log`"),
            ));
        }
    }
    Ok(sized(bytes.len(), move || parse(&bytes)).await?.map_err(Error::from)?)
}

/// Streams a part into a file called by its content: names of clients do not reach the file system.
async fn file_part(mut field: Field<'_>, files: &Files, before: usize, hasher: &mut Sha256) -> Result<StoredLog, Failure> {
    let sent = field
        .file_name()
        .filter(|n| !n.is_empty())
        .map(|n| n.chars().take(200).collect());
    let name: String = sent.unwrap_or_else(|| format!("log {}", before + 1));
    let mut file = files.create().await?;
    let mut bytes = 0;
    while let Some(chunk) = field.chunk().await.map_err(broken)? {
        bytes += chunk.len();
        file.write(&chunk).await?;
    }
    if bytes == 0 {
        let detail = format!("{name} is empty; a log has a header line and one row per sample");
        return Err(Failure(Error::new(Code::InvalidLog, detail)));
    }
    let hash = files.keep(file).await?;
    hasher.update([name.as_bytes(), b"\0", hash.as_bytes()].concat());
    Ok(StoredLog { name, hash })
}

fn broken(e: MultipartError) -> Failure {
    if e.status() == axum::http::StatusCode::PAYLOAD_TOO_LARGE {
        let error = Error::new(Code::PayloadTooLarge, "the logs are larger than this server accepts");
        return Failure(error.with_hint("compress them with gzip, or send them one by one"));
    }
    if is_timeout(&e) {
        return stalled();
    }
    Failure(Error::new(
        Code::MalformedDocument,
        format!("the multipart body could not be read: {}", e.body_text()),
    ))
}
