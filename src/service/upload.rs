//! Multipart bodies: one JSON part, any number of files, streamed to disk.

use super::problem::Failure;
use super::work::Uploads;
use crate::app::{Code, Error, LogFile};
use crate::io::{Parsed, parse};
use axum::extract::Multipart;
use axum::extract::multipart::{Field, MultipartError};
use std::hash::{DefaultHasher, Hasher};
use std::path::PathBuf;
use tokio::io::AsyncWriteExt;

/// A multipart request, its files on disk.
pub struct Upload {
    pub request: Parsed,
    pub files: Uploads,
    /// Stands for all that was sent: the same bytes, the same print.
    pub fingerprint: Vec<u8>,
}

/// The JSON part is small; a log is not.
const LARGEST_REQUEST: usize = 8 << 20;

impl Upload {
    /// Reads the parts `request` (JSON), `log` and, where `validation` says so, `validation` (files).
    pub async fn read(mut body: Multipart, validation: bool) -> Result<Self, Failure> {
        let folder = tempfile::Builder::new().prefix("dynident-").tempdir().map_err(no_space)?;
        let mut files = Uploads {
            logs: Vec::new(),
            validation: Vec::new(),
            folder,
        };
        let mut hasher = DefaultHasher::new();
        let mut request = None;
        while let Some(field) = body.next_field().await.map_err(broken)? {
            let name = field.name().unwrap_or_default().to_string();
            hasher.write(name.as_bytes());
            match name.as_str() {
                "request" => request = Some(json_part(field, &mut hasher).await?),
                "log" => files.logs.push(file_part(field, &files, &mut hasher).await?),
                "validation" if validation => files.validation.push(file_part(field, &files, &mut hasher).await?),
                other => return Err(unknown_part(other, validation)),
            }
        }
        let missing = || {
            Error::new(Code::MalformedDocument, "there is no part called `request`")
                .with_hint("send the request as JSON in a part called `request`")
        };
        let request = request.ok_or_else(missing)?;
        Ok(Self {
            request,
            files,
            fingerprint: hasher.finish().to_le_bytes().to_vec(),
        })
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

async fn json_part(mut field: Field<'_>, hasher: &mut DefaultHasher) -> Result<Parsed, Failure> {
    let mut bytes = Vec::new();
    while let Some(chunk) = field.chunk().await.map_err(broken)? {
        hasher.write(&chunk);
        bytes.extend_from_slice(&chunk);
        if bytes.len() > LARGEST_REQUEST {
            return Err(Failure(
                Error::new(Code::PayloadTooLarge, "the part `request` is larger than 8 MB")
                    .with_hint("logs go into parts called `log`"),
            ));
        }
    }
    Ok(parse(&bytes).map_err(Error::from)?)
}

/// Streams a part into a file called by number: names of clients do not reach the file system.
async fn file_part(mut field: Field<'_>, files: &Uploads, hasher: &mut DefaultHasher) -> Result<LogFile, Failure> {
    let number = files.logs.len() + files.validation.len() + 1;
    let sent = field
        .file_name()
        .filter(|n| !n.is_empty())
        .map(|n| n.chars().take(200).collect());
    let name: String = sent.unwrap_or_else(|| format!("log {number}"));
    hasher.write(name.as_bytes());
    let path: PathBuf = files.folder.path().join(number.to_string());
    let mut file = tokio::fs::File::create(&path).await.map_err(no_space)?;
    while let Some(chunk) = field.chunk().await.map_err(broken)? {
        hasher.write(&chunk);
        file.write_all(&chunk).await.map_err(no_space)?;
    }
    file.flush().await.map_err(no_space)?;
    Ok(LogFile { name, path })
}

fn broken(e: MultipartError) -> Failure {
    if e.status() == axum::http::StatusCode::PAYLOAD_TOO_LARGE {
        let error = Error::new(Code::PayloadTooLarge, "the logs are larger than this server accepts");
        return Failure(error.with_hint("compress them with gzip, or send them one by one"));
    }
    Failure(Error::new(
        Code::MalformedDocument,
        format!("the multipart body could not be read: {}", e.body_text()),
    ))
}

fn no_space(e: std::io::Error) -> Failure {
    Failure(Error::new(
        Code::FileUnwritable,
        format!("an uploaded log could not be kept: {e}"),
    ))
}
