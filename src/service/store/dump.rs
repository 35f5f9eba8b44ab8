//! Backup and restore: all tables as lines of JSON and all files, in one tar archive that fits either database.

use super::{Dialect, Files, Store, Transaction, unavailable};
use crate::app::{Code, Error};
use serde_json::{Map, Value, json};
use sqlx::Row;
use sqlx::any::AnyRow;
use std::io::{Read, Seek, Write};
use tokio_stream::StreamExt;

/// Version of the archive.
const FORMAT: u64 = 1;

/// Tables in the order in which they can be filled, with their columns; those of numbers start with `#`. Shares, and what running
/// searches have found, are not among them: a job that is restored begins again. Nor are the parts of files, which are in the
/// archive as files.
const TABLES: &[(&str, &[&str])] = &[
    ("robots", &["id", "document", "#updated_us"]),
    ("effects", &["name", "document", "#updated_us"]),
    (
        "tokens",
        &[
            "id",
            "name",
            "hash",
            "role",
            "robots",
            "#created_us",
            "#expires_us",
            "#revoked_us",
        ],
    ),
    (
        "jobs",
        &[
            "id",
            "kind",
            "class",
            "robot",
            "token",
            "#urgency",
            "state",
            "fingerprint",
            "input",
            "result",
            "model",
            "outcome",
            "error",
            "progress",
            "step",
            "#sequence",
            "#lease",
            "#attempts",
            "#cancel_requested",
            "#created_us",
            "#started_us",
            "#finished_us",
            "name",
            "note",
            "logs",
        ],
    ),
    ("job_files", &["job", "hash"]),
    ("idempotency_keys", &["scope", "name", "body", "job"]),
    ("audit", &["#at_us", "request", "token", "who", "action", "robot", "target"]),
];

/// Tables that backups of earlier versions do not have: they are empty then.
const ADDED: [&str; 1] = ["effects"];

fn name(column: &str) -> &str {
    column.trim_start_matches('#')
}

/// How much a backup holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Amount {
    /// Rows of all tables.
    pub rows: usize,
    /// Stored files: requests, logs, results and models.
    pub files: usize,
}

/// Writes everything to `out`, as it was at one moment; the service may go on meanwhile.
pub async fn backup(store: &Store, files: &Files, out: impl Write) -> Result<Amount, Error> {
    let mut archive = tar::Builder::new(out);
    let manifest = json!({"format": FORMAT, "version": env!("CARGO_PKG_VERSION")});
    append(&mut archive, "manifest.json", manifest.to_string().as_bytes())?;
    let begin = match store.dialect {
        Dialect::Sqlite => "BEGIN",
        Dialect::Postgres => "BEGIN ISOLATION LEVEL REPEATABLE READ",
    };
    let mut transaction = store.pool.begin_with(begin).await.map_err(unavailable)?;
    let (mut amount, mut hashes) = (Amount::default(), Vec::new());
    for (table, columns) in TABLES {
        let mut lines = Vec::new();
        let mut rows = sqlx::query(store.sql(&format!("SELECT * FROM {table}"))).fetch(&mut *transaction);
        while let Some(row) = rows.next().await {
            let row = read(&row.map_err(unavailable)?, columns).map_err(unavailable)?;
            if *table == "job_files" {
                hashes.extend(row["hash"].as_str().map(str::to_string));
            }
            lines.extend_from_slice(row.to_string().as_bytes());
            lines.push(b'\n');
            amount.rows += 1;
        }
        append(&mut archive, &format!("tables/{table}.jsonl"), &lines)?;
    }
    hashes.sort();
    hashes.dedup();
    for hash in hashes {
        let path = files.path(&hash).await?;
        archive
            .append_path_with_name(path, format!("files/{hash}"))
            .map_err(unwritable)?;
        amount.files += 1;
    }
    archive.into_inner().and_then(|mut out| out.flush()).map_err(unwritable)?;
    Ok(amount)
}

fn append(archive: &mut tar::Builder<impl Write>, name: &str, content: &[u8]) -> Result<(), Error> {
    let mut header = tar::Header::new_gnu();
    header.set_size(content.len() as u64);
    header.set_mode(0o600);
    archive.append_data(&mut header, name, content).map_err(unwritable)
}

fn read(row: &AnyRow, columns: &[&str]) -> Result<Value, sqlx::Error> {
    let mut fields = Map::new();
    for column in columns {
        let value = match column.starts_with('#') {
            true => json!(row.try_get::<Option<i64>, _>(name(column))?),
            false => json!(row.try_get::<Option<String>, _>(name(column))?),
        };
        fields.insert(name(column).to_string(), value);
    }
    Ok(Value::Object(fields))
}

