//! The data folder: one process at a time, which is known by a name of its own.

use crate::app::{Code, Error};
use std::fs::File;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use uuid::Uuid;

/// A data folder that no other process uses.
#[derive(Debug)]
pub struct DataFolder {
    path: PathBuf,
    /// Name of the worker that lives here, the same in every life.
    pub worker: String,
    /// Held as long as the process lives; the system lets go of it even after kill -9.
    _lock: File,
    temporary: Option<TempDir>,
}

impl DataFolder {
    /// Takes the folder, made if it is not there; a temporary one where none is given.
    ///
    /// # Errors
    /// Another process uses it, or it cannot be written.
    pub fn take(path: Option<&Path>) -> Result<Self, Error> {
        let temporary = match path {
            Some(_) => None,
            None => Some(
                tempfile::Builder::new()
                    .prefix("dynident-")
                    .tempdir()
                    .map_err(|e| unusable(Path::new("/tmp"), &e))?,
            ),
        };
        let path = path
            .or(temporary.as_ref().map(TempDir::path))
            .expect("one of them is given")
            .to_path_buf();
        let unusable = |e: std::io::Error| unusable(&path, &e);
        std::fs::create_dir_all(&path).map_err(unusable)?;
        let path = path.canonicalize().map_err(unusable)?;
        let lock = File::create(path.join("lock")).map_err(unusable)?;
        if lock.try_lock().is_err() {
            let detail = format!("another process uses the data folder {}", path.display());
            return Err(Error::new(Code::StorageUnavailable, detail).with_hint("end it, or choose another folder with --data"));
        }
        let worker = worker_name(&path).map_err(unusable)?;
        Ok(Self {
            path,
            worker,
            _lock: lock,
            temporary,
        })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether all of it goes with the process.
    pub fn is_temporary(&self) -> bool {
        self.temporary.is_some()
    }
}

/// What this process is called, as long as the folder is there: so it can take back at once what it held when it was killed.
fn worker_name(folder: &Path) -> std::io::Result<String> {
    let path = folder.join("worker");
    if let Ok(name) = std::fs::read_to_string(&path)
        && !name.trim().is_empty()
    {
        return Ok(name.trim().to_string());
    }
    let host = rustix::system::uname().nodename().to_string_lossy().into_owned();
    let name = format!("{host}-{}", Uuid::new_v4().simple());
    std::fs::write(path, &name)?;
    Ok(name)
}

fn unusable(path: &Path, e: &std::io::Error) -> Error {
    let detail = format!("the data folder {} cannot be used: {e}", path.display());
    Error::new(Code::StorageUnavailable, detail).with_hint("choose another with --data")
}
