//! Excitation requests.

use super::cursor::{Cursor, Fields, Findings};
use super::json::Parsed;
use super::knowledge_request::{DesignModel, DesignTerms, read_design_model, read_knowledge};
use super::path_limits::{read_space_limits, read_torque_limits};
use super::robot::{NamedRobots, RobotDocument, read_robot_or_name};
use super::warm_start::read_warm_start;
use crate::excitation::{Criterion, Form, Knowledge, Problem, ProblemSpec, SearchOptions, Start};
use crate::model::{FieldProblem, Friction, Joint, JointKind, Limits, Mdh, Robot};
use crate::trajectory::FourierSeries;
use nalgebra::Vector3;
use serde_json::Value;

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
    pub search: Search,
    /// An earlier trajectory to go on from.
    pub earlier: Option<FourierSeries>,
    /// What a user should know about how the robot was read.
    pub notes: Vec<String>,
    /// The request as it was made.
    pub document: Value,
}

/// How long and how widely to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    pub options: SearchOptions,
    /// Time after which the best trajectory found is handed back (s).
    pub time_limit_s: f64,
}

pub const REQUEST_FIELDS: &[&str] = &[
    "robot",
    "fourier",
    "sample_rate_hz",
    "criterion",
    "constraints",
    "torque_noise",
    "search",
    "warm_start",
    "model",
    "rivals",
    "given",
    "periods",
    "trajectories",
    "backoff",
];
pub const FOURIER_FIELDS: &[&str] = &["order", "fundamental_hz", "harmonics"];
pub const CONSTRAINT_FIELDS: &[&str] = &["form", "start", "start_position", "torque", "space"];
pub const SEARCH_FIELDS: &[&str] = &["seed", "starts", "time_limit_s", "max_evaluations", "jobs_per_round"];

pub const CRITERIA: &[(&str, Criterion)] = &[
    ("condition_number", Criterion::ConditionNumber),
    ("scaled_condition_number", Criterion::ScaledConditionNumber),
    ("d_optimality", Criterion::DOptimality),
    ("a_optimality", Criterion::AOptimality),
    ("i_optimality", Criterion::IOptimality),
    ("rival_evidence", Criterion::RivalEvidence),
    // What is recommended, by a name that stays when the recommendation changes.
    ("recommended", RECOMMENDED),
];
/// The name of a criterion in documents.
pub fn criterion_name(criterion: Criterion) -> &'static str {
    CRITERIA
        .iter()
        .find(|(_, known)| *known == criterion)
        .map_or("", |(name, _)| name)
}

/// The criterion that says what an identification is for: torques predicted well wherever the arm may be.
pub const RECOMMENDED: Criterion = Criterion::IOptimality;
pub const FORMS: &[(&str, Form)] = &[("paper", Form::Paper), ("exact", Form::Exact)];
pub const STARTS: &[(&str, Start)] = &[("zero", Start::Zero), ("free", Start::Free)];

/// A day: longer searches are mistakes in the unit.
const LONGEST_SEARCH_S: f64 = 86_400.0;
/// Time limit where neither time nor evaluations are limited: the search ends by itself when it has converged, usually before.
const DEFAULT_TIME_LIMIT_S: f64 = 60.0;
/// Local solves that may wait for each other at the end of a round; beyond this the rounds are too few to learn from each other.
const MOST_JOBS: u64 = 1024;
/// Largest whole number that every JSON program carries exactly.
const LARGEST_SEED: u64 = (1 << 53) - 1;
/// Each is a search of its own.
const MOST_FUNDAMENTALS: usize = 16;
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

fn read(cursor: &Cursor, known: &dyn NamedRobots) -> Option<ExcitationRequest> {
    let fields = cursor.fields(REQUEST_FIELDS)?;
    let model = read_design_model(&fields, known);
    // The model brings its robot along.
    let robot = match (&model, fields.nullable("robot")) {
        (Some(model), None) => Some(RobotDocument {
            robot: model.robot.clone(),
            notes: Vec::new(),
        }),
        // What is wrong with the model is said already.
        (None, None) if fields.nullable("model").is_some() => None,
        _ => fields.required("robot").and_then(|c| read_robot_or_name(&c, known)),
    };
    let notes = robot.as_ref().map(|r| r.notes.clone()).unwrap_or_default();
    let has_robot = robot.is_some();
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
        problem,
        search,
        earlier,
        notes,
        document: cursor.value().clone(),
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
        _ => problem.pointer.clone(),
    };
    Some(FieldProblem { pointer, ..problem })
}

