//! Wrong data, not wrong physics: what is checked before any effect is blamed.
//!
//! Faults of single samples (garbage, frozen, clipped, repeated times) are looked for in the columns themselves. Faults of whole columns
//! (sign, order, unit) are hypotheses about the data that the rigid model can weigh: the sum of squares that least squares leaves, for
//! every sign and every exchange of torque columns, is a quadratic form in the columns projected once.

mod clipping;
mod columns;
mod frozen;
mod garbage;
mod order;
mod reading;
mod samples;
mod seen;
mod sign;

pub use columns::column_faults;
pub use samples::{LostRows, leave_out, lost_rows, sample_faults};

use serde::Serialize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    GravityDirection,
    TorqueSign,
    JointOrder,
    UnitMismatch,
    BadSamples,
}

impl FaultKind {
    /// Name in documents.
    pub fn code(self) -> &'static str {
        match self {
            Self::GravityDirection => "gravity_direction",
            Self::TorqueSign => "torque_sign",
            Self::JointOrder => "joint_order",
            Self::UnitMismatch => "unit_mismatch",
            Self::BadSamples => "bad_samples",
        }
    }
}

/// A fault, named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DataFault {
    pub fault: FaultKind,
    /// Joints whose columns are concerned.
    pub joints: Vec<String>,
    /// What was seen, and what to do.
    pub detail: String,
    /// What can be done about it without asking.
    #[serde(skip)]
    pub remedy: Remedy,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Turning the sign round.
    Turn,
    /// Leaving the rows out that it has spoiled.
    LeaveOut,
    /// Nothing: as the data are, nothing physical can be said.
    Nothing,
}

/// A log as recorded: rows in the order of the file, before anything is repaired.
#[derive(Debug, Clone, PartialEq)]
pub struct RawLog {
    /// (s); empty where the log has none.
    pub time: Vec<f64>,
    /// Per joint.
    pub q: Vec<Vec<f64>>,
    /// Per joint.
    pub tau: Vec<Vec<f64>>,
}
