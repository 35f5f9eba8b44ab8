//! Excitation requests.

mod search;
mod spec;
#[cfg(test)]
mod tests;

pub use search::Search;
pub use spec::criterion_name;

use self::search::read_search;
use self::spec::{read_fundamentals, read_spec};
use crate::documents::cursor::{Cursor, Findings};
use crate::documents::effect_list::{read_effects, with_definitions};
use crate::documents::knowledge::{DesignModel, DesignTerms, read_design_model, read_knowledge};
use crate::documents::requests;
use crate::documents::robot::{NamedRobots, RobotDocument, read_robot_or_name};
use crate::documents::warm_start::read_warm_start;
use crate::effects::OwnEffect;
use crate::excitation::{Criterion, Problem, ProblemSpec};
use crate::formats::json::Parsed;
use crate::model::FieldProblem;
use crate::trajectory::FourierSeries;
use serde_json::Value;
use std::sync::Arc;

/// A checked request: the problem, how to search, and the document it came from.
#[derive(Debug, Clone)]
pub struct ExcitationRequest {
    /// With the first of the fundamentals.
    pub problem: Problem,
    /// Fundamentals to choose from (Hz).
    pub fundamentals: Vec<f64>,
    /// Trajectories that complement each other.
    pub trajectories: usize,
    /// Factor on the amplitudes of a first run.
    pub backoff: Option<f64>,
    /// What the columns beside the regressor's are of.
    pub effects: DesignTerms,
    /// Effects with formulas of their own, of the robot and of the request.
    pub own: Vec<Arc<OwnEffect>>,
    /// Budget, starts and seed of the search.
    pub search: Search,
    /// An earlier trajectory to go on from.
    pub earlier: Option<FourierSeries>,
    /// What a user should know about how the robot was read.
    pub notes: Vec<String>,
    /// The request as it was made.
    pub document: Value,
}

/// Each is a search of its own.
const MOST_TRAJECTORIES: u64 = 10;

impl ExcitationRequest {
    /// Whether it is one search on one problem.
    pub fn is_single(&self) -> bool {
        self.fundamentals.len() == 1 && self.trajectories == 1
    }
}

/// Reads a request; `robot` replaces or adds to the one in the document.
///
/// # Errors
/// Everything that is wrong with the request: its own fields, its robot, and what does not fit together.
pub fn read_excitation_request(parsed: &Parsed, known: &dyn NamedRobots) -> Result<ExcitationRequest, Vec<FieldProblem>> {
    let findings = Findings::new(parsed.problems.clone());
    let read = read(&Cursor::root(&parsed.value, &findings), known);
    match read {
        Some(request) if findings.is_empty() => Ok(request),
        _ => Err(findings.into_list()),
    }
}

/// Limits in space need shapes of links: where nobody described any, those along the kinematics, with a note.
fn give_shape(spec: &mut ProblemSpec) -> Option<String> {
    let (shaped, joints) = spec.robot.with_shape();
    spec.robot = shaped;
    let named = joints.join(", ");
    (!joints.is_empty()).then(|| {
        format!(
            "no link of the robot has a shape: capsules from joint to joint stand in for the links of {named}; give `geometry` where the arm comes close to anything"
        )
    })
}

