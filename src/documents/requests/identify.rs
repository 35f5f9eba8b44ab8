//! Logs: how they are read and prepared, to identify from or to hold against a model.

use super::feasible::Feasible;
use super::model::Model;
use super::own_effect::OwnEffectOrName;
use super::robot::RobotOrName;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A log upload: the request and the files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct IdentifyUpload {
    /// The request as JSON.
    pub request: IdentifyRequest,
    /// Logs to identify from: CSV, NPZ, MATLAB, Parquet, MCAP or rosbag2, plain, gzip or Zstandard.
    #[cfg_attr(feature = "service", schema(format = Binary))]
    pub log: Vec<String>,
    /// Logs that the fit does not see.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Vec<String>, format = Binary, required = false))]
    pub validation: Option<Vec<String>>,
}

/// A log to look at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct LogUpload {
    /// CSV, NPZ, MATLAB, Parquet, MCAP or rosbag2, plain, gzip or Zstandard.
    #[cfg_attr(feature = "service", schema(format = Binary))]
    pub log: String,
}

/// A model, and logs to hold against it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ValidateUpload {
    /// The request as JSON.
    pub request: ValidateRequest,
    /// Logs to predict: CSV, NPZ, MATLAB, Parquet, MCAP or rosbag2, plain, gzip or Zstandard.
    #[cfg_attr(feature = "service", schema(format = Binary))]
    pub log: Vec<String>,
}

/// What to make of the logs. A log has columns: `time, q1 … qn, tau1 … taun` (optional `qd1 …`), those of a well-known program,
/// or what `columns` says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(example = json!({"robot": "iiwa14", "period_s": 10, "estimator": "wls"})))]
#[serde(deny_unknown_fields)]
pub struct IdentifyRequest {
    /// The robot, in full or by name.
    pub robot: RobotOrName,
    /// Id of the excitation that was executed, or its document: gives the period and the highest harmonic.
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub excitation: Option<Value>,
    /// Period of the motion (s); found in the data if neither this nor `excitation` is given.
    pub period_s: Option<f64>,
    /// Columns of the log; recognised by their names if left out.
    pub columns: Option<Columns>,
    /// Averaging, derivatives and filters; chosen from the log if left out.
    pub preprocess: Option<Preprocess>,
    /// Estimator; `wls` if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Estimator, required = false, default = "wls"))]
    pub estimator: Option<Estimator>,
    /// Estimate a constant torque for every joint.
    #[cfg_attr(feature = "service", schema(default = false))]
    pub offset: Option<bool>,
    /// Effects with formulas of their own, beside those of the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effects: Option<Vec<OwnEffectOrName>>,
    /// How physical parameters are found; by `consistent` if left out.
    pub feasible: Option<Feasible>,
    /// Points of every series of measured and predicted torque in the answer.
    #[cfg_attr(feature = "service", schema(default = 0))]
    pub prediction_points: Option<u32>,
    /// Diagnose the residual.
    #[cfg_attr(feature = "service", schema(default = true))]
    pub trace: Option<bool>,
}

/// The model, and how to read the logs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ValidateRequest {
    /// The model that is validated, as an identification hands it out.
    pub model: Model,
    /// Columns of the log; recognised by their names if left out.
    pub columns: Option<Columns>,
    /// The design that was run, or its ID, for its period.
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub excitation: Option<Value>,
    /// Period of the motion (s), where it repeats.
    pub period_s: Option<f64>,
    /// Averaging, derivatives and filters; chosen from the log if left out.
    pub preprocess: Option<Preprocess>,
    /// Points of measured and predicted torque per joint in the answer; none if zero.
    #[cfg_attr(feature = "service", schema(default = 0))]
    pub prediction_points: Option<u32>,
    /// Trace what has changed since the model was made; needs a model with its `augmented` part.
    #[cfg_attr(feature = "service", schema(default = true))]
    pub trace: Option<bool>,
}

/// Estimator of the base parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// Ordinary least squares: every row has the same weight.
    Ols,
    /// Weighted least squares: every joint by the covariance of its noise.
    Wls,
    /// Weighted least squares with smaller weights for outliers.
    Robust,
}

