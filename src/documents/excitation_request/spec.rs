//! The problem as it is asked: Fourier series, criterion, constraints, noise.

use crate::documents::cursor::{Cursor, Fields};
use crate::documents::path_limits::{read_space_limits, read_torque_limits};
use crate::documents::requests;
use crate::excitation::{Criterion, Form, Knowledge, ProblemSpec, Start};
use crate::model::{FieldProblem, Friction, INPUT_LIMITS, Joint, JointKind, Limits, Mdh, Robot};
use nalgebra::Vector3;
use serde_json::Value;

/// The name of a criterion in documents.
pub fn criterion_name(criterion: Criterion) -> &'static str {
    match criterion {
        Criterion::ConditionNumber => "condition_number",
        Criterion::ScaledConditionNumber => "scaled_condition_number",
        Criterion::DOptimality => "d_optimality",
        Criterion::AOptimality => "a_optimality",
        Criterion::IOptimality => "i_optimality",
        Criterion::RivalEvidence => "rival_evidence",
    }
}

/// Each is a search of its own.
const MOST_FUNDAMENTALS: usize = 16;

pub(super) fn read_spec(fields: &Fields, robot: Option<Robot>, first: Option<f64>) -> ProblemSpec {
    let fourier = fields.required("fourier").and_then(|c| c.fields_of::<requests::Fourier>());
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
    let constraints = fields
        .optional("constraints")
        .and_then(|c| c.fields_of::<requests::Constraints>());
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
            .and_then(|c| c.word())
            .map_or(Criterion::ConditionNumber, requests::Criterion::into),
        form: constraint("form")
            .and_then(|c| c.word())
            .map_or(Form::Paper, requests::Form::into),
        start: constraint("start")
            .and_then(|c| c.word())
            .map_or(Start::Zero, requests::Start::into),
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

/// One fundamental, or a list to choose from.
pub(super) fn read_fundamentals(fields: &Fields) -> Vec<f64> {
    let fourier = fields.nullable("fourier").filter(|c| c.value().is_object());
    let Some(value) = fourier.and_then(|c| c.value().get("fundamental_hz").cloned()) else {
        return Vec::new();
    };
    match value {
        // A longer list is refused.
        Value::Array(list) => list.iter().take(MOST_FUNDAMENTALS).filter_map(Value::as_f64).collect(),
        other => other.as_f64().into_iter().collect(),
    }
}

/// The first of the fundamentals; all of them are checked.
fn check_fundamentals(cursor: &Cursor, first: Option<f64>) -> Option<f64> {
    if !cursor.value().is_array() {
        return cursor.number();
    }
    cursor.items_up_to(MOST_FUNDAMENTALS, "values, and a search is made for each;")?;
    let list = cursor.numbers(None)?;
    if list.is_empty() {
        cursor.complain(format!("has 0 values; a search chooses from 1 to {MOST_FUNDAMENTALS}"));
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
        let items = c.items_up_to(INPUT_LIMITS.harmonics, "harmonics")?;
        items.iter().map(|i| i.whole(1, 1_000_000).map(|n| n as usize)).collect()
    };
    cursor.items_up_to(INPUT_LIMITS.joints, "lists")?.iter().map(list).collect()
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
