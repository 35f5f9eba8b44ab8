//! Logs: how they are read and prepared, to identify from or to hold against a model.

use super::feasible::FeasibleSchema;
use super::model::ModelSchema;
use super::robot::RobotOrName;
use serde::Serialize;
use utoipa::ToSchema;

/// A log upload: the request and the files.
#[derive(Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct IdentifyUpload {
    request: IdentifyRequestSchema,
    /// Logs to identify from: CSV, NPZ, MATLAB, Parquet, MCAP or rosbag2, plain, gzip or Zstandard.
    #[schema(format = Binary)]
    log: Vec<String>,
    /// Logs that the fit does not see.
    #[schema(format = Binary, required = false)]
    validation: Vec<String>,
}

/// A log to look at.
#[derive(Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LogUpload {
    /// CSV, NPZ, MATLAB, Parquet, MCAP or rosbag2, plain, gzip or Zstandard.
    #[schema(format = Binary)]
    log: String,
}

/// A model, and logs to hold against it.
#[derive(Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ValidateUpload {
    request: ValidateRequestSchema,
    /// Logs to predict: CSV, NPZ, MATLAB, Parquet, MCAP or rosbag2, plain, gzip or Zstandard.
    #[schema(format = Binary)]
    log: Vec<String>,
}

/// What to make of the logs. A log has columns: `time, q1 … qn, tau1 … taun` (optional `qd1 …`), those of a well-known program, or what `columns` says.
#[derive(Serialize, ToSchema)]
#[schema(as = IdentifyRequest, example = json!({"robot": "iiwa14", "period_s": 10, "estimator": "wls"}))]
#[serde(deny_unknown_fields)]
pub struct IdentifyRequestSchema {
    robot: RobotOrName,
    /// Id of the excitation that was executed, or its document: gives the period and the highest harmonic.
    #[schema(value_type = Option<Object>)]
    excitation: Option<String>,
    /// Period of the motion (s); found in the data if neither this nor `excitation` is given.
    period_s: Option<f64>,
    columns: Option<ColumnsSchema>,
    preprocess: Option<PreprocessSchema>,
    #[schema(required = false, default = "wls")]
    estimator: EstimatorSchema,
    /// Estimate a constant torque for every joint.
    #[schema(default = false)]
    offset: Option<bool>,
    feasible: Option<FeasibleSchema>,
    /// Points of every series of measured and predicted torque in the answer.
    #[schema(default = 0)]
    prediction_points: Option<u32>,
    /// Diagnose the residual.
    #[schema(default = true)]
    trace: Option<bool>,
}

/// The model, and how to read the logs.
#[derive(Serialize, ToSchema)]
#[schema(as = ValidateRequest)]
#[serde(deny_unknown_fields)]
pub struct ValidateRequestSchema {
    model: ModelSchema,
    columns: Option<ColumnsSchema>,
    #[schema(value_type = Option<Object>)]
    excitation: Option<String>,
    period_s: Option<f64>,
    preprocess: Option<PreprocessSchema>,
    #[schema(default = 0)]
    prediction_points: Option<u32>,
    /// Trace what has changed since the model was made; needs a model with its `augmented` part.
    #[schema(default = true)]
    trace: Option<bool>,
}

#[derive(Serialize, ToSchema)]
#[schema(as = Estimator, rename_all = "snake_case")]
pub enum EstimatorSchema {
    Ols,
    Wls,
    Robust,
}

/// Which column is what. Values become `matrix · (unit · scale · sign · value) + offset`.
#[derive(Serialize, ToSchema)]
#[schema(as = Columns)]
#[serde(deny_unknown_fields)]
pub struct ColumnsSchema {
    /// Header of the time column.
    time: Option<String>,
    #[schema(default = "s")]
    time_unit: Option<String>,
    /// Samples per second, where there is no time column.
    sample_rate_hz: Option<f64>,
    position: Option<ColumnQuantitySchema>,
    velocity: Option<ColumnQuantitySchema>,
    torque: Option<ColumnQuantitySchema>,
    /// Matrix R with motor positions p = R q: then q = R⁻¹ p, and torques Rᵀ c.
    coupling: Option<Vec<Vec<f64>>>,
}

/// The columns of one quantity. What is per joint may be one value for all.
#[derive(Serialize, ToSchema)]
#[schema(as = ColumnQuantity)]
#[serde(deny_unknown_fields)]
pub struct ColumnQuantitySchema {
    headers: Option<Vec<String>>,
    /// Name of another of the logs that has these columns, row for row beside it (velocity and torque).
    file: Option<String>,
    /// `rad`, `deg`, `rev`, `m`, `mm`; per second for velocities, `rpm`; `N m`, `mN m`, `kN m`, `N`, `kN`, `A` for torques.
    #[schema(value_type = Option<Object>)]
    unit: Option<Vec<String>>,
    /// Gear ratio, N·m/A.
    #[schema(value_type = Option<Object>)]
    scale: Option<Vec<f64>>,
    /// 1 or -1.
    #[schema(value_type = Option<Object>)]
    sign: Option<Vec<f64>>,
    /// Added at the end (rad or m, N·m or N).
    #[schema(value_type = Option<Object>)]
    offset: Option<Vec<f64>>,
    matrix: Option<Vec<Vec<f64>>>,
}

/// How logs are prepared. The answer says what was chosen where nothing is given, and why.
#[derive(Serialize, ToSchema)]
#[schema(as = Preprocess)]
#[serde(deny_unknown_fields)]
pub struct PreprocessSchema {
    #[schema(required = false, default = "automatic")]
    method: MethodSchema,
    /// Average over periods where the log repeats.
    #[schema(default = true)]
    average: Option<bool>,
    position_filter: Option<FilterSchema>,
    torque_filter: Option<FilterSchema>,
    discard_edges_s: Option<f64>,
    decimation: Option<u32>,
    /// Speed below which a joint's rows are left out (rad/s or m/s).
    dead_zone: Option<f64>,
}

/// `fourier_fit`: derivatives from the harmonics above the noise. `parallel_filter`: one filter for torque and every regressor column.
/// `paper`: order 20 at 2 Hz for positions, order 12 at 1.6 Hz for torques, central differences.
#[derive(Serialize, ToSchema)]
#[schema(as = PreprocessMethod, rename_all = "snake_case")]
pub enum MethodSchema {
    Automatic,
    FourierFit,
    ParallelFilter,
    Paper,
}

/// Butterworth low-pass, run forwards and backwards.
#[derive(Serialize, ToSchema)]
#[schema(as = Filter)]
#[serde(deny_unknown_fields)]
pub struct FilterSchema {
    order: u32,
    cutoff_hz: f64,
}