/// One fundamental, or a list to choose from.
fn read_fundamentals(fields: &Fields) -> Vec<f64> {
    let fourier = fields.nullable("fourier").filter(|c| c.value().is_object());
    let Some(value) = fourier.and_then(|c| c.value().get("fundamental_hz").cloned()) else {
        return Vec::new();
    };
    match value {
        Value::Array(list) => list.iter().filter_map(Value::as_f64).collect(),
        other => other.as_f64().into_iter().collect(),
    }
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

fn read_spec(fields: &Fields, robot: Option<Robot>, first: Option<f64>) -> ProblemSpec {
    let fourier = fields.required("fourier").and_then(|c| c.fields(FOURIER_FIELDS));
    let order = fourier
        .as_ref()
        .and_then(|f| f.required("order"))
        .and_then(|c| c.whole(0, 1_000_000));
    let asked = fourier.as_ref().and_then(|f| f.required("fundamental_hz"));
    let fundamental = asked.and_then(|c| check_fundamentals(&c, first));
    let harmonics = fourier
        .as_ref()
        .and_then(|f| f.nullable("harmonics"))
        .and_then(|c| read_harmonics(&c));
    let rate = fields.required("sample_rate_hz").and_then(|c| c.number());
    let constraints = fields.optional("constraints").and_then(|c| c.fields(CONSTRAINT_FIELDS));
    let constraint = |name: &str| constraints.as_ref().and_then(|f| f.optional(name));
    // Stand-ins fit what is given, so that the core does not find fault with them: 1000 samples in a period.
    let fundamental_hz = fundamental.or(rate.map(|r| r / 1000.0)).unwrap_or(0.1);
    let names: Option<Vec<String>> = robot.as_ref().map(|r| r.joints().iter().map(|j| j.name.clone()).collect());
    ProblemSpec {
        robot: robot.unwrap_or_else(stand_in_robot),
        order: order.unwrap_or(5) as usize,
        harmonics,
        knowledge: Knowledge::default(),
        fundamental_hz,
        sample_rate_hz: rate.unwrap_or(fundamental_hz * 1000.0),
        criterion: fields
            .optional("criterion")
            .and_then(|c| c.choice(CRITERIA))
            .unwrap_or(Criterion::ConditionNumber),
        form: constraint("form").and_then(|c| c.choice(FORMS)).unwrap_or(Form::Paper),
        start: constraint("start").and_then(|c| c.choice(STARTS)).unwrap_or(Start::Zero),
        start_position: constraints
            .as_ref()
            .and_then(|f| f.nullable("start_position"))
            .and_then(|c| c.numbers(None)),
        torque_noise: fields.nullable("torque_noise").and_then(|c| c.numbers(None)),
        torque: constraints
            .as_ref()
            .and_then(|f| f.nullable("torque"))
            .and_then(|c| read_torque_limits(&c)),
        space: constraints
            .as_ref()
            .and_then(|f| f.nullable("space"))
            .and_then(|c| read_space_limits(&c, names.as_deref())),
    }
}

/// The first of the fundamentals; all of them are checked.
fn check_fundamentals(cursor: &Cursor, first: Option<f64>) -> Option<f64> {
    if !cursor.value().is_array() {
        return cursor.number();
    }
    let list = cursor.numbers(None)?;
    if list.is_empty() || list.len() > MOST_FUNDAMENTALS {
        cursor.complain(format!(
            "has {} values; a search chooses from 1 to {MOST_FUNDAMENTALS}",
            list.len()
        ));
    }
    for (i, value) in list.iter().enumerate().skip(1).filter(|(_, v)| !(v.is_finite() && **v > 0.0)) {
        cursor.findings().push(FieldProblem::new(
            format!("{}/{i}", cursor.pointer()),
            format!("is {value}; it must be a positive number of Hz"),
        ));
    }
    first
}

fn read_harmonics(cursor: &Cursor) -> Option<Vec<Vec<usize>>> {
    let list = |c: &Cursor| -> Option<Vec<usize>> {
        let items = c.items()?;
        items.iter().map(|i| i.whole(1, 1_000_000).map(|n| n as usize)).collect()
    };
    cursor.items()?.iter().map(list).collect()
}

fn read_search(fields: &Fields) -> Search {
    let search = fields.optional("search").and_then(|c| c.fields(SEARCH_FIELDS));
    let field = |name: &str| search.as_ref().and_then(|f| f.nullable(name));
    let time_limit_s = field("time_limit_s").and_then(|c| read_time_limit(&c));
    let max_evaluations = field("max_evaluations").and_then(|c| c.whole(1, LARGEST_SEED));
    let defaults = SearchOptions::default();
    let options = SearchOptions {
        seed: field("seed").and_then(|c| c.whole(0, LARGEST_SEED)).unwrap_or(defaults.seed),
        starts: field("starts")
            .and_then(|c| c.whole(1, 100_000))
            .unwrap_or(defaults.starts as u64) as usize,
        max_evaluations,
        jobs_per_round: field("jobs_per_round")
            .and_then(|c| c.whole(1, MOST_JOBS))
            .unwrap_or(defaults.jobs_per_round as u64) as usize,
        // Time that was asked for is used; time that was not is saved once the search has converged.
        until_halted: time_limit_s.is_some(),
    };
    // A count of evaluations makes a run repeatable; a clock that nobody asked for must not cut it short.
    let unasked = if max_evaluations.is_some() {
        LONGEST_SEARCH_S
    } else {
        DEFAULT_TIME_LIMIT_S
    };
    Search {
        options,
        time_limit_s: time_limit_s.unwrap_or(unasked),
    }
}

fn read_time_limit(cursor: &Cursor) -> Option<f64> {
    let limit = cursor.number()?;
    if !(limit > 0.0 && limit <= LONGEST_SEARCH_S) {
        let detail = format!("is {limit}; a time limit is above zero and at most {LONGEST_SEARCH_S} s");
        cursor.complain(detail);
    }
    Some(limit)
}

/// An arm without fault, in the place of one that could not be read: the rest of the request is still checked.
fn stand_in_robot() -> Robot {
    let mdh = Mdh {
        alpha: 0.0,
        d: 0.0,
        theta: 0.0,
        r: 0.0,
    };
    let limits = Limits {
        velocity: Some(1.0),
        ..Limits::unlimited()
    };
    let joint = Joint::from_mdh("joint", JointKind::Revolute, mdh).with_limits(limits);
    let friction = Friction {
        viscous: true,
        coulomb: true,
    };
    Robot::new("stand-in", Vector3::new(0.0, 0.0, -9.81), vec![joint], friction).expect("has no fault")
}

#[cfg(test)]
mod tests {
    use super::super::json::parse;
    use super::super::shipped::Shipped;
    use super::*;

    fn findings(text: &str) -> Vec<String> {
        let parsed = parse(text.as_bytes()).unwrap();
        read_excitation_request(&parsed, &Shipped)
            .unwrap_err()
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    const GOOD: &str = r#"{"robot": "planar_two_link", "fourier": {"order": 3, "fundamental_hz": 0.2}, "sample_rate_hz": 50}"#;

    #[test]
    fn defaults_are_those_documented() {
        let request = read_excitation_request(&parse(GOOD.as_bytes()).unwrap(), &Shipped).unwrap();
        assert_eq!(request.search.options, SearchOptions::default());
        assert_eq!(request.search.time_limit_s, 60.0);
        let spec = request.problem.spec();
        assert_eq!(
            (spec.form, spec.start, spec.criterion),
            (Form::Paper, Start::Zero, Criterion::ConditionNumber)
        );
    }

    #[test]
    fn all_that_is_wrong_is_found_at_once() {
        let text = r#"{
            "robot": {"name": "x", "gravity": [0, 0, NaN], "joints": [
                {"name": "A1", "kind": "revolut", "mdh": {"alpha": 0, "d": 0, "theta": 0, "r": 0}, "limits": {"position": [-170, 170]}},
                {"name": "A2", "kind": "revolute", "mdh": {"alpha": 0, "d": null, "theta": 0, "r": 0}, "limits": {"position": [2, -2]}},
                {"name": "A2", "kind": "revolute"}]},
            "fourier": {"order": 0, "fundamental": 0.1},
            "sample_rate_hz": -1, "critereon": "x",
            "constraints": {"form": "Paper", "start_position": [0, "1"]},
            "search": {"starts": 0, "time_limit_s": 1e9}}"#;
        let found = findings(text);
        let expected = [
            "/robot/gravity/2: is NaN",
            "/critereon: is not a field of this document (did you mean `criterion`?)",
            "/robot/joints/0/kind: is `revolut` (did you mean `revolute`?)",
            "/robot/joints/0/limits/position: is [-170, 170] rad (limits of revolute joints are in radians; this looks like degrees",
            "/robot/joints/1/mdh/d: is null, expected a number",
            "/robot/joints/1/limits/position: is [2, -2]: the lower limit must be below the upper one (did you mean [-2, 2]?)",
            "/robot/joints/2: has neither `mdh` nor `placement`",
            "/fourier/fundamental: is not a field of this document (did you mean `fundamental_hz`?)",
            "/fourier/fundamental_hz: is missing",
            "/fourier/order: is 0",
            "/sample_rate_hz: is -1",
            "/constraints/form: is `Paper` (did you mean `paper`?)",
            "/constraints/start_position/1: is a string",
            "/search/starts: is 0, expected a whole number from 1 to 100000",
            "/search/time_limit_s: is 1000000000",
        ];
        for text in expected {
            assert!(found.iter().any(|f| f.starts_with(text)), "{text} not among {found:#?}");
        }
        assert_eq!(found.len(), expected.len(), "{found:#?}");
    }

    #[test]
    fn what_does_not_fit_together_is_found() {
        let harmonics = GOOD.replace("50", "1");
        assert!(findings(&harmonics)[0].starts_with("/fourier/order: 3 harmonics need more than 6 samples per period"));
        let start = GOOD.replace(
            "\"sample_rate_hz\"",
            "\"constraints\": {\"start_position\": [0]}, \"sample_rate_hz\"",
        );
        assert!(findings(&start)[0].starts_with("/constraints/start_position: has 1 values, the robot has 2 joints"));
        let noise = GOOD.replace("\"sample_rate_hz\"", "\"torque_noise\": [0, 1], \"sample_rate_hz\"");
        assert!(findings(&noise)[0].starts_with("/torque_noise/0: is 0"));
        let warm = |start: &str| GOOD.replace("\"sample_rate_hz\"", &format!("\"warm_start\": {start}, \"sample_rate_hz\""));
        let rows =
            r#"{"coefficients": {"a": [[1, 2, 3]], "b": [[1, 2, 3], [1, 2, 3]]}, "offset": [0, 0], "fundamental_hz": 0.1}"#;
        assert!(
            findings(&warm(rows))[0]
                .starts_with("/warm_start/coefficients/a: must have 2 rows, one per joint, with one number per harmonic")
        );
        let torque = GOOD.replace(
            "\"sample_rate_hz\"",
            "\"constraints\": {\"torque\": {\"limits\": [1, 0], \"safety_factor\": 0.5}}, \"sample_rate_hz\"",
        );
        let found = findings(&torque);
        assert!(
            found[0].starts_with("/constraints/torque/safety_factor: is 0.5; torques stay below"),
            "{found:?}"
        );
        assert!(
            found[1].starts_with("/constraints/torque/limits/1: is 0; a torque limit is a positive number"),
            "{found:?}"
        );
        let space = |of: &str| {
            GOOD.replace("planar_two_link", "iiwa14").replace(
                "\"sample_rate_hz\"",
                &format!("\"constraints\": {{\"space\": {of}}}, \"sample_rate_hz\""),
            )
        };
        let found = findings(&space(r#"{"clearance": 20, "self_collision": {"ignore": [["A1", "A9"]]}}"#));
        assert!(
            found[0].starts_with("/constraints/space/self_collision/ignore/0/1: is `A9`"),
            "{found:?}"
        );
        assert!(
            found[1].starts_with("/constraints/space/clearance: is 20; give metres"),
            "{found:?}"
        );
        let name = GOOD.replace("planar_two_link", "iiwa");
        assert_eq!(findings(&name), ["/robot: is `iiwa` (did you mean `iiwa14`?)"]);
        assert_eq!(findings("[]"), [": is an array, expected an object"]);
    }
}
