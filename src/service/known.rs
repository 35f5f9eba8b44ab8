//! What a request calls by name, looked up before it is read and kept with the job: what becomes of the robot later does not matter to
//! a job that has been accepted.

use super::access::Access;
use super::blocking::read_stored;
use super::state::Service;
use crate::app::{Code, Error};
use crate::documents::shipped::{ROBOTS, Shipped};
use crate::documents::{MOST_GIVEN, NamedExcitations, NamedRobots, RobotDocument, robot_document};
use crate::formats::Parsed;
use crate::service::store::State;
use crate::service::work::Kind;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Robots and excitations by name.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// Documents of the robots that the request names.
    robots: BTreeMap<String, Value>,
    /// `(period_s, order)`.
    excitations: BTreeMap<String, (f64, usize)>,
    /// JSON models of identifications.
    #[serde(default)]
    models: BTreeMap<String, Value>,
    /// What of designs makes their motion.
    #[serde(default)]
    designs: BTreeMap<String, Value>,
    /// The robot that the model of the request is of.
    #[serde(skip)]
    owner: Option<String>,
    /// All robots that the request might have named, for proposals.
    #[serde(skip)]
    names: Vec<String>,
}

/// The robot that a request names.
pub fn robot_named(request: &Value) -> Option<&str> {
    let places = [&request["robot"], &request["model"]["robot"], &request["model"]];
    places.into_iter().find_map(Value::as_str)
}

/// Every robot that a request names: that of a model, and of data that are given, beside its own.
fn robots_named(request: &Value) -> impl Iterator<Item = &str> {
    let given = given(request);
    let places = [&request["robot"], &request["model"]["robot"], &request["model"]];
    places.into_iter().chain(given.map(|g| &g["robot"])).filter_map(Value::as_str)
}

/// Data that are given, as many as are read: a list that is longer is refused, whatever stands in it.
fn given(request: &Value) -> impl Iterator<Item = &Value> {
    request["given"].as_array().into_iter().flatten().take(MOST_GIVEN)
}

/// The robot that stands in a request, by its own name.
pub fn robot_inside(request: &Value) -> Option<&str> {
    let places = [&request["robot"], &request["model"]["robot"], &request["model"]];
    places.into_iter().find_map(|robot| robot["name"].as_str())
}

impl Known {
    /// Looks up what `request` names, as far as `access` sees it.
    pub async fn for_request(request: &Value, service: &Service, access: &Access) -> Result<Self, Error> {
        let mut known = Self {
            names: service.robot_names(access).await?,
            ..Self::default()
        };
        let named: BTreeSet<&str> = robots_named(request).collect();
        for name in named {
            match service.robot(name, access).await {
                Ok(document) => {
                    known.robots.insert(name.to_string(), document);
                }
                // The reader of the request says so, with the place.
                Err(e) if matches!(e.code, Code::UnknownRobot | Code::RobotUnreadable) => {}
                Err(e) => return Err(e),
            }
        }
        if let Some(id) = request["excitation"].as_str()
            && let Some(found) = excitation(id, service, access).await?
        {
            known.excitations.insert(id.to_string(), found);
        }
        known.look_up_data(request, service, access).await?;
        Ok(known)
    }

    /// All names that the request might have called, for proposals.
    pub fn all_names(&self) -> &[String] {
        &self.names
    }

    /// The same with all names that the request might have called.
    pub fn among(self, names: Vec<String>) -> Self {
        Self { names, ..self }
    }

    /// The robot whose model the request calls by the id of its identification.
    pub fn owner(&self) -> Option<&str> {
        self.owner.as_deref()
    }

    /// Identifications and designs that a design goes on from.
    async fn look_up_data(&mut self, request: &Value, service: &Service, access: &Access) -> Result<(), Error> {
        let own = std::iter::once((true, &request["model"]));
        for (of_request, value) in own.chain(given(request).map(|g| (false, g))) {
            if let Some(id) = value["identification"].as_str()
                && let Some(job) = service.find_job(id, access).await?
                && let Some(hash) = job.model.as_ref().filter(|_| job.kind == Kind::Identification)
            {
                let files: Value = read_stored(service.files().read(hash).await?).await.unwrap_or_default();
                self.models.insert(id.to_string(), files["json"].clone());
                if of_request {
                    self.owner = Some(job.robot);
                }
            }
            if let Some(id) = value["excitation"].as_str()
                && let Some(job) = service.find_job(id, access).await?
                && let Some(hash) = job.result.as_ref().filter(|_| job.kind == Kind::Excitation)
            {
                let design: Value = read_stored(service.files().read(hash).await?).await.unwrap_or_default();
                let part = |name: &str| (name.to_string(), design[name].clone());
                let motion = ["coefficients", "offset", "fundamental_hz"].map(part).into_iter().collect();
                self.designs.insert(id.to_string(), Value::Object(motion));
            }
        }
        Ok(())
    }
}

async fn excitation(id: &str, service: &Service, access: &Access) -> Result<Option<(f64, usize)>, Error> {
    let Some(job) = service.find_job(id, access).await? else {
        return Ok(None);
    };
    let Some(hash) = job
        .result
        .filter(|_| job.kind == Kind::Excitation && job.state != State::Failed)
    else {
        return Ok(None);
    };
    let design: Value = read_stored(service.files().read(&hash).await?).await.unwrap_or_default();
    let order = design["coefficients"]["a"][0].as_array().map(Vec::len);
    Ok(design["period_s"].as_f64().zip(order))
}

impl NamedRobots for Known {
    fn named(&self, name: &str) -> Option<RobotDocument> {
        let document = self.robots.get(name)?;
        let parsed = Parsed {
            value: document.clone(),
            problems: Vec::new(),
        };
        robot_document(&parsed).ok()
    }

    fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    fn model(&self, identification: &str) -> Option<Value> {
        self.models.get(identification).cloned()
    }

    fn design(&self, excitation: &str) -> Option<Value> {
        self.designs.get(excitation).cloned()
    }
}

impl NamedExcitations for Known {
    fn excitation(&self, id: &str) -> Option<(f64, usize)> {
        self.excitations.get(id).copied()
    }
}

/// Whether a robot comes with the program.
pub fn is_shipped(id: &str) -> bool {
    ROBOTS.iter().any(|(known, _)| *known == id)
}

/// The document of a robot that comes with the program.
pub fn shipped(id: &str) -> Option<Value> {
    let (_, text) = ROBOTS.iter().find(|(known, _)| *known == id)?;
    serde_json::from_str(text).ok()
}

/// Names of the robots that come with the program.
pub fn shipped_names() -> Vec<String> {
    Shipped.names()
}
