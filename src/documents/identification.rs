//! The answer of an identification.

use super::requests;
use super::residual::{EffectParameter, LawDocument, ResidualDocument};
use crate::formats::logs::LogReport;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

/// What a log says about a robot.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Identification))]
#[serde(default)]
pub struct IdentifyDocument {
    /// Name of the robot.
    pub robot: String,
    /// Names of the joints; every array per joint has this order.
    pub joints: Vec<String>,
    /// Estimator that was used: `ols`, `wls` or `robust`.
    pub estimator: String,
    /// Whether the log is good enough for the model.
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
    /// Physical parameters of every link; null where `feasible.method` is `none`, or no consistent bodies were found.
    pub physical_parameters: Option<Vec<PhysicalValue>>,
    /// How the physical parameters were found; null together with them.
    pub feasibility: Option<Feasibility>,
    /// Root mean square errors per log and joint.
    pub rms: RmsDocument,
    /// Per joint, of the noise that the scatter of the periods shows.
    pub noise: Vec<NoiseDocument>,
    /// What was found in every log file, and how it was prepared.
    pub log_report: Vec<LogDocument>,
    /// The residual diagnosis; null where it was not asked for.
    pub residual: Option<ResidualDocument>,
    /// Measured and predicted torques, thinned to the number of points asked for; empty if none were.
    pub predictions: Vec<PredictionDocument>,
    /// Why there are no predictions although they were asked for; all else is complete without them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predictions_error: Option<String>,
    /// Remarks on choices and limits of the answer; empty without any.
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
    /// Rank of the observation matrix: the number of parameter combinations that the log determines.
    pub rank: usize,
    /// Columns of the observation matrix: base parameters, offsets and effects together.
    pub columns: usize,
    /// Per joint: standard deviation of predicted torques at random states [N m or N]; null if infinite.
    pub prediction_std: Vec<Option<f64>>,
    /// Per joint: the same over the residual on the log; above 1 the model has learnt the path, not the robot.
    pub extrapolation: Vec<Option<f64>>,
    /// Per joint: share of the torque's variance that the model predicts on data it was not fitted to, at most 1; below zero a
    /// constant predicts better. Null for a joint whose torque takes no part.
    pub explained: Vec<Option<f64>>,
}

/// One estimated parameter. Value and deviation are null where the log does not determine it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = EstimatedParameter))]
#[serde(default)]
pub struct BaseValue {
    /// Name of the base parameter.
    #[cfg_attr(feature = "service", schema(example = "MYR2"))]
    pub name: String,
    /// Linear combination of standard parameters that it stands for; lengths in m.
    pub expression: String,
    /// Estimate, in `unit`.
    pub value: Option<f64>,
    /// Standard deviation of the estimate, in `unit`, with the correlation of the noise allowed for.
    pub std_dev: Option<f64>,
    /// `100 · std_dev / |value|` [%].
    pub relative_std_dev_percent: Option<f64>,
    /// By the paper's (15), which counts every row as independent.
    pub textbook_relative_std_dev_percent: Option<f64>,
    /// Unit of the value, such as `kg m`.
    pub unit: String,
    /// Whether the log determines the parameter.
    pub identifiable: bool,
}

/// An effect beside the declared model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = FoundEffect))]
#[serde(default)]
pub struct EffectValue {
    /// Code of the effect, or the name of an own one.
    #[cfg_attr(feature = "service", schema(example = "stribeck_friction"))]
    pub effect: String,
    /// Names of the joints that it acts on.
    pub joints: Vec<String>,
    /// Estimated parameters with units and standard deviations.
    pub parameters: Vec<EffectParameter>,
    /// Whether it is a part of the model that is handed out; otherwise held-out data speak against it, or it is nothing that
    /// lasts.
    pub in_model: bool,
    /// Whether it is a finding. A nuisance offset is none: it is a part of the model because an offset was found on another joint
    /// and all of them together predict better, though its own value is not beyond chance.
    pub finding: bool,
    /// Whether it is an own effect that belongs to the model from the start.
    pub declared: bool,
    /// The formula of a law or an own effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<LawDocument>,
}

