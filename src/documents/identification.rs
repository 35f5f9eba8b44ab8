//! The answer of an identification.

use super::requests;
use super::residual::{EffectParameter, ResidualDocument};
use crate::formats::logs::LogReport;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

/// What a log says about a robot.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Identification))]
#[serde(default)]
pub struct IdentifyDocument {
    pub robot: String,
    pub joints: Vec<String>,
    pub estimator: String,
    pub quality: QualityDocument,
    /// Of the model that was found: declared model and effects estimated together.
    pub base_parameters: Vec<BaseValue>,
    /// What was found beside the declared model; empty where tracing was not asked for.
    pub effects: Vec<EffectValue>,
    /// The declared model alone, by the same rows and weights, for comparison.
    pub declared: DeclaredDocument,
    /// Combinations of base parameters that the log does not determine.
    pub undetermined: Vec<Direction>,
    /// Constant torque of every joint, where it was asked for.
    pub offsets: Option<Vec<BaseValue>>,
    pub physical_parameters: Option<Vec<PhysicalValue>>,
    pub feasibility: Option<Feasibility>,
    pub rms: RmsDocument,
    /// Per joint, of the noise that the scatter of the periods shows.
    pub noise: Vec<NoiseDocument>,
    pub log_report: Vec<LogDocument>,
    /// The residual diagnosis; null where it was not asked for.
    pub residual: Option<ResidualDocument>,
    pub predictions: Vec<PredictionDocument>,
    /// Why there are no predictions although they were asked for; all else is complete without them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predictions_error: Option<String>,
    pub notes: Vec<String>,
    /// Request, robot, version and logs: what is needed to do it again.
    pub provenance: Option<Provenance>,
}

impl IdentifyDocument {
    /// Whether joint `at` is prismatic, as the provenance says.
    pub fn is_sliding(&self, at: usize) -> bool {
        let origin = self.provenance.as_ref();
        let joint = origin.and_then(|o| o.robot.as_ref()?.joints.get(at));
        joint.is_some_and(|j| j.kind == requests::JointKind::Prismatic)
    }
}

/// Whether the log is good enough for the model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Quality))]
#[serde(default)]
pub struct QualityDocument {
    /// `good`, `poor_excitation`, `unidentifiable`, `explains_nothing` or `data_fault`.
    #[cfg_attr(feature = "service", schema(example = "good"))]
    pub verdict: String,
    /// The reason, and what to do.
    pub reason: String,
    /// Ratio of the extreme singular values of the observation matrix, columns scaled to equal length; null if infinite.
    pub condition_number: Option<f64>,
    pub rank: usize,
    pub columns: usize,
    /// Per joint: standard deviation of predicted torques at random states [N m or N]; null if infinite.
    pub prediction_std: Vec<Option<f64>>,
    /// Per joint: the same over the residual on the log; above 1 the model has learnt the path, not the robot.
    pub extrapolation: Vec<Option<f64>>,
    /// Per joint: share of the torque's variance that the model predicts on data it was not fitted to, at most 1; below zero a constant predicts better. Null
    /// for a joint whose torque takes no part.
    pub explained: Vec<Option<f64>>,
}

/// One estimated parameter. Value and deviation are null where the log does not determine it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = EstimatedParameter))]
#[serde(default)]
pub struct BaseValue {
    #[cfg_attr(feature = "service", schema(example = "MYR2"))]
    pub name: String,
    pub expression: String,
    pub value: Option<f64>,
    pub std_dev: Option<f64>,
    pub relative_std_dev_percent: Option<f64>,
    /// By the paper's (15), which counts every row as independent.
    pub textbook_relative_std_dev_percent: Option<f64>,
    pub unit: String,
    pub identifiable: bool,
}

/// An effect beside the declared model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = FoundEffect))]
#[serde(default)]
pub struct EffectValue {
    #[cfg_attr(feature = "service", schema(example = "stribeck_friction"))]
    pub effect: String,
    pub joints: Vec<String>,
    pub parameters: Vec<EffectParameter>,
    /// Whether it is a part of the model that is handed out; otherwise held-out data speak against it, or it is nothing that lasts.
    pub in_model: bool,
    /// Whether it is a finding. A nuisance offset is none: it is a part of the model because an offset was found on another joint and all of them together
    /// predict better, though its own value is not beyond chance.
    pub finding: bool,
}