fn read(cursor: &Cursor, known: &dyn NamedRobots) -> Option<ExcitationRequest> {
    let fields = cursor.fields_of::<requests::ExcitationRequest>()?;
    let model = read_design_model(&fields, known);
    // The model brings its robot along.
    let robot = match (&model, fields.nullable("robot")) {
        (Some(model), None) => Some(RobotDocument {
            robot: model.robot.clone(),
            notes: Vec::new(),
            effects: Vec::new(),
        }),
        // What is wrong with the model is said already.
        (None, None) if fields.nullable("model").is_some() => None,
        _ => fields.required("robot").and_then(|c| read_robot_or_name(&c, known)),
    };
    let mut notes = robot.as_ref().map(|r| r.notes.clone()).unwrap_or_default();
    let has_robot = robot.is_some();
    let mut own = robot.as_ref().map(|r| r.effects.clone()).unwrap_or_default();
    let of_request = read_effects(&fields, robot.as_ref().map(|r| &r.robot), &own, known);
    let document = with_definitions(cursor.value(), &of_request, &own);
    own.extend(of_request);
    let search = read_search(&fields);
    let joints = robot.as_ref().map(|r| r.robot.joint_count());
    let earlier = fields.nullable("warm_start").and_then(|c| read_warm_start(&c, joints));
    let fundamentals = read_fundamentals(&fields);
    let backoff = fields.nullable("backoff").and_then(|c| read_backoff(&c));
    let trajectories = fields.nullable("trajectories").and_then(|c| c.whole(1, MOST_TRAJECTORIES));
    let (knowledge, effects) = match &robot {
        Some(robot) => read_knowledge(&fields, known, &robot.robot, model.as_ref()),
        None => Default::default(),
    };
    let mut spec = read_spec(&fields, robot.map(|r| r.robot), fundamentals.first().copied());
    if spec.torque_noise.is_none() {
        spec.torque_noise = model.as_ref().and_then(|m| noise_of(m, spec.sample_rate_hz));
    }
    if knowledge.rivals.is_none() && fields.has("rivals") && spec.criterion == Criterion::RivalEvidence {
        // What is wrong with the rivals is among the findings; the rest is still checked.
        spec.criterion = Criterion::ConditionNumber;
    }
    spec.knowledge = knowledge;
    if spec.space.is_some() {
        notes.extend(give_shape(&mut spec));
    }
    let problem = match Problem::new(spec) {
        Ok(problem) => problem,
        Err(e) => {
            cursor
                .findings()
                .merge(e.0.into_iter().filter_map(|p| placed(p, cursor.value(), has_robot)));
            return None;
        }
    };
    for (i, &fundamental_hz) in fundamentals.iter().enumerate().skip(1) {
        let other = ProblemSpec {
            fundamental_hz,
            ..problem.spec().clone()
        };
        if let Err(e) = Problem::new(other) {
            let of_list = |p: FieldProblem| FieldProblem::new(format!("/fourier/fundamental_hz/{i}"), p.detail);
            cursor.findings().merge(e.0.into_iter().map(of_list));
        }
    }
    Some(ExcitationRequest {
        fundamentals: match fundamentals.is_empty() {
            true => vec![problem.spec().fundamental_hz],
            false => fundamentals,
        },
        trajectories: trajectories.unwrap_or(1) as usize,
        backoff,
        effects,
        own,
        problem,
        search,
        earlier,
        notes,
        document,
    })
}

/// What the core says about a stand-in robot is dropped; about a robot called by name or read from XML it is said of that field.
fn placed(problem: FieldProblem, request: &Value, has_robot: bool) -> Option<FieldProblem> {
    let of_robot = problem.pointer.starts_with("/robot");
    let per_joint = [
        "/robot",
        "/constraints/start_position",
        "/constraints/torque",
        "/torque_noise",
        "/fourier/harmonics",
    ];
    if !has_robot && per_joint.iter().any(|p| problem.pointer.starts_with(p)) {
        return None;
    }
    let pointer = match (of_robot, &request["robot"]) {
        (true, Value::String(_)) => "/robot".to_string(),
        (true, robot) if robot.get("urdf").is_some() => "/robot/urdf".to_string(),
        (true, robot) if robot.get("mjcf").is_some() => "/robot/mjcf".to_string(),
        _ => problem.pointer.clone(),
    };
    Some(FieldProblem { pointer, ..problem })
}

/// The noise of the data that a model is of, as white noise at another rate that hides slow signals as much.
fn noise_of(model: &DesignModel, rate_hz: f64) -> Option<Vec<f64>> {
    let (std_dev, rows_hz) = model.read.noise.as_ref()?;
    Some(std_dev.iter().map(|s| s * (rate_hz / rows_hz).sqrt()).collect())
}

fn read_backoff(cursor: &Cursor) -> Option<f64> {
    let factor = cursor.number()?;
    if !(factor > 0.0 && factor <= 1.0) {
        cursor.complain(format!(
            "is {factor}; a first run has a factor above 0 and at most 1 on its amplitudes"
        ));
    }
    Some(factor)
}
