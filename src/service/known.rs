//! What a request calls by name, looked up before it is read and kept with the job: what becomes of the robot later does not
//! matter to a job that has been accepted.

use super::access::Access;
use super::blocking::read_stored;
use super::state::Service;
use crate::app::{Code, Error};
use crate::documents::shipped::{ROBOTS, Shipped};
use crate::documents::{MOST_GIVEN, NamedExcitations, NamedRobots, RobotDocument, effects_named, robot_document_of};
use crate::formats::Parsed;
use crate::model::FieldProblem;
use crate::service::store::State;
use crate::service::work::JobKind;
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
    /// Definitions of the effects of the catalogue that the request or a robot of it names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    effects: BTreeMap<String, Value>,
    /// The robot that the model of the request is of.
    #[serde(skip)]
    owner: Option<String>,
    /// All robots that the request might have named, for proposals.
    #[serde(skip)]
    names: Vec<String>,
    /// All effects that the request might have named, for proposals; empty where it names none.
    #[serde(skip)]
    effect_names: Vec<String>,
}

/// The robot that a request names.
pub fn robot_named(request: &Value) -> Option<&str> {
    let places = [&request["robot"], &request["model"]["robot"], &request["model"]];
    places.into_iter().find_map(Value::as_str)
}

/// Every robot that a request names: that of a model, and of data that are given, beside its own.
fn robots_named(request: &Value) -> impl Iterator<Item = &str> {
    places(request).filter_map(Value::as_str)
}

/// Where a request may have a robot, or the name of one.
fn places(request: &Value) -> impl Iterator<Item = &Value> {
    let own = [&request["robot"], &request["model"]["robot"], &request["model"]];
    own.into_iter().chain(given(request).map(|g| &g["robot"]))
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
        known.look_up_effects(request, service).await?;
        Ok(known)
    }

    /// Looks up the effects that the document of a robot names.
    pub async fn for_robot(robot: &Value, service: &Service) -> Result<Self, Error> {
        let mut known = Self::default();
        known.look_up_effects(robot, service).await?;
        Ok(known)
    }

    /// All robots and effects that the request might have called, for proposals.
    pub fn all_names(&self) -> [&[String]; 2] {
        [&self.names, &self.effect_names]
    }

    /// The same with all robots and effects that the request might have called.
    pub fn among(self, [names, effect_names]: [Vec<String>; 2]) -> Self {
        Self {
            names,
            effect_names,
            ..self
        }
    }

    /// The robot whose model the request calls by the id of its identification.
    pub fn owner(&self) -> Option<&str> {
        self.owner.as_deref()
    }

    /// Effects of the catalogue that a document, a robot that stands in it, or one that it names has by name.
    async fn look_up_effects(&mut self, document: &Value, service: &Service) -> Result<(), Error> {
        let inside = places(document).chain([document]);
        let named: BTreeSet<String> = inside
            .chain(self.robots.values())
            .flat_map(effects_named)
            .map(str::to_string)
            .collect();
        if named.is_empty() {
            return Ok(());
        }
        self.effect_names = service.store().effect_names().await?;
        for name in named {
            match service.effect(&name).await {
                Ok(definition) => drop(self.effects.insert(name, definition)),
                // The reader of the request says so, with the place.
                Err(e) if matches!(e.code, Code::UnknownEffect | Code::EffectUnreadable) => {}
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }

    fn read_robot(&self, name: &str) -> Option<Result<RobotDocument, Vec<FieldProblem>>> {
        let parsed = Parsed {
            value: self.robots.get(name)?.clone(),
            problems: Vec::new(),
        };
        Some(robot_document_of(&parsed, self))
    }

    /// Identifications and designs that a design continues from.
    async fn look_up_data(&mut self, request: &Value, service: &Service, access: &Access) -> Result<(), Error> {
        let own = std::iter::once((true, &request["model"]));
        for (of_request, value) in own.chain(given(request).map(|g| (false, g))) {
            if let Some(id) = value["identification"].as_str()
                && let Some(job) = service.find_job(id, access).await?
                && let Some(hash) = job.model.as_ref().filter(|_| job.kind == JobKind::Identification)
            {
                let files: Value = read_stored(service.files().read(hash).await?).await.unwrap_or_default();
                self.models.insert(id.to_string(), files["json"].clone());
                if of_request {
                    self.owner = Some(job.robot);
                }
            }
            if let Some(id) = value["excitation"].as_str()
                && let Some(job) = service.find_job(id, access).await?
                && let Some(hash) = job.result.as_ref().filter(|_| job.kind == JobKind::Excitation)
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
        .filter(|_| job.kind == JobKind::Excitation && job.state != State::Failed)
    else {
        return Ok(None);
    };
    let design: Value = read_stored(service.files().read(&hash).await?).await.unwrap_or_default();
    let order = design["coefficients"]["a"][0].as_array().map(Vec::len);
    Ok(design["period_s"].as_f64().zip(order))
}

impl NamedRobots for Known {
    fn named(&self, name: &str) -> Option<RobotDocument> {
        self.read_robot(name)?.ok()
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

    fn effect(&self, name: &str) -> Option<Value> {
        self.effects.get(name).cloned()
    }

    fn effect_names(&self) -> Vec<String> {
        self.effect_names.clone()
    }

    fn fault(&self, name: &str) -> Option<FieldProblem> {
        self.read_robot(name)?.err()?.into_iter().next()
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