/// The declared model without the effects found.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = DeclaredModel))]
#[serde(default)]
pub struct DeclaredDocument {
    pub base_parameters: Vec<BaseValue>,
    pub rms: RmsDocument,
}

/// A combination of parameters, strongest part first.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct Direction {
    #[cfg_attr(feature = "service", schema(example = "1 FV7 + 0.2 FS7"))]
    pub text: String,
    pub parameters: Vec<String>,
}

/// Physical parameters of a link, in the frames of the robot's description.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = PhysicalLink))]
#[serde(default)]
pub struct PhysicalValue {
    /// From 1.
    pub link: usize,
    pub name: String,
    /// (kg)
    #[serde(deserialize_with = "number")]
    pub mass: f64,
    /// (m)
    pub center_of_mass: [f64; 3],
    /// About the centre of mass [kg m²].
    pub inertia: InertiaDocument,
    #[serde(deserialize_with = "number")]
    pub viscous: f64,
    #[serde(deserialize_with = "number")]
    pub coulomb: f64,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = IdentifiedInertia))]
#[serde(default)]
pub struct InertiaDocument {
    #[serde(deserialize_with = "number")]
    pub xx: f64,
    #[serde(deserialize_with = "number")]
    pub xy: f64,
    #[serde(deserialize_with = "number")]
    pub xz: f64,
    #[serde(deserialize_with = "number")]
    pub yy: f64,
    #[serde(deserialize_with = "number")]
    pub yz: f64,
    #[serde(deserialize_with = "number")]
    pub zz: f64,
}

/// How the physical parameters were found and how far they are from every limit.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct Feasibility {
    pub method: String,
    /// `Converged`, `Stalled`, `BudgetExhausted`, `Infeasible` or `Cancelled`.
    pub status: String,
    /// Fit over that of the base parameters; 1.02 is 2 % worse.
    #[serde(deserialize_with = "number")]
    pub rms_ratio: f64,
    pub margins: Vec<MarginValue>,
    /// The paper's nonlinear problem (10a-d), where it was asked for.
    pub paper: Option<PaperProblem>,
}

/// The answer to the paper's nonlinear problem: physical parameters within bounds and the constraints that simulators like.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct PaperProblem {
    /// Of the best start; `Infeasible` where none met the constraints.
    pub status: String,
    /// Weighted residual sum of squares (10a).
    #[serde(deserialize_with = "number")]
    pub objective: f64,
    /// What the objective cannot be below, from a convex problem with fewer constraints; null where those contradict each other.
    pub lower_bound: Option<f64>,
    /// Fit over that of the lower bound, less one: the global minimum fits at most this much better.
    pub gap_percent: Option<f64>,
    /// Fit over that of the base parameters.
    #[serde(deserialize_with = "number")]
    pub rms_ratio: f64,
    pub evaluations: u32,
    pub starts: Vec<FitStart>,
    pub margins: Vec<MarginValue>,
    pub physical_parameters: Vec<PhysicalValue>,
}

/// One local solve.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct FitStart {
    /// `rods`, `robot`, `consistent` or `random`.
    #[cfg_attr(feature = "service", schema(example = "rods"))]
    pub from: String,
    pub status: String,
    pub feasible: bool,
    pub objective: Option<f64>,
    pub evaluations: u32,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = FeasibilityMargin))]
#[serde(default)]
pub struct MarginValue {
    /// From 1.
    pub link: usize,
    #[cfg_attr(feature = "service", schema(example = "pseudo_inertia_positive_definite"))]
    pub constraint: String,
    /// Above zero where the constraint holds.
    #[serde(deserialize_with = "number")]
    pub margin: f64,
    /// Whether it holds the solution: without it the bodies would be others.
    pub active: bool,
    /// What it costs where it is active: by how many percent the fit is worse than the best without it.
    pub cost_percent: Option<f64>,
}

