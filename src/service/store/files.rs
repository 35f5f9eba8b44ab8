//! Files named by the SHA-256 of their content: logs, requests and results.
//!
//! A file is written under another name, brought to the disk, and renamed: one that has its name is whole. With PostgreSQL its
//! content is in the database as well, for the workers on other machines and for the backup; the folder is then a cache.

use super::{Dialect, Store, now_us, unavailable};
use crate::app::{Code, Error};
use sha2::{Digest, Sha256};
use sqlx::Row;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use tempfile::NamedTempFile;
use tokio::io::AsyncReadExt;
use uuid::Uuid;

/// Size of a part in the database (bytes): small against the memory of any machine, large against the cost of a statement.
const PART: usize = 1 << 20;
/// Files that no job names are swept when they are this old: an upload that still goes on has its job within the hour.
const UNNAMED_FOR: Duration = Duration::from_secs(3600);

/// The folder of files. Clones share.
#[derive(Debug, Clone)]
pub struct Files {
    folder: PathBuf,
    store: Store,
}

/// A file that is being written; forgotten unless it is kept.
pub struct NewFile {
    file: tokio::fs::File,
    path: tempfile::TempPath,
    hash: Sha256,
}

impl NewFile {
    /// Appends bytes to the file and to its hash.
    pub async fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        use tokio::io::AsyncWriteExt;
        self.hash.update(bytes);
        self.file.write_all(bytes).await.map_err(unwritable)
    }
}

impl Files {
    /// Opens the folder and creates it if it is missing.
    pub fn in_folder(folder: &Path, store: &Store) -> Result<Self, Error> {
        let files = Self {
            folder: folder.join("files"),
            store: store.clone(),
        };
        std::fs::create_dir_all(files.incoming()).map_err(unwritable)?;
        Ok(files)
    }

    /// Removes what earlier processes left half written; for the one that holds the folder's lock.
    pub fn clear_incoming(&self) -> Result<(), Error> {
        for entry in std::fs::read_dir(self.incoming()).map_err(unwritable)?.flatten() {
            let _ = std::fs::remove_file(entry.path());
        }
        Ok(())
    }

    fn incoming(&self) -> PathBuf {
        self.folder.join("incoming")
    }

    fn place(&self, hash: &str) -> PathBuf {
        self.folder.join(&hash[..2]).join(hash)
    }

    /// Starts a new file under a temporary name.
    pub async fn create(&self) -> Result<NewFile, Error> {
        let incoming = self.incoming();
        let made = tokio::task::spawn_blocking(move || NamedTempFile::new_in(incoming)).await;
        let (file, path) = made.map_err(|e| unwritable(e.into()))?.map_err(unwritable)?.into_parts();
        Ok(NewFile {
            file: tokio::fs::File::from_std(file),
            path,
            hash: Sha256::new(),
        })
    }

    /// Gives the file its name, which it hands back. It is on the disk then.
    pub async fn keep(&self, mut new: NewFile) -> Result<String, Error> {
        use tokio::io::AsyncWriteExt;
        new.file.flush().await.map_err(unwritable)?;
        new.file.sync_all().await.map_err(unwritable)?;
        let hash = hex(&new.hash.finalize());
        if self.store.dialect == Dialect::Postgres {
            self.upload(&hash, &new.path).await?;
        }
        let (place, path) = (self.place(&hash), new.path);
        let moved = tokio::task::spawn_blocking(move || {
            let folder = place.parent().expect("files are in folders");
            std::fs::create_dir_all(folder)?;
            path.persist(&place).map_err(|e| e.error)?;
            // The name is in the folder: that too has to be on the disk.
            std::fs::File::open(folder)?.sync_all()
        });
        moved.await.map_err(|e| unwritable(e.into()))?.map_err(unwritable)?;
        Ok(hash)
    }

    /// Stores `content` and returns its SHA-256 in hexadecimal, which is its name.
    pub async fn put(&self, content: &[u8]) -> Result<String, Error> {
        let mut new = self.create().await?;
        new.write(content).await?;
        self.keep(new).await
    }

    /// Where the file is on this machine; fetched from the database if need be.
    pub async fn path(&self, hash: &str) -> Result<PathBuf, Error> {
        let place = self.place(hash);
        if tokio::fs::try_exists(&place).await.unwrap_or(false) {
            return Ok(place);
        }
        if self.store.dialect == Dialect::Postgres {
            self.fetch(hash).await?;
            return Ok(place);
        }
        Err(missing(hash))
    }

    /// Reads the file of this SHA-256; with PostgreSQL it is fetched from the database if the folder lacks it.
    pub async fn read(&self, hash: &str) -> Result<Vec<u8>, Error> {
        let path = self.path(hash).await?;
        tokio::fs::read(path).await.map_err(|e| {
            tracing::error!(file = hash, error = %e, "a stored file cannot be read");
            missing(hash)
        })
    }

