//! Identification requests.

use super::bounds::read_bounds;
use super::columns::read_columns;
use super::cursor::{Cursor, Fields, Findings};
use super::effect_list::{read_effects, with_definitions};
use super::requests;
use super::robot::{NamedRobots, read_robot_or_name};
use crate::effects::OwnEffect;
use crate::formats::json::Parsed;
use crate::formats::logs::Columns;
use crate::identification::physical::{FeasibleMethod, FeasibleOptions, PaperOptions};
use crate::model::{FieldProblem, LinkBounds, Robot};
use crate::preparation::{FilterSpec, Period, PreprocessOptions};
use crate::regression::Estimator;
use serde_json::Value;
use std::sync::Arc;

/// A checked request.
#[derive(Debug, Clone)]
pub struct IdentifyRequest {
    /// The robot whose parameters are estimated.
    pub robot: Robot,
    /// What a user should know about how the robot was read.
    pub notes: Vec<String>,
    /// Columns of the log and their conversion to SI units.
    pub columns: Columns,
    /// Averaging, derivatives and filters.
    pub preprocess: PreprocessOptions,
    /// Ordinary, weighted or robust least squares.
    pub estimator: Estimator,
    /// One constant torque per joint, estimated with the rest.
    pub offset: bool,
    /// Effects with formulas of their own, of the robot and of the request.
    pub effects: Vec<Arc<OwnEffect>>,
    /// `None` where no physical parameters are wanted.
    pub feasible: Option<FeasibleOptions>,
    /// Points of every prediction series in the answer; 0 for none.
    pub prediction_points: usize,
    /// Whether the residual is diagnosed.
    pub trace: bool,
    /// The request as it was made, with the definitions of effects that it named.
    pub document: Value,
}

/// Period and order of excitations that requests may name.
pub trait NamedExcitations {
    /// `(period_s, order)`.
    fn excitation(&self, id: &str) -> Option<(f64, usize)>;
}

/// No excitation is known by name.
pub struct NoExcitations;

impl NamedExcitations for NoExcitations {
    fn excitation(&self, _: &str) -> Option<(f64, usize)> {
        None
    }
}

/// Reads a request.
///
/// # Errors
/// Everything that is wrong with it, its robot and its columns.
pub fn read_identify_request(
    parsed: &Parsed,
    robots: &dyn NamedRobots,
    excitations: &dyn NamedExcitations,
) -> Result<IdentifyRequest, Vec<FieldProblem>> {
    let findings = Findings::new(parsed.problems.clone());
    let read = read(&Cursor::root(&parsed.value, &findings), robots, excitations);
    match read {
        Some(request) if findings.is_empty() => Ok(request),
        _ => Err(findings.into_list()),
    }
}

fn read(cursor: &Cursor, robots: &dyn NamedRobots, excitations: &dyn NamedExcitations) -> Option<IdentifyRequest> {
    let fields = cursor.fields_of::<requests::IdentifyRequest>()?;
    let robot = fields.required("robot").and_then(|c| read_robot_or_name(&c, robots));
    let joints = robot.as_ref().map(|r| r.robot.joint_count());
    let columns = fields
        .nullable("columns")
        .map_or_else(Columns::default, |c| read_columns(&c, joints));
    let period = read_period(&fields, excitations);
    let preprocess = read_preprocess(&fields, period);
    let of_robot = robot.as_ref().map(|r| r.effects.clone()).unwrap_or_default();
    let effects = read_effects(&fields, robot.as_ref().map(|r| &r.robot), &of_robot, robots);
    check_channels(cursor, &columns, &effects);
    let feasible = read_feasible(&fields, robot.as_ref().map(|r| &r.robot));
    let flag = |name: &str, otherwise: bool| fields.nullable(name).and_then(|c| boolean(&c)).unwrap_or(otherwise);
    let (offset, trace) = (flag("offset", false), flag("trace", true));
    let estimator = fields
        .nullable("estimator")
        .and_then(|c| c.word())
        .map(requests::Estimator::into)
        .unwrap_or_default();
    let points = fields
        .nullable("prediction_points")
        .and_then(|c| c.whole(0, 100_000))
        .unwrap_or(0);
    let robot = robot?;
    let document = with_definitions(cursor.value(), &effects, &of_robot);
    Some(IdentifyRequest {
        robot: robot.robot,
        notes: robot.notes,
        columns,
        preprocess,
        estimator,
        offset,
        effects: of_robot.into_iter().chain(effects).collect(),
        feasible,
        prediction_points: points as usize,
        trace,
        document,
    })
}