/// The declared model without the effects found.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = DeclaredModel))]
#[serde(default)]
pub struct DeclaredDocument {
    /// Base parameters estimated without any effect.
    pub base_parameters: Vec<BaseValue>,
    /// Root mean square errors of that model.
    pub rms: RmsDocument,
}

/// A combination of parameters, strongest part first.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct Direction {
    /// The combination as text, scaled to a largest part of 1.
    #[cfg_attr(feature = "service", schema(example = "1 FV7 + 0.2 FS7"))]
    pub text: String,
    /// Names of the parameters in it, strongest part first.
    pub parameters: Vec<String>,
}

/// Physical parameters of a link, in the frames of the robot's description.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = PhysicalLink))]
#[serde(default)]
pub struct PhysicalValue {
    /// From 1.
    pub link: usize,
    /// Name of the link.
    pub name: String,
    /// (kg)
    #[serde(deserialize_with = "number")]
    pub mass: f64,
    /// (m)
    pub center_of_mass: [f64; 3],
    /// About the centre of mass [kg m²].
    pub inertia: InertiaDocument,
    /// Viscous friction of the joint before the link [N·m·s/rad or N·s/m].
    #[serde(deserialize_with = "number")]
    pub viscous: f64,
    /// Coulomb friction of the joint before the link [N·m or N].
    #[serde(deserialize_with = "number")]
    pub coulomb: f64,
}

/// Inertia tensor about the centre of mass, in axes parallel to the link frame [kg m²].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = IdentifiedInertia))]
#[serde(default)]
pub struct InertiaDocument {
    /// `∫ (y² + z²) dm` [kg m²].
    #[serde(deserialize_with = "number")]
    pub xx: f64,
    /// `−∫ x y dm` [kg m²].
    #[serde(deserialize_with = "number")]
    pub xy: f64,
    /// `−∫ x z dm` [kg m²].
    #[serde(deserialize_with = "number")]
    pub xz: f64,
    /// `∫ (x² + z²) dm` [kg m²].
    #[serde(deserialize_with = "number")]
    pub yy: f64,
    /// `−∫ y z dm` [kg m²].
    #[serde(deserialize_with = "number")]
    pub yz: f64,
    /// `∫ (x² + y²) dm` [kg m²].
    #[serde(deserialize_with = "number")]
    pub zz: f64,
}

/// How the physical parameters were found and how far they are from every limit.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct Feasibility {
    /// Method of the bodies: `consistent` (semidefinite) or `paper` (nonlinear problem).
    pub method: String,
    /// `Converged`, `Stalled`, `BudgetExhausted`, `Infeasible` or `Cancelled`.
    pub status: String,
    /// Fit over that of the base parameters; 1.02 is 2 % worse.
    #[serde(deserialize_with = "number")]
    pub rms_ratio: f64,
    /// Distance of the solution to every constraint.
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
    /// Evaluations of the objective over all starts.
    pub evaluations: u32,
    /// Every local solve.
    pub starts: Vec<FitStart>,
    /// Distance of the best solution to every constraint.
    pub margins: Vec<MarginValue>,
    /// Physical parameters of the best solution.
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
    /// How the local solve ended, such as `Converged`.
    pub status: String,
    /// Whether its end point meets every constraint.
    pub feasible: bool,
    /// Weighted residual sum of squares at its end; null if it is not finite.
    pub objective: Option<f64>,
    /// Evaluations of the objective by this solve.
    pub evaluations: u32,
}

/// Distance of the bodies to one constraint of one link.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = FeasibilityMargin))]
#[serde(default)]
pub struct MarginValue {
    /// From 1.
    pub link: usize,
    /// Code of the constraint.
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
    /// One entry per log that was fitted.
    pub identification: Vec<LogRms>,
    /// One entry per log that was held out; empty without any.
    pub validation: Vec<LogRms>,
}