    async fn upload(&self, hash: &str, path: &Path) -> Result<(), Error> {
        let mut file = tokio::fs::File::open(path).await.map_err(unwritable)?;
        let mut transaction = self.store.begin().await?;
        for part in 0i64.. {
            let mut content = Vec::with_capacity(PART);
            let read = (&mut file)
                .take(PART as u64)
                .read_to_end(&mut content)
                .await
                .map_err(unwritable)?;
            if read == 0 && part > 0 {
                break;
            }
            sqlx::query(
                "INSERT INTO file_parts (hash, part, content, written_us) VALUES ($1, $2, $3, $4) \
                 ON CONFLICT (hash, part) DO UPDATE SET written_us = EXCLUDED.written_us",
            )
            .bind(hash)
            .bind(part)
            .bind(content)
            .bind(now_us())
            .execute(&mut *transaction)
            .await
            .map_err(unavailable)?;
        }
        transaction.commit().await.map_err(unavailable)
    }

    async fn fetch(&self, hash: &str) -> Result<(), Error> {
        let mut new = self.create().await?;
        for part in 0i64.. {
            let row = sqlx::query("SELECT content FROM file_parts WHERE hash = $1 AND part = $2")
                .bind(hash)
                .bind(part)
                .fetch_optional(&self.store.pool)
                .await
                .map_err(unavailable)?;
            let Some(row) = row else { break };
            let content: Vec<u8> = row.try_get("content").map_err(unavailable)?;
            new.write(&content).await?;
        }
        if hex(&new.hash.clone().finalize()) != hash {
            return Err(missing(hash));
        }
        use tokio::io::AsyncWriteExt;
        new.file.flush().await.map_err(unwritable)?;
        let place = self.place(hash);
        std::fs::create_dir_all(place.parent().expect("files are in folders")).map_err(unwritable)?;
        new.path.persist(place).map_err(|e| unwritable(e.error))
    }

    /// Every file that a job names.
    pub(super) async fn named(&self) -> Result<HashSet<String>, Error> {
        let rows = sqlx::query("SELECT DISTINCT hash FROM job_files")
            .fetch_all(&self.store.pool)
            .await
            .map_err(unavailable)?;
        rows.iter().map(|row| row.try_get("hash").map_err(unavailable)).collect()
    }

    /// Removes old files that no job names.
    pub async fn sweep(&self) -> Result<usize, Error> {
        let limit = SystemTime::now() - UNNAMED_FOR;
        let named = self.named().await?;
        if self.store.dialect == Dialect::Postgres {
            let before = now_us() - UNNAMED_FOR.as_micros() as i64;
            sqlx::query("DELETE FROM file_parts WHERE written_us < $1 AND hash NOT IN (SELECT hash FROM job_files)")
                .bind(before)
                .execute(&self.store.pool)
                .await
                .map_err(unavailable)?;
        }
        let folder = self.folder.clone();
        let swept = tokio::task::spawn_blocking(move || sweep(&folder, &named, limit)).await;
        swept.map_err(|e| unwritable(e.into()))
    }

    /// Whether a file can be written, by writing one.
    pub async fn probe(&self) -> Result<(), Error> {
        let mut new = self.create().await?;
        new.write(Uuid::new_v4().as_bytes()).await?;
        use tokio::io::AsyncWriteExt;
        new.file.flush().await.map_err(unwritable)
    }
}

fn sweep(folder: &Path, named: &HashSet<String>, limit: SystemTime) -> usize {
    let entries = |path: &Path| std::fs::read_dir(path).into_iter().flatten().flatten();
    let mut swept = 0;
    for shelf in entries(folder).filter(|e| e.file_name() != "incoming") {
        for file in entries(&shelf.path()) {
            let old = file
                .metadata()
                .and_then(|m| m.modified())
                .is_ok_and(|written| written < limit);
            let unnamed = file.file_name().to_str().is_none_or(|name| !named.contains(name));
            swept += usize::from(old && unnamed && std::fs::remove_file(file.path()).is_ok());
        }
    }
    swept
}

/// Lower-case hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// SHA-256 in lower-case hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn missing(hash: &str) -> Error {
    Error::new(Code::Internal, format!("the stored file {hash} is missing or damaged"))
        .with_hint("restore the data folder from a backup")
}

fn unwritable(e: std::io::Error) -> Error {
    tracing::error!(error = %e, "a file cannot be written");
    let detail = match e.kind() {
        std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => "the disk is full".to_string(),
        _ => format!("a file cannot be written: {e}"),
    };
    Error::new(Code::StorageUnavailable, detail).with_hint("nothing was kept; try again later")
}
