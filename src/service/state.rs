//! What the handlers share.

use super::access::Access;
use super::blocking::places;
use super::child::{Children, Limits};
use super::config::Config;
use super::folder::DataFolder;
use super::known::{is_shipped, shipped, shipped_names};
use super::metrics::Metrics;
use super::store::{Files, Store};
use crate::app::{CancelFlag, Code, Error};
use serde_json::Value;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{Notify, Semaphore, broadcast};

/// The service: configuration, database, files, and what this process does just now. Clones share.
#[derive(Clone)]
pub struct Service(Arc<Inner>);

struct Inner {
    config: Config,
    folder: DataFolder,
    store: Store,
    files: Files,
    children: Children,
    metrics: Metrics,
    /// Ids of jobs that changed in this process. Those that changed elsewhere are found by looking.
    changes: broadcast::Sender<Arc<str>>,
    /// Notified when there is work.
    work: Notify,
    /// Jobs that run here.
    running: Mutex<HashMap<String, CancelFlag>>,
    closing: AtomicBool,
    /// One permit for every job that runs here; closing takes them all.
    idle: Semaphore,
    /// Places for what requests wait for themselves.
    interactive: Arc<Semaphore>,
}

/// Changes that a slow listener may fall behind before it looks at the database instead.
const CHANGES_KEPT: usize = 1024;
/// More jobs than any machine runs at the same time.
const PLACES: usize = 10_000;

impl Service {
    /// Opens data folder and database.
    ///
    /// # Errors
    /// Either cannot be used.
    pub async fn open(config: Config) -> Result<Self, Error> {
        let folder = DataFolder::take(config.data.as_deref())?;
        let store = match &config.database_url {
            Some(url) => Store::at(url).await?,
            None => Store::in_folder(folder.path()).await?,
        };
        let files = Files::in_folder(folder.path(), &store)?;
        files.clear_incoming()?;
        let again = store.release_all_of(&folder.worker).await?;
        if again > 0 {
            tracing::warn!(jobs = again, "jobs that the last process left unfinished are done again");
        }
        Ok(Self(Arc::new(Inner {
            children: Children::new(Limits::from_config(&config)),
            config,
            folder,
            store,
            files,
            metrics: Metrics::default(),
            changes: broadcast::channel(CHANGES_KEPT).0,
            work: Notify::new(),
            running: Mutex::default(),
            closing: AtomicBool::new(false),
            idle: Semaphore::new(PLACES),
            interactive: Arc::new(Semaphore::new(places())),
        })))
    }

    /// The settings that the server was started with.
    pub fn config(&self) -> &Config {
        &self.0.config
    }

    /// The database.
    pub fn store(&self) -> &Store {
        &self.0.store
    }

    /// The files of the data folder.
    pub fn files(&self) -> &Files {
        &self.0.files
    }

    /// The processes that compute.
    pub(super) fn children(&self) -> &Children {
        &self.0.children
    }

    pub(super) fn metrics(&self) -> &Metrics {
        &self.0.metrics
    }

    /// Name of this process among workers.
    pub(super) fn worker(&self) -> &str {
        &self.0.folder.worker
    }

    /// Whether nothing outlives the process.
    pub(super) fn is_temporary(&self) -> bool {
        self.0.folder.is_temporary()
    }

    pub(super) fn changes(&self) -> &broadcast::Sender<Arc<str>> {
        &self.0.changes
    }

    /// Tells whoever follows the job.
    pub(super) fn changed(&self, id: &str) {
        // Nobody follows: then nobody has to be notified.
        let _ = self.0.changes.send(id.into());
    }

    pub(super) fn work(&self) -> &Notify {
        &self.0.work
    }

    pub(super) fn idle(&self) -> &Semaphore {
        &self.0.idle
    }

    pub(super) fn interactive(&self) -> Arc<Semaphore> {
        self.0.interactive.clone()
    }

    pub(super) fn running(&self) -> MutexGuard<'_, HashMap<String, CancelFlag>> {
        // The map is whole at every moment.
        self.0.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes no further jobs; those that run here end, or go back into the queue where that outlives the process.
    pub fn close(&self) {
        self.0.closing.store(true, Ordering::SeqCst);
        self.running().values().for_each(CancelFlag::cancel);
        self.0.work.notify_waiters();
    }

    /// Whether the server is shutting down and takes no more jobs.
    pub fn is_closing(&self) -> bool {
        self.0.closing.load(Ordering::SeqCst)
    }

    /// Resolves when no job runs here any more.
    pub async fn drained(&self) {
        let _ = self.0.idle.acquire_many(PLACES as u32).await;
    }

    /// Writes the audit log.
    pub(super) async fn note(&self, access: &Access, action: &str, robot: &str, target: &str) -> Result<(), Error> {
        self.store().note(&access.entry(action, robot, target)).await
    }

    /// Names of all robots that `access` sees.
    pub(super) async fn robot_names(&self, access: &Access) -> Result<Vec<String>, Error> {
        let lab = self.store().robots().await?;
        let seen = lab.into_iter().filter(|id| access.sees(id));
        Ok(shipped_names().into_iter().chain(seen).collect())
    }

    /// Document of a robot, if `access` sees it; those that come with the program are everybody's.
    pub(super) async fn robot(&self, id: &str, access: &Access) -> Result<Value, Error> {
        if let Some(document) = shipped(id) {
            return Ok(document);
        }
        let kept = match access.sees(id) {
            true => self.store().robot(id).await?,
            false => None,
        };
        kept.ok_or_else(|| unknown_robot(id))
    }

    /// Keeps a robot under `id`; `true` if it is new.
    pub(super) async fn put_robot(&self, id: &str, robot: &Value, replace: bool, access: &Access) -> Result<bool, Error> {
        refuse_shipped(id)?;
        if !access.sees(id) {
            return Err(unknown_robot(id));
        }
        let kept = self.store().put_robot(id, robot, replace).await?;
        let exists = || Error::new(Code::RobotExists, format!("the robot `{id}` exists")).with_hint("PUT replaces it");
        let new = kept.ok_or_else(exists)?;
        self.note(access, "put_robot", id, id).await?;
        Ok(new)
    }

    pub(super) async fn remove_robot(&self, id: &str, access: &Access) -> Result<(), Error> {
        refuse_shipped(id)?;
        if !access.sees(id) || !self.store().remove_robot(id).await? {
            return Err(unknown_robot(id));
        }
        self.note(access, "delete_robot", id, id).await
    }
}

fn unknown_robot(id: &str) -> Error {
    Error::new(Code::UnknownRobot, format!("there is no robot `{id}`")).with_hint("GET /robots lists them")
}

fn refuse_shipped(id: &str) -> Result<(), Error> {
    match is_shipped(id) {
        true => Err(Error::new(Code::RobotReadOnly, format!("`{id}` comes with the program")).with_hint("use another name")),
        false => Ok(()),
    }
}