/// Own effects of the request whose channels the logs are not read with: they would be computed with the reference, as if it
/// never changed.
fn check_channels(cursor: &Cursor, columns: &Columns, effects: &[Arc<OwnEffect>]) {
    for definition in effects.iter().map(|e| e.definition()) {
        let missing = |name: &String| columns.channels.iter().all(|c| c.name != *name);
        for channel in definition.channels.iter().map(|c| &c.name).filter(|name| missing(name)) {
            let detail = format!(
                "`{}` depends on `{channel}`, which is no channel of the logs",
                definition.name
            );
            let problem = FieldProblem::new("/effects", detail);
            cursor
                .findings()
                .push(problem.with_hint("name its column in `columns.channels`"));
        }
    }
}

pub(super) fn boolean(cursor: &Cursor) -> Option<bool> {
    let value = cursor.value().as_bool();
    if value.is_none() {
        cursor.complain("is not true or false");
    }
    value
}

pub(super) fn positive(cursor: &Cursor) -> Option<f64> {
    let value = cursor.number()?;
    if value > 0.0 {
        return Some(value);
    }
    cursor.complain(format!("is {value}, expected a number above zero"));
    None
}

fn not_negative(cursor: &Cursor) -> Option<f64> {
    let value = cursor.number()?;
    if value >= 0.0 {
        return Some(value);
    }
    cursor.complain(format!("is {value}, expected a number not below zero"));
    None
}

/// From `period_s`, the excitation's id, or an excitation's own document.
pub(super) fn read_period(fields: &Fields, excitations: &dyn NamedExcitations) -> Period {
    let stated = fields.nullable("period_s").and_then(|c| positive(&c));
    let named = fields.nullable("excitation").and_then(|c| match c.value() {
        Value::Object(design) => {
            let fundamental = design.get("fundamental_hz").and_then(Value::as_f64).filter(|f| *f > 0.0);
            let order = design
                .get("coefficients")
                .and_then(|k| k.get("a")?.get(0)?.as_array())
                .map(Vec::len);
            if fundamental.is_none() {
                c.complain_with(
                    "has no `fundamental_hz` above zero",
                    "give the answer of POST /excitation as it is",
                );
            }
            fundamental.map(|f| (1.0 / f, order.unwrap_or(0)))
        }
        _ => {
            let id = c.string()?;
            let found = excitations.excitation(id);
            if found.is_none() {
                c.complain_with(format!("there is no excitation `{id}`"), "give its document, or period_s");
            }
            found
        }
    });
    match (stated, named) {
        (Some(period_s), named) => Period::Known {
            period_s,
            order: named.map(|(_, order)| order),
        },
        (None, Some((period_s, order))) => Period::Known {
            period_s,
            order: Some(order),
        },
        (None, None) => Period::Detect,
    }
}

pub(super) fn read_preprocess(fields: &Fields, period: Period) -> PreprocessOptions {
    let part = fields
        .nullable("preprocess")
        .and_then(|c| c.fields_of::<requests::Preprocess>());
    let field = |name: &str| part.as_ref().and_then(|f| f.nullable(name));
    let average = field("average").and_then(|c| boolean(&c)).unwrap_or(true);
    PreprocessOptions {
        period: if average { period } else { Period::None },
        method: field("method")
            .and_then(|c| c.word())
            .map(requests::PreprocessMethod::into)
            .unwrap_or_default(),
        position_filter: field("position_filter").and_then(|c| read_filter(&c)),
        torque_filter: field("torque_filter").and_then(|c| read_filter(&c)),
        band_hz: None,
        discard_edges_s: field("discard_edges_s").and_then(|c| not_negative(&c)),
        decimation: field("decimation").and_then(|c| c.whole(1, 1_000_000)).map(|d| d as usize),
        dead_zone: field("dead_zone").and_then(|c| not_negative(&c)),
    }
}

