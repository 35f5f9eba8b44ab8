//! What the handlers share.

use super::config::Config;
use super::jobs::Jobs;
use crate::app::{Code, Error};
use crate::io::shipped::{ROBOTS, Shipped};
use crate::io::{NamedRobots, RobotDocument};
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError, RwLock};

/// The service: configuration, robots, jobs. Clones share.
#[derive(Clone)]
pub struct Service(Arc<Inner>);

struct Inner {
    config: Config,
    robots: RwLock<BTreeMap<String, LabRobot>>,
    jobs: Jobs,
}

/// A robot of the lab, as it was given and as it was read.
#[derive(Debug, Clone)]
pub struct LabRobot {
    pub document: Value,
    pub read: RobotDocument,
}

/// A robot in the list.
#[derive(Debug, Clone)]
pub struct ListedRobot {
    pub id: String,
    pub shipped: bool,
    pub read: RobotDocument,
}

impl Service {
    /// Starts the workers; needs a running tokio runtime.
    pub fn start(config: Config) -> Self {
        let jobs = Jobs::start(&config);
        Self(Arc::new(Inner {
            config,
            robots: RwLock::default(),
            jobs,
        }))
    }

    pub fn config(&self) -> &Config {
        &self.0.config
    }

    pub(super) fn jobs(&self) -> &Jobs {
        &self.0.jobs
    }

    pub(super) fn list_robots(&self) -> Vec<ListedRobot> {
        let shipped = ROBOTS.iter().filter_map(|(id, _)| {
            Some(ListedRobot {
                id: id.to_string(),
                shipped: true,
                read: Shipped.named(id)?,
            })
        });
        let robots = self.read_robots();
        let lab = robots.iter().map(|(id, robot)| ListedRobot {
            id: id.clone(),
            shipped: false,
            read: robot.read.clone(),
        });
        shipped.chain(lab).collect()
    }

    fn read_robots(&self) -> std::sync::RwLockReadGuard<'_, BTreeMap<String, LabRobot>> {
        // The map is whole at every moment: a panic elsewhere while it was locked does not spoil it.
        self.0.robots.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write_robots(&self) -> std::sync::RwLockWriteGuard<'_, BTreeMap<String, LabRobot>> {
        self.0.robots.write().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn robot(&self, id: &str) -> Result<LabRobot, Error> {
        if let Some((_, text)) = ROBOTS.iter().find(|(known, _)| *known == id) {
            let document = serde_json::from_str(text).expect("shipped documents are JSON");
            return Ok(LabRobot {
                document,
                read: Shipped.named(id).expect("listed"),
            });
        }
        self.read_robots().get(id).cloned().ok_or_else(|| unknown_robot(id))
    }

    /// Keeps a robot under `id`; `true` if it is new.
    pub(super) fn put_robot(&self, id: &str, robot: LabRobot, replace: bool) -> Result<bool, Error> {
        refuse_shipped(id)?;
        let mut robots = self.write_robots();
        if !replace && robots.contains_key(id) {
            return Err(Error::new(Code::RobotExists, format!("the robot `{id}` exists")).with_hint("PUT replaces it"));
        }
        Ok(robots.insert(id.to_string(), robot).is_none())
    }

    pub(super) fn remove_robot(&self, id: &str) -> Result<(), Error> {
        refuse_shipped(id)?;
        self.write_robots().remove(id).map(drop).ok_or_else(|| unknown_robot(id))
    }
}

fn unknown_robot(id: &str) -> Error {
    Error::new(Code::UnknownRobot, format!("there is no robot `{id}`")).with_hint("GET /robots lists them")
}

fn refuse_shipped(id: &str) -> Result<(), Error> {
    match ROBOTS.iter().any(|(known, _)| *known == id) {
        true => Err(Error::new(Code::RobotReadOnly, format!("`{id}` comes with the program")).with_hint("use another name")),
        false => Ok(()),
    }
}

impl NamedRobots for Service {
    fn named(&self, name: &str) -> Option<RobotDocument> {
        self.robot(name).ok().map(|r| r.read)
    }

    fn names(&self) -> Vec<String> {
        self.list_robots().into_iter().map(|r| r.id).collect()
    }
}
