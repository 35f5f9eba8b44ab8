//! The folder of a rosbag2 recording as one ZIP archive, as it is sent over HTTP.

use super::super::LogError;
use super::bag::{Bag, Recording};
use super::{mcap, rosbag2, too_large};
use crate::model::INPUT_LIMITS;
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// Files of one recording: rosbag2 begins a new one every so many bytes or seconds.
const MOST_FILES: usize = 1_000;

/// The recording in a ZIP archive: all its `.mcap` and `.db3` files, in the order of their names, as one. `None` where the
/// archive has none.
///
/// # Errors
/// As of these files.
pub(super) fn open(file: &str, bytes: &[u8]) -> Result<Option<Bag>, LogError> {
    let Ok(mut archive) = ZipArchive::new(Cursor::new(bytes)) else {
        return Ok(None);
    };
    let is_storage = |name: &str| [".mcap", ".db3"].iter().any(|ending| name.ends_with(ending));
    let mut parts: Vec<String> = archive
        .file_names()
        .filter_map(|n| Some(n.ok()?.to_string()))
        .filter(|n| is_storage(n))
        .collect();
    if parts.is_empty() {
        return Ok(None);
    }
    if parts.len() > MOST_FILES {
        return Err(too_large(file, "files of the recording", MOST_FILES as u64));
    }
    parts.sort_by_key(|name| (name.len(), name.clone()));
    let allowed = INPUT_LIMITS
        .log_expansion
        .saturating_mul(bytes.len() as u64)
        .max(INPUT_LIMITS.log_unpacked_free);
    let mut recording = Recording::new(file);
    let mut left = allowed.min(INPUT_LIMITS.log_on_disk);
    for name in parts {
        let damaged = |e: zip::result::ZipError| LogError::Damaged {
            file: format!("{file}: {name}"),
            format: "ZIP archive",
            detail: e.to_string(),
            remedy: "pack the folder of the recording again",
        };
        let mut content = archive.by_name(&name).map_err(damaged)?.take(left + 1);
        match name.ends_with(".db3") {
            true => rosbag2::read_into(file, &mut content, &mut recording)?,
            false => mcap::read_into(file, &mut content, &mut recording)?,
        }
        let read = left + 1 - content.limit();
        left = left.checked_sub(read).ok_or_else(|| too_large(file, "bytes", allowed))?;
    }
    recording.finish().map(Some)
}
