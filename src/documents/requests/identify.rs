//! Logs: how they are read and prepared, to identify from or to hold against a model.

use super::feasible::Feasible;
use super::model::Model;
use super::robot::RobotOrName;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A log upload: the request and the files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct IdentifyUpload {
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
    pub request: ValidateRequest,
    /// Logs to predict: CSV, NPZ, MATLAB, Parquet, MCAP or rosbag2, plain, gzip or Zstandard.
    #[cfg_attr(feature = "service", schema(format = Binary))]
    pub log: Vec<String>,
}

/// What to make of the logs. A log has columns: `time, q1 … qn, tau1 … taun` (optional `qd1 …`), those of a well-known program, or what `columns` says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(example = json!({"robot": "iiwa14", "period_s": 10, "estimator": "wls"})))]
#[serde(deny_unknown_fields)]
pub struct IdentifyRequest {
    pub robot: RobotOrName,
    /// Id of the excitation that was executed, or its document: gives the period and the highest harmonic.
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub excitation: Option<Value>,
    /// Period of the motion (s); found in the data if neither this nor `excitation` is given.
    pub period_s: Option<f64>,
    pub columns: Option<Columns>,
    pub preprocess: Option<Preprocess>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Estimator, required = false, default = "wls"))]
    pub estimator: Option<Estimator>,
    /// Estimate a constant torque for every joint.
    #[cfg_attr(feature = "service", schema(default = false))]
    pub offset: Option<bool>,
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
    pub model: Model,
    pub columns: Option<Columns>,
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub excitation: Option<Value>,
    pub period_s: Option<f64>,
    pub preprocess: Option<Preprocess>,
    #[cfg_attr(feature = "service", schema(default = 0))]
    pub prediction_points: Option<u32>,
    /// Trace what has changed since the model was made; needs a model with its `augmented` part.
    #[cfg_attr(feature = "service", schema(default = true))]
    pub trace: Option<bool>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    Ols,
    Wls,
    Robust,
}

/// Which column is what. Values become `matrix · (unit · scale · sign · value) + offset`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Columns {
    /// Header of the time column.
    pub time: Option<String>,
    #[cfg_attr(feature = "service", schema(default = "s"))]
    pub time_unit: Option<String>,
    /// Samples per second, where there is no time column.
    pub sample_rate_hz: Option<f64>,
    pub position: Option<ColumnQuantity>,
    pub velocity: Option<ColumnQuantity>,
    pub torque: Option<ColumnQuantity>,
    /// Matrix R with motor positions p = R q: then q = R⁻¹ p, and torques Rᵀ c.
    pub coupling: Option<Vec<Vec<f64>>>,
}

/// The columns of one quantity. What is per joint may be one value for all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct ColumnQuantity {
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
    pub matrix: Option<Vec<Vec<f64>>>,
}

/// One value for all joints, or one for each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum OneOrEach<T> {
    One(T),
    Each(Vec<T>),
}

/// How logs are prepared. The answer says what was chosen where nothing is given, and why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Preprocess {
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = PreprocessMethod, required = false, default = "automatic"))]
    pub method: Option<PreprocessMethod>,
    /// Average over periods where the log repeats.
    #[cfg_attr(feature = "service", schema(default = true))]
    pub average: Option<bool>,
    pub position_filter: Option<Filter>,
    pub torque_filter: Option<Filter>,
    pub discard_edges_s: Option<f64>,
    pub decimation: Option<u32>,
    /// Speed below which a joint's rows are left out (rad/s or m/s).
    pub dead_zone: Option<f64>,
}

/// `fourier_fit`: derivatives from the harmonics above the noise. `parallel_filter`: one filter for torque and every regressor column.
/// `paper`: order 20 at 2 Hz for positions, order 12 at 1.6 Hz for torques, central differences.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum PreprocessMethod {
    Automatic,
    FourierFit,
    ParallelFilter,
    Paper,
}

/// Butterworth low-pass, run forwards and backwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Filter {
    pub order: u32,
    pub cutoff_hz: f64,
}
