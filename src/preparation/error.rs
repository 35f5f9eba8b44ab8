//! Why a log cannot be prepared.

use crate::model::{decimals, shortest};
use crate::preparation::filter::FilterError;
use thiserror::Error;

/// Why a log cannot be prepared.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PreprocessError {
    #[error("log `{log}` has {actual} joints, the robot has {expected}")]
    WrongJoints { log: String, expected: usize, actual: usize },
    #[error(
        "log `{log}`: no whole period of {} s in its {} s that repeats; check the period, or take the log as one stretch",
        shortest(*.period_s), decimals(*.duration_s, 3)
    )]
    NoWholePeriod { log: String, period_s: f64, duration_s: f64 },
    #[error("log `{log}`: the method needs a log that repeats, and no period was given or found")]
    NotPeriodic { log: String },
    #[error("log `{log}`: {what}: {source}")]
    Filter {
        log: String,
        what: &'static str,
        source: FilterError,
    },
    #[error("log `{log}`: {field} is {}, which is {problem}", shortest(*.value))]
    Option {
        log: String,
        field: &'static str,
        value: f64,
        problem: &'static str,
    },
    #[error("log `{log}`: {rows} rows are left of {samples} samples after edges and decimation; record longer, or discard less")]
    NothingLeft { log: String, rows: usize, samples: usize },
    #[error(
        "log `{log}`: no joint moves: every position stays within 1 mrad (1 mm) of one value; record the arm in motion, or check the position columns"
    )]
    NothingMoves { log: String },
    #[error(
        "log `{log}`: joint {joint} has positions of {} rad (m), which no joint of an arm reaches; check the column and its unit",
        decimals(*.largest, 3)
    )]
    ImplausiblePosition { log: String, joint: usize, largest: f64 },
    #[error("log `{log}`: no torque column can be used: {reasons}")]
    NoTorque { log: String, reasons: String },
}