/// Which column is what. Values become `matrix · (unit · scale · sign · value) + offset`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Columns {
    /// Header of the time column.
    pub time: Option<String>,
    /// Unit of the time column: `s`, `ms`, `us` or `ns`.
    #[cfg_attr(feature = "service", schema(default = "s"))]
    pub time_unit: Option<String>,
    /// Samples per second, where there is no time column.
    pub sample_rate_hz: Option<f64>,
    /// Joint positions.
    pub position: Option<ColumnQuantity>,
    /// Joint velocities; differentiated from positions if left out.
    pub velocity: Option<ColumnQuantity>,
    /// Joint torques, or motor currents with `scale`.
    pub torque: Option<ColumnQuantity>,
    /// Matrix R with motor positions p = R q: then q = R⁻¹ p, and torques Rᵀ c.
    pub coupling: Option<Vec<Vec<f64>>>,
    /// Further measured quantities, such as a temperature, that what the model leaves may depend on.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Vec<ChannelColumn>, required = false))]
    pub channels: Option<Vec<ChannelColumn>>,
}

/// A further measured quantity, in a column of the log itself. Rows may be without it where it is slow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ChannelColumn {
    /// Name in formulas: letters, digits and `_`, such as `temperature`.
    pub name: String,
    /// Header of its column; the name if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub header: Option<String>,
    /// Unit of its numbers, such as `degC`; they stay as they are. `1` if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub unit: Option<String>,
}

/// The columns of one quantity. What is per joint may be one value for all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ColumnQuantity {
    /// Column headers, one per joint in the order of the joints.
    pub headers: Option<Vec<String>>,
    /// Name of another of the logs that has these columns, row for row beside it (velocity and torque).
    pub file: Option<String>,
    /// `rad`, `deg`, `rev`, `m`, `mm`; per second for velocities, `rpm`; `N m`, `mN m`, `kN m`, `N`, `kN`, `A` for torques.
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub unit: Option<OneOrEach<String>>,
    /// Gear ratio, N·m/A.
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub scale: Option<OneOrEach<f64>>,
    /// 1 or -1.
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub sign: Option<OneOrEach<f64>>,
    /// Added at the end (rad or m, N·m or N).
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub offset: Option<OneOrEach<f64>>,
    /// Matrix (joints × columns) that couples the columns into joint values; the identity if left out.
    pub matrix: Option<Vec<Vec<f64>>>,
}

/// One value for all joints, or one for each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum OneOrEach<T> {
    /// The value for every joint.
    One(T),
    /// One value per joint, in the order of the joints.
    Each(Vec<T>),
}

/// How logs are prepared. The answer says what was chosen where nothing is given, and why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Preprocess {
    /// How derivatives and filtering are done.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = PreprocessMethod, required = false, default = "automatic"))]
    pub method: Option<PreprocessMethod>,
    /// Average over periods where the log repeats.
    #[cfg_attr(feature = "service", schema(default = true))]
    pub average: Option<bool>,
    /// Low-pass of the positions; chosen from the log if left out.
    pub position_filter: Option<Filter>,
    /// Low-pass of the torques; chosen from the log if left out.
    pub torque_filter: Option<Filter>,
    /// Time that is cut off at both ends of the log, where filters have not settled (s).
    pub discard_edges_s: Option<f64>,
    /// Keeps every n-th row after filtering; 1 keeps all.
    pub decimation: Option<u32>,
    /// Speed below which a joint's rows are left out (rad/s or m/s).
    pub dead_zone: Option<f64>,
}

/// `fourier_fit`: derivatives from the harmonics above the noise. `parallel_filter`: one filter for torque and every regressor
/// column. `paper`: order 20 at 2 Hz for positions, order 12 at 1.6 Hz for torques, central differences.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum PreprocessMethod {
    /// `fourier_fit` where the log repeats, otherwise `parallel_filter`.
    Automatic,
    /// Derivatives of a Fourier series fitted to the mean period.
    FourierFit,
    /// The same low-pass for torque and every column of the regressor.
    ParallelFilter,
    /// The filters and central differences of the paper.
    Paper,
}

/// Butterworth low-pass, run forwards and backwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Filter {
    /// Order of the filter.
    pub order: u32,
    /// Cut-off frequency, where the gain of one pass is −3 dB (Hz).
    pub cutoff_hz: f64,
}
