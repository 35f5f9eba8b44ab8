//! What was understood of logs before anything is estimated.

use super::{FindingDocument, LogDocument};
use crate::formats::logs::FoundColumns;
use serde::Serialize;

/// What was understood of the logs of an identification.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Inspection))]
pub struct InspectDocument {
    /// Name of the robot.
    pub robot: String,
    /// What was understood of every log.
    pub logs: Vec<InspectedLog>,
    /// What to know about how the robot was read.
    pub notes: Vec<String>,
}

/// What was understood of one log.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct InspectedLog {
    /// Rows, sample rate and faults of the file.
    #[serde(flatten)]
    pub log: LogDocument,
    /// The columns that positions, velocities and torques are read from.
    pub columns: FoundColumns,
    /// (s); null where nothing repeats.
    pub period_s: Option<f64>,
    /// Whole periods found; 0 where nothing repeats.
    pub periods: usize,
    /// Inverted signs, mixed-up units or joints, frozen or clipped columns: `code` is the fault.
    pub faults: Vec<FindingDocument>,
    /// Ranges and curves per joint.
    pub joints: Vec<InspectedJoint>,
}

/// Positions and torques of one joint as understood, in SI units, thinned with their peaks kept.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct InspectedJoint {
    /// Name of the joint.
    pub joint: String,
    /// `rad` for a revolute joint, `m` for a prismatic one.
    #[cfg_attr(feature = "service", schema(example = "rad"))]
    pub position_unit: &'static str,
    /// `N m` for a revolute joint, `N` for a prismatic one.
    #[cfg_attr(feature = "service", schema(example = "N m"))]
    pub effort_unit: &'static str,
    /// Least and largest position, in `position_unit`.
    pub position_range: [f64; 2],
    /// Share of the joint's range that the motion uses; null without limits.
    pub range_used: Option<f64>,
    /// Largest absolute velocity [rad/s or m/s].
    pub top_speed: f64,
    /// Least and largest torque, in `effort_unit`.
    pub torque_range: [f64; 2],
    /// (s)
    pub time: Vec<f64>,
    /// Positions at the times of the overview, in `position_unit`.
    pub position: Vec<f64>,
    /// Torques at the times of the overview, in `effort_unit`.
    pub torque: Vec<f64>,
}