fn read_filter(cursor: &Cursor) -> Option<FilterSpec> {
    let fields = cursor.fields_of::<requests::Filter>()?;
    let order = fields.required("order").and_then(|c| c.whole(1, 64));
    let cutoff_hz = fields.required("cutoff_hz").and_then(|c| positive(&c));
    Some(FilterSpec {
        order: order? as usize,
        cutoff_hz: cutoff_hz?,
    })
}

fn read_feasible(fields: &Fields, robot: Option<&Robot>) -> Option<FeasibleOptions> {
    let mut options = robot.map(FeasibleOptions::for_robot).unwrap_or_default();
    let Some(part) = fields.nullable("feasible").and_then(|c| c.fields_of::<requests::Feasible>()) else {
        return Some(options);
    };
    let method = part
        .nullable("method")
        .and_then(|c| c.word())
        .map(requests::FeasibleMethod::into);
    let number = |name: &str, value: &mut f64| {
        if let Some(v) = part.nullable(name).and_then(|c| not_negative(&c)) {
            *value = v;
        }
    };
    number("prior_weight", &mut options.consistent.prior_weight);
    if part.nullable("prior_weight").is_some() {
        options.consistent.most_shift = f64::INFINITY;
    }
    number("least_eigenvalue", &mut options.consistent.least_eigenvalue);
    number("least_viscous", &mut options.consistent.least_viscous);
    number("least_viscous", &mut options.paper.least_viscous);
    let joints = robot.map(Robot::joint_count);
    for item in part.nullable("bounds").and_then(|c| c.items()).unwrap_or_default() {
        read_bound(&item, &mut options.consistent.bounds, joints);
    }
    options.paper.bounds.clone_from(&options.consistent.bounds);
    read_paper(&part, &mut options.paper, joints);
    let method = method.unwrap_or(Some(FeasibleMethod::Consistent))?;
    Some(FeasibleOptions { method, ..options })
}

fn read_paper(part: &Fields, options: &mut PaperOptions, joints: Option<usize>) {
    if let Some(c) = part.nullable("slender_axes") {
        let items = c.items().unwrap_or_default();
        if joints.is_some_and(|n| n != items.len()) {
            c.complain(format!(
                "has {} axes, the robot has {} links",
                items.len(),
                joints.unwrap_or(0)
            ));
        }
        let axis = |c: &Cursor| {
            if c.value().is_null() {
                None
            } else {
                c.word().map(requests::Axis::into)
            }
        };
        options.slender = items.iter().map(axis).collect();
    }
    if let Some(gazebo) = part.nullable("gazebo").and_then(|c| boolean(&c)) {
        options.gazebo = gazebo;
    }
    if let Some(triangle) = part.nullable("triangle").and_then(|c| c.word()) {
        options.triangle = requests::Triangle::into(triangle);
    }
    if let Some(starts) = part.nullable("starts").and_then(|c| c.whole(1, 1000)) {
        options.starts = starts as usize;
    }
    if let Some(seed) = part.nullable("seed").and_then(|c| c.whole(0, u64::MAX)) {
        options.seed = seed;
    }
}

fn read_bound(item: &Cursor, bounds: &mut [LinkBounds], joints: Option<usize>) {
    let Some(fields) = item.fields_of::<requests::LinkBounds>() else {
        return;
    };
    let link = fields
        .required("link")
        .and_then(|c| c.whole(1, joints.unwrap_or(usize::MAX) as u64));
    let read = read_bounds(&fields);
    if let Some(bound) = link.and_then(|l| bounds.get_mut(l as usize - 1)) {
        *bound = read.or(bound);
    }
}