/// Fills an empty database and data folder from a backup. Jobs that ran when it was made wait again.
///
/// # Errors
/// The database is not empty; the archive is not one of ours, is cut off, or holds a file whose content is not what its name
/// says.
pub async fn restore(store: &Store, files: &Files, archive: impl Read + Seek) -> Result<Amount, Error> {
    for (table, _) in TABLES {
        let sql = store.sql(&format!("SELECT COUNT(*) AS rows FROM {table}"));
        let row = sqlx::query(sql).fetch_one(&store.pool).await.map_err(unavailable)?;
        if row.try_get::<i64, _>("rows").map_err(unavailable)? > 0 {
            let detail = format!("there are {table} in the database already");
            return Err(Error::new(Code::StorageUnavailable, detail).with_hint("restore into an empty data folder or database"));
        }
    }
    let mut archive = tar::Archive::new(archive);
    let (mut tables, mut amount) = (Map::new(), Amount::default());
    for entry in archive.entries().map_err(unreadable)? {
        let mut entry = entry.map_err(unreadable)?;
        let path = entry.path().map_err(unreadable)?.to_string_lossy().into_owned();
        if let Some(hash) = path.strip_prefix("files/") {
            take_file(files, hash, &mut entry).await?;
            amount.files += 1;
            continue;
        }
        let mut text = String::new();
        entry.read_to_string(&mut text).map_err(unreadable)?;
        tables.insert(path, json!(text));
    }
    check_manifest(&tables)?;
    let mut transaction = store.begin().await?;
    for (table, columns) in TABLES {
        let lines = tables.get(&format!("tables/{table}.jsonl")).and_then(Value::as_str);
        let lines = lines.or(ADDED.contains(table).then_some(""));
        let lines = lines.ok_or_else(|| not_ours(&format!("it has no table {table}")))?;
        for line in lines.lines() {
            insert(store, &mut transaction, table, columns, line).await?;
            amount.rows += 1;
        }
    }
    let sql = "UPDATE jobs SET state = 'queued' WHERE state = 'running'";
    sqlx::query(sql).execute(&mut *transaction).await.map_err(unavailable)?;
    transaction.commit().await.map_err(unavailable)?;
    Ok(amount)
}

fn check_manifest(tables: &Map<String, Value>) -> Result<(), Error> {
    let text = tables.get("manifest.json").and_then(Value::as_str).unwrap_or_default();
    let manifest: Value = serde_json::from_str(text).unwrap_or_default();
    match manifest["format"].as_u64() {
        Some(FORMAT) => Ok(()),
        Some(other) => Err(not_ours(&format!("it has the format {other}, this version reads {FORMAT}"))),
        None => Err(not_ours("it has no manifest.json")),
    }
}

async fn take_file(files: &Files, hash: &str, content: &mut impl Read) -> Result<(), Error> {
    let mut new = files.create().await?;
    let mut buffer = vec![0; 1 << 16];
    loop {
        let read = content.read(&mut buffer).map_err(unreadable)?;
        if read == 0 {
            break;
        }
        new.write(&buffer[..read]).await?;
    }
    let kept = files.keep(new).await?;
    match kept == hash {
        true => Ok(()),
        false => Err(not_ours(&format!("its file {hash} is damaged"))),
    }
}

async fn insert(store: &Store, transaction: &mut Transaction, table: &str, columns: &[&str], line: &str) -> Result<(), Error> {
    let row: Value =
        serde_json::from_str(line).map_err(|e| not_ours(&format!("a line of the table {table} is not JSON: {e}")))?;
    let names: Vec<&str> = columns.iter().map(|c| name(c)).collect();
    let places: Vec<String> = (1..=columns.len()).map(|i| format!("${i}")).collect();
    let sql = format!("INSERT INTO {table} ({}) VALUES ({})", names.join(", "), places.join(", "));
    let mut query = sqlx::query(store.sql(&sql));
    for column in columns {
        let value = &row[name(column)];
        query = match column.starts_with('#') {
            true => query.bind(value.as_i64()),
            false => query.bind(value.as_str().map(str::to_string)),
        };
    }
    query.execute(&mut **transaction).await.map(drop).map_err(unavailable)
}

fn not_ours(why: &str) -> Error {
    Error::new(Code::FileUnreadable, format!("this is no backup that can be restored: {why}"))
}

fn unreadable(e: std::io::Error) -> Error {
    not_ours(&e.to_string())
}

fn unwritable(e: std::io::Error) -> Error {
    Error::new(Code::FileUnwritable, format!("the backup cannot be written: {e}"))
}
