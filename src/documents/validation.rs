//! Requests to hold a model against logs.

use super::augmented::read_augmented;
use super::columns::read_columns;
use super::cursor::{Cursor, Findings};
use super::identification::{JointErrors, LogDocument, PredictionDocument};
use super::identify_request::{NamedExcitations, boolean, positive, read_period, read_preprocess};
use super::requests;
use super::residual::ResidualDocument;
use super::robot::{NamedRobots, RobotDocument, read_robot_or_name};
use crate::formats::json::Parsed;
use crate::formats::logs::Columns;
use crate::model::{FieldProblem, Robot};
use crate::preparation::PreprocessOptions;
use crate::regression::{AugmentedModel, Prior};
use serde::Serialize;

/// A checked request.
#[derive(Debug, Clone)]
pub struct ValidateRequest {
    /// The model: a robot every link of which has prior parameters.
    pub robot: Robot,
    /// What a user should know about how it was read.
    pub notes: Vec<String>,
    /// Constant torque of every joint.
    pub offsets: Option<Vec<f64>>,
    /// Columns of the log and their conversion to SI units.
    pub columns: Columns,
    /// Averaging, derivatives and filters.
    pub preprocess: PreprocessOptions,
    /// Points of measured and predicted torque per joint in the answer; none if zero.
    pub prediction_points: usize,
    /// Base parameters and effects of the model, and how well they are known, where it says so.
    pub augmented: Option<(AugmentedModel, Prior)>,
    /// Whether what has changed is to be traced.
    pub trace: bool,
}

/// Reads a request whose `model` is the JSON model of an identification, or any robot with parameters for every link.
///
/// # Errors
/// Everything that is wrong with it.
pub fn read_validate_request(
    parsed: &Parsed,
    robots: &dyn NamedRobots,
    excitations: &dyn NamedExcitations,
) -> Result<ValidateRequest, Vec<FieldProblem>> {
    let findings = Findings::new(parsed.problems.clone());
    let read = read(&Cursor::root(&parsed.value, &findings), robots, excitations);
    match read {
        Some(request) if findings.is_empty() => Ok(request),
        _ => Err(findings.into_list()),
    }
}

fn read(cursor: &Cursor, robots: &dyn NamedRobots, excitations: &dyn NamedExcitations) -> Option<ValidateRequest> {
    let fields = cursor.fields_of::<requests::ValidateRequest>()?;
    let model = fields.required("model").and_then(|c| read_model(&c, robots));
    let joints = model.as_ref().map(|m| m.robot.joint_count());
    let columns = fields
        .nullable("columns")
        .map_or_else(Columns::default, |c| read_columns(&c, joints));
    let preprocess = PreprocessOptions {
        band_hz: model.as_ref().and_then(|m| m.band_hz),
        ..read_preprocess(&fields, read_period(&fields, excitations))
    };
    let points = fields
        .nullable("prediction_points")
        .and_then(|c| c.whole(0, 100_000))
        .unwrap_or(0);
    let trace = fields.nullable("trace").and_then(|c| boolean(&c)).unwrap_or(true);
    let model = model?;
    Some(ValidateRequest {
        robot: model.robot,
        notes: model.notes,
        offsets: model.offsets,
        augmented: model.augmented,
        trace,
        columns,
        preprocess,
        prediction_points: points as usize,
    })
}

struct Model {
    robot: Robot,
    notes: Vec<String>,
    offsets: Option<Vec<f64>>,
    augmented: Option<(AugmentedModel, Prior)>,
    band_hz: Option<f64>,
}

fn read_model(cursor: &Cursor, robots: &dyn NamedRobots) -> Option<Model> {
    let model = match cursor.value().get("robot").is_some() {
        true => {
            let fields = cursor.fields_of::<requests::Model>()?;
            let RobotDocument { robot, notes, .. } = fields.required("robot").and_then(|c| read_robot_or_name(&c, robots))?;
            let offsets = fields.nullable("offsets").and_then(|c| c.numbers(Some(robot.joint_count())));
            let augmented = fields.nullable("augmented").and_then(|c| read_augmented(&c, &robot));
            Model {
                robot,
                notes,
                offsets,
                augmented,
                band_hz: fields.nullable("band_hz").and_then(|c| positive(&c)),
            }
        }
        false => {
            let RobotDocument { robot, notes, .. } = read_robot_or_name(cursor, robots)?;
            Model {
                robot,
                notes,
                offsets: None,
                augmented: None,
                band_hz: None,
            }
        }
    };
    for joint in model.robot.joints().iter().filter(|j| j.prior.is_none()) {
        cursor.complain_with(
            format!("the link behind joint `{}` has no mass and inertia", joint.name),
            "give the model of an identification, or a robot with parameters for every link",
        );
    }
    Some(model)
}

/// How well a model predicts logs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Validation))]
pub struct ValidateDocument {
    /// Name of the robot.
    pub robot: String,
    /// Names of the joints; every array per joint has this order.
    pub joints: Vec<String>,
    /// Codes of the effects that the model has beside its bodies, and their joints.
    pub effects: Vec<ModelEffect>,
    /// Errors of the model on every log.
    pub logs: Vec<ValidatedLog>,
    /// What was found in every log file, and how it was prepared.
    pub log_report: Vec<LogDocument>,
    /// Measured and predicted torques, thinned to `prediction_points`; empty if none were asked for.
    pub predictions: Vec<PredictionDocument>,
    /// Why there are no predictions although they were asked for; all else is complete without them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predictions_error: Option<String>,
    /// What has changed since the model was made: noise floor, findings, rivals, before and after; null where the model does not
    /// say how well it is known, or tracing was turned off.
    pub residual: Option<ResidualDocument>,
    /// What to know about how the model's robot was read.
    pub notes: Vec<String>,
}

/// An effect of a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct ModelEffect {
    /// Code of the effect.
    #[cfg_attr(feature = "service", schema(example = "stribeck_friction"))]
    pub effect: String,
    /// Names of the joints that it acts on.
    pub joints: Vec<String>,
}

/// Errors of the model on one log.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct ValidatedLog {
    /// Name of the log file.
    pub name: String,
    /// Of the bodies with the effects of the model.
    #[serde(flatten)]
    pub errors: JointErrors,
    /// Of the base parameters with the effects of the model, where it has them.
    pub base: Option<JointErrors>,
}
