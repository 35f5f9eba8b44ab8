//! ROS 2 bags with SQLite as their storage.

use super::super::LogError;
use super::super::reader::broken;
use super::bag::{Bag, Recording};
use super::messages::Format;
use super::too_large;
use crate::model::INPUT_LIMITS;
use futures_util::TryStreamExt;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{ConnectOptions, Row};
use std::collections::HashMap;
use std::io::{Read, Write};
use std::path::Path;

/// Longest message that is unpacked (bytes).
const LONGEST_MESSAGE: u64 = 16 << 20;
/// First bytes of a message that was compressed by itself.
const ZSTANDARD: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];

/// Reads the bag by way of a temporary file: SQLite reads where it wants to.
pub(super) fn open(file: &str, bytes: &mut impl Read) -> Result<Bag, LogError> {
    let mut recording = Recording::new(file);
    read_into(file, bytes, &mut recording)?;
    recording.finish()
}

/// The messages of one file of a bag.
pub(super) fn read_into(file: &str, bytes: &mut impl Read, recording: &mut Recording) -> Result<(), LogError> {
    let io = |e: std::io::Error| broken(file, 0, &e);
    let mut copy = tempfile::NamedTempFile::new().map_err(io)?;
    let limit = INPUT_LIMITS.log_on_disk;
    let written = std::io::copy(&mut bytes.take(limit + 1), &mut copy).map_err(io)?;
    if written > limit {
        return Err(too_large(file, "bytes", limit));
    }
    copy.flush().map_err(io)?;
    // The database is asynchronous, and the caller may be a task that must not wait: a thread of its own does.
    std::thread::scope(|scope| {
        let reading = scope.spawn(|| {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()
                .map_err(io)?;
            runtime.block_on(read(file, copy.path(), recording))
        });
        reading
            .join()
            .unwrap_or_else(|_| Err(damaged(file, "the database library gave up".into())))
    })
}

async fn read(file: &str, path: &Path, recording: &mut Recording) -> Result<(), LogError> {
    let wrong = |e: sqlx::Error| damaged(file, e.to_string());
    let options = SqliteConnectOptions::new()
        .filename(path)
        .read_only(true)
        .immutable(true)
        // A file from anywhere may bring functions and views of its own.
        .pragma("trusted_schema", "OFF")
        .pragma("cell_size_check", "ON");
    let mut base = options.connect().await.map_err(wrong)?;
    let topics = topics(file, &mut base, recording).await?;
    let mut messages = sqlx::query("SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp").fetch(&mut base);
    while let Some(row) = messages.try_next().await.map_err(wrong)? {
        let topic: i64 = row.try_get(0).map_err(wrong)?;
        let Some(Topic { name, kind, format }) = topics.get(&topic) else {
            continue;
        };
        let log_ns: i64 = row.try_get(1).map_err(wrong)?;
        let data: &[u8] = row.try_get(2).map_err(wrong)?;
        let message = || unpacked(data).and_then(|data| format.read(&data));
        match format.is_generic() {
            true => recording.take_generic(name, kind, log_ns, message)?,
            false => recording.take(name, log_ns, message())?,
        }
    }
    Ok(())
}

struct Topic {
    name: String,
    kind: String,
    format: Format,
}

/// Definitions of messages by their types; bags before ROS 2 Iron have none.
async fn definitions(base: &mut SqliteConnection) -> HashMap<String, String> {
    let query = sqlx::query("SELECT topic_type, encoded_message_definition FROM message_definitions LIMIT 10000");
    let rows = query.fetch_all(&mut *base).await.unwrap_or_default();
    let pair = |row: &sqlx::sqlite::SqliteRow| Some((row.try_get(0).ok()?, row.try_get(1).ok()?));
    rows.iter().filter_map(pair).collect()
}

/// The topics that are read, by their numbers.
async fn topics(file: &str, base: &mut SqliteConnection, recording: &mut Recording) -> Result<HashMap<i64, Topic>, LogError> {
    let wrong = |e: sqlx::Error| damaged(file, e.to_string());
    let count: i64 = sqlx::query("SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages')")
        .fetch_one(&mut *base)
        .await
        .and_then(|row| row.try_get(0))
        .map_err(wrong)?;
    if count != 2 {
        return Err(LogError::Foreign {
            file: file.to_string(),
            what: "an SQLite database without the tables of a ROS 2 bag",
            remedy: "give the .db3 file of a bag, or export the log as CSV",
        });
    }
    let defined = definitions(base).await;
    let rows = sqlx::query("SELECT id, name, type, serialization_format FROM topics LIMIT 10000")
        .fetch_all(&mut *base)
        .await
        .map_err(wrong)?;
    let mut topics = HashMap::new();
    for row in rows {
        let id: i64 = row.try_get(0).map_err(wrong)?;
        let text = |at: usize| row.try_get::<String, _>(at).map_err(wrong);
        let (name, kind, coding) = (text(1)?, text(2)?, text(3)?);
        let definition = defined.get(&kind).map_or("", String::as_str);
        match Format::from_definition(&kind, &coding, definition.as_bytes()) {
            Some(format) => {
                topics.insert(id, Topic { name, kind, format });
            }
            None => recording.unread(&name, &kind),
        }
    }
    Ok(topics)
}

/// A message, which the recorder may have compressed.
fn unpacked(data: &[u8]) -> Result<std::borrow::Cow<'_, [u8]>, String> {
    if !data.starts_with(ZSTANDARD) {
        return Ok(data.into());
    }
    let mut out = Vec::new();
    let decoder = zstd::Decoder::new(data).map_err(|e| e.to_string())?;
    decoder
        .take(LONGEST_MESSAGE + 1)
        .read_to_end(&mut out)
        .map_err(|e| e.to_string())?;
    if out.len() as u64 > LONGEST_MESSAGE {
        return Err(format!("is longer than {LONGEST_MESSAGE} bytes"));
    }
    Ok(out.into())
}

fn damaged(file: &str, detail: String) -> LogError {
    LogError::Damaged {
        file: file.to_string(),
        format: "ROS 2 bag",
        detail,
        remedy: "`ros2 bag reindex` repairs a bag whose recorder was killed; else record it again",
    }
}
