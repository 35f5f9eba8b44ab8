//! Why a log cannot be prepared.

use crate::model::{decimals, shortest};
use crate::preparation::filter::FilterError;
use thiserror::Error;

/// Why a log cannot be prepared.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PreprocessError {
    /// The log has another number of joints than the robot.
    #[error("log `{log}` has {actual} joints, the robot has {expected}")]
    WrongJoints {
        /// Name of the log.
        log: String,
        /// Joints of the robot.
        expected: usize,
        /// Joints of the log.
        actual: usize,
    },
    /// The log holds no whole period that repeats.
    #[error(
        "log `{log}`: no whole period of {} s in its {} s that repeats; check the period, or take the log as one stretch",
        shortest(*.period_s), decimals(*.duration_s, 3)
    )]
    NoWholePeriod {
        /// Name of the log.
        log: String,
        /// Period that was asked for or found (s).
        period_s: f64,
        /// Length of what repeats (s).
        duration_s: f64,
    },
    /// The method is one for logs that repeat, and this one does not.
    #[error("log `{log}`: the method needs a log that repeats, and no period was given or found")]
    NotPeriodic {
        /// Name of the log.
        log: String,
    },
    /// A filter cannot be made at the rate of the log.
    #[error("log `{log}`: {what}: {source}")]
    Filter {
        /// Name of the log.
        log: String,
        /// Which filter.
        what: &'static str,
        /// Why not.
        source: FilterError,
    },
    /// An option is out of its range.
    #[error("log `{log}`: {field} is {}, which is {problem}", shortest(*.value))]
    Option {
        /// Name of the log.
        log: String,
        /// Name of the option.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// Too few rows are left.
    #[error("log `{log}`: {rows} rows are left of {samples} samples after edges and decimation; record longer, or discard less")]
    NothingLeft {
        /// Name of the log.
        log: String,
        /// Rows that are left.
        rows: usize,
        /// Samples of the log.
        samples: usize,
    },
    /// No joint moves.
    #[error(
        "log `{log}`: no joint moves: every position stays within 1 mrad (1 mm) of one value; record the arm in motion, or check the position columns"
    )]
    NothingMoves {
        /// Name of the log.
        log: String,
    },
    /// A joint has positions that no arm reaches.
    #[error(
        "log `{log}`: joint {joint} has positions of {} rad (m), which no joint of an arm reaches; check the column and its unit",
        decimals(*.largest, 3)
    )]
    ImplausiblePosition {
        /// Name of the log.
        log: String,
        /// Number of the joint, from 1.
        joint: usize,
        /// Largest position [rad or m].
        largest: f64,
    },
    /// No torque column can be used.
    #[error("log `{log}`: no torque column can be used: {reasons}")]
    NoTorque {
        /// Name of the log.
        log: String,
        /// Why not, joint by joint.
        reasons: String,
    },
}