/// Root mean square errors [N m or N] per joint, of single measurements about the model with the effects found.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct RmsDocument {
    pub identification: Vec<LogRms>,
    pub validation: Vec<LogRms>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct LogRms {
    pub name: String,
    pub base: JointErrors,
    pub physical: Option<JointErrors>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct JointErrors {
    /// Null for a joint whose torque takes no part.
    pub rms: Vec<Option<f64>>,
    /// Of the torque's own root mean square; null where it has none.
    pub percent: Vec<Option<f64>>,
    /// Over the joints that have one.
    #[serde(deserialize_with = "number")]
    pub sum: f64,
}

/// The noise of one joint.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = JointNoise))]
#[serde(default)]
pub struct NoiseDocument {
    pub joint: String,
    #[serde(deserialize_with = "number")]
    pub residual_rms: f64,
    /// Of the rows that were fitted, from the scatter of the periods; null without periods.
    pub noise_std: Option<f64>,
    /// Residual mean square over what noise alone would leave; well above 1 the model lacks something.
    pub misfit: Option<f64>,
    pub rows: usize,
    /// Independent values that the rows are worth.
    #[serde(deserialize_with = "number")]
    pub effective_rows: f64,
}

/// What was found in a log file, and how it was prepared.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct LogDocument {
    pub file: String,
    /// `identification` or `validation`.
    pub role: String,
    pub rows: usize,
    pub rows_used: usize,
    #[serde(deserialize_with = "number")]
    pub sample_rate_hz: f64,
    #[serde(deserialize_with = "number")]
    pub duration_s: f64,
    pub resampled: bool,
    pub findings: Vec<FindingDocument>,
    pub choices: Vec<ChoiceDocument>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct FindingDocument {
    #[cfg_attr(feature = "service", schema(example = "garbage_row"))]
    pub code: String,
    pub count: usize,
    /// The first of them; the header is line 1.
    pub lines: Vec<u64>,
    pub detail: String,
}

/// One decision of preprocessing.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct ChoiceDocument {
    #[cfg_attr(feature = "service", schema(example = "derivatives"))]
    pub what: String,
    pub value: String,
    pub why: String,
}

/// Measured and predicted torque of a joint over time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct PredictionDocument {
    pub log: String,
    pub joint: String,
    /// (s), on the log's own clock.
    #[serde(deserialize_with = "numbers")]
    pub time: Vec<f64>,
    /// Position, velocity and acceleration of the joint at those times [rad or m, and per second].
    #[serde(deserialize_with = "numbers")]
    pub q: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub qd: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub qdd: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub measured: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub base: Vec<f64>,
    pub physical: Option<Vec<f64>>,
    /// By the declared model, without the effects found; null where tracing was not asked for.
    pub declared: Option<Vec<f64>>,
}

/// What is needed to do an identification again.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// The request as it was made.
    #[cfg_attr(feature = "service", schema(value_type = Object))]
    pub request: Value,
    /// The robot in full, whatever the request called it.
    pub robot: Option<requests::JointRobot>,
    pub logs: Vec<LogOrigin>,
}

/// A log file, by its content.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct LogOrigin {
    pub file: String,
    /// `identification` or `validation`.
    pub role: String,
    pub bytes: u64,
    /// SHA-256 of the file as it was sent, in hexadecimal.
    pub sha256: String,
}

impl LogDocument {
    pub fn new(report: &LogReport, role: &str, choices: &[crate::preparation::Choice]) -> Self {
        let finding = |f: &crate::formats::logs::Finding| FindingDocument {
            code: f.kind.code().into(),
            count: f.count,
            lines: f.lines.clone(),
            detail: f.detail.clone(),
        };
        Self {
            file: report.file.clone(),
            role: role.into(),
            rows: report.rows,
            rows_used: report.rows_used,
            sample_rate_hz: report.rate_hz,
            duration_s: report.duration_s,
            resampled: report.resampled,
            findings: report.findings.iter().map(finding).collect(),
            choices: choices
                .iter()
                .map(|c| ChoiceDocument {
                    what: c.what.into(),
                    value: c.value.clone(),
                    why: c.why.clone(),
                })
                .collect(),
        }
    }
}

/// Documents have null for what is no finite number.
fn number<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    Option::deserialize(source).map(|value: Option<f64>| value.unwrap_or(f64::NAN))
}

fn numbers<'de, D: Deserializer<'de>>(source: D) -> Result<Vec<f64>, D::Error> {
    let values = Vec::<Option<f64>>::deserialize(source)?;
    Ok(values.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect())
}
