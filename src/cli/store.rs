//! `dynident audit`, `dynident backup` and `dynident restore`: the stored data without the server.

use super::settings::{Place, Settings};
use super::{Ending, files};
use crate::app::{Code, Error};
use crate::service::store::{AuditEntry, Files, Store, backup, restore, rfc3339};
use crate::service::{Service, log_to_stderr};
use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct AuditArguments {
    /// At most so many of the newest entries.
    #[arg(long, default_value_t = 100)]
    last: usize,
    #[command(flatten)]
    place: Place,
}

#[derive(Debug, clap::Args)]
pub struct BackupArguments {
    /// The archive (tar).
    file: PathBuf,
    #[command(flatten)]
    place: Place,
}

/// Runs a command that needs the database.
pub(super) fn run_async(work: impl Future<Output = Result<(), Error>>) -> Result<Ending, Error> {
    log_to_stderr("warn", false);
    let runtime = tokio::runtime::Runtime::new().map_err(|e| Error::new(Code::Internal, format!("cannot start: {e}")))?;
    runtime.block_on(work)?;
    Ok(Ending::Done)
}

/// The database; a server may use it at the same time.
pub(super) async fn open_store(settings: &Settings) -> Result<Store, Error> {
    let config = settings.config()?;
    match &config.database_url {
        Some(url) => Store::at(url).await,
        None => {
            let folder = config.data.unwrap_or_default();
            let unusable = |e| {
                Error::new(
                    Code::StorageUnavailable,
                    format!("the data folder {} cannot be used: {e}", folder.display()),
                )
            };
            std::fs::create_dir_all(&folder).map_err(unusable)?;
            Store::in_folder(&folder.canonicalize().map_err(unusable)?).await
        }
    }
}

/// Writes what was done on the command line into the audit log.
pub(super) async fn note(store: &Store, action: &str, robot: &str, target: &str) -> Result<(), Error> {
    let entry = AuditEntry {
        at_us: 0,
        request: String::new(),
        token: String::new(),
        who: "command line".to_string(),
        action: action.to_string(),
        robot: robot.to_string(),
        target: target.to_string(),
    };
    store.note(&entry).await
}

/// Who did what.
pub fn run_audit(arguments: &AuditArguments, json: bool) -> Result<Ending, Error> {
    let settings = arguments.place.settings(&Settings::default())?;
    run_async(async {
        let entries = open_store(&settings).await?.audit(arguments.last).await?;
        if json {
            return files::print(&files::pretty(&entries));
        }
        let line = |e: &AuditEntry| {
            let at = rfc3339(e.at_us);
            format!("{at}  {}  {}  {}  {}  {}\n", e.who, e.action, e.robot, e.target, e.request)
        };
        files::print(&entries.iter().map(line).collect::<String>())
    })
}

/// Writes a backup beside the target and renames it when it is whole.
pub fn run_backup(arguments: &BackupArguments) -> Result<Ending, Error> {
    let settings = arguments.place.settings(&Settings::default())?;
    run_async(async {
        let store = open_store(&settings).await?;
        let kept = Files::in_folder(&settings.config()?.data.unwrap_or_default(), &store)?;
        let path = &arguments.file;
        let unwritable = |e: std::io::Error| Error::new(Code::FileUnwritable, format!("cannot write {}: {e}", path.display()));
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let part = tempfile::NamedTempFile::new_in(folder).map_err(unwritable)?;
        let amount = backup(&store, &kept, BufWriter::new(part.as_file())).await?;
        part.as_file().sync_all().map_err(unwritable)?;
        part.persist(path).map_err(|e| unwritable(e.error))?;
        files::print(&format!("{} rows and {} files\n", amount.rows, amount.files))
    })
}

/// Fills an empty data folder or database from a backup.
pub fn run_restore(arguments: &BackupArguments) -> Result<Ending, Error> {
    let settings = arguments.place.settings(&Settings::default())?;
    run_async(async {
        let path = &arguments.file;
        let unreadable = |e| Error::new(Code::FileUnreadable, format!("cannot read {}: {e}", path.display()));
        let archive = BufReader::new(File::open(path).map_err(unreadable)?);
        // Takes the folder: a server that uses it is refused, and refuses.
        let service = Service::open(settings.config()?).await?;
        let amount = restore(service.store(), service.files(), archive).await?;
        note(service.store(), "restore", "", "").await?;
        files::print(&format!("{} rows and {} files\n", amount.rows, amount.files))
    })
}