/// Errors of the two models on one log.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct LogRms {
    /// Name of the log file.
    pub name: String,
    /// Errors of the base parameters with the effects found.
    pub base: JointErrors,
    /// Errors of the physical parameters; null without them.
    pub physical: Option<JointErrors>,
}

/// Root mean square torque errors, one entry per joint.
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
    /// Name of the joint.
    pub joint: String,
    /// Root mean square of the residual over the fitted rows [N m or N].
    #[serde(deserialize_with = "number")]
    pub residual_rms: f64,
    /// Of the rows that were fitted, from the scatter of the periods; null without periods.
    pub noise_std: Option<f64>,
    /// Residual mean square over what noise alone would leave; well above 1 the model lacks something.
    pub misfit: Option<f64>,
    /// Number of rows that were fitted.
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
    /// Name of the file.
    pub file: String,
    /// `identification` or `validation`.
    pub role: String,
    /// Rows in the file.
    pub rows: usize,
    /// Rows left after faulty ones were dropped.
    pub rows_used: usize,
    /// Sample rate of the prepared log (Hz).
    #[serde(deserialize_with = "number")]
    pub sample_rate_hz: f64,
    /// Duration of the log (s).
    #[serde(deserialize_with = "number")]
    pub duration_s: f64,
    /// Whether the log was resampled onto a uniform grid.
    pub resampled: bool,
    /// Faults that were found in the file; empty for a clean one.
    pub findings: Vec<FindingDocument>,
    /// Decisions of preprocessing, with their reasons.
    pub choices: Vec<ChoiceDocument>,
}

/// One kind of fault in a log file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct FindingDocument {
    /// Code of the fault.
    #[cfg_attr(feature = "service", schema(example = "garbage_row"))]
    pub code: String,
    /// How many rows or places have it.
    pub count: usize,
    /// The first of them; the header is line 1.
    pub lines: Vec<u64>,
    /// What was found and what was done about it.
    pub detail: String,
}

/// One decision of preprocessing.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct ChoiceDocument {
    /// What was decided, by code.
    #[cfg_attr(feature = "service", schema(example = "derivatives"))]
    pub what: String,
    /// The value that was chosen.
    pub value: String,
    /// The reason for it.
    pub why: String,
}

/// Measured and predicted torque of a joint over time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct PredictionDocument {
    /// Name of the log file.
    pub log: String,
    /// Name of the joint.
    pub joint: String,
    /// (s), on the log's own clock.
    #[serde(deserialize_with = "numbers")]
    pub time: Vec<f64>,
    /// Position, velocity and acceleration of the joint at those times [rad or m, and per second].
    #[serde(deserialize_with = "numbers")]
    pub q: Vec<f64>,
    /// Velocity [rad/s or m/s].
    #[serde(deserialize_with = "numbers")]
    pub qd: Vec<f64>,
    /// Acceleration [rad/s² or m/s²].
    #[serde(deserialize_with = "numbers")]
    pub qdd: Vec<f64>,
    /// Measured torque [N m or N].
    #[serde(deserialize_with = "numbers")]
    pub measured: Vec<f64>,
    /// Torque by the base parameters with the effects found [N m or N].
    #[serde(deserialize_with = "numbers")]
    pub base: Vec<f64>,
    /// Torque by the physical parameters [N m or N]; null without them.
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
    /// Every log file, by its content.
    pub logs: Vec<LogOrigin>,
}

/// A log file, by its content.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct LogOrigin {
    /// Name of the file.
    pub file: String,
    /// `identification` or `validation`.
    pub role: String,
    /// Size of the file [bytes].
    pub bytes: u64,
    /// SHA-256 of the file as it was sent, in hexadecimal.
    pub sha256: String,
}

impl LogDocument {
    /// Converts the core's report on a log; `role` is `identification` or `validation`.
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
