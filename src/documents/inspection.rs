//! What was understood of logs before anything is estimated.

use super::{FindingDocument, LogDocument};
use crate::formats::logs::FoundColumns;
use serde::Serialize;

/// What was understood of the logs of an identification.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Inspection))]
pub struct InspectDocument {
    pub robot: String,
    pub logs: Vec<InspectedLog>,
    /// What to know about how the robot was read.
    pub notes: Vec<String>,
}

/// What was understood of one log.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct InspectedLog {
    #[serde(flatten)]
    pub log: LogDocument,
    pub columns: FoundColumns,
    /// (s); null where nothing repeats.
    pub period_s: Option<f64>,
    /// Whole periods found; 0 where nothing repeats.
    pub periods: usize,
    /// Inverted signs, mixed-up units or joints, frozen or clipped columns: `code` is the fault.
    pub faults: Vec<FindingDocument>,
    pub joints: Vec<InspectedJoint>,
}

/// Positions and torques of one joint as understood, in SI units, thinned with their peaks kept.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct InspectedJoint {
    pub joint: String,
    #[cfg_attr(feature = "service", schema(example = "rad"))]
    pub position_unit: &'static str,
    #[cfg_attr(feature = "service", schema(example = "N m"))]
    pub effort_unit: &'static str,
    pub position_range: [f64; 2],
    /// Share of the joint's range that the motion uses; null without limits.
    pub range_used: Option<f64>,
    pub top_speed: f64,
    pub torque_range: [f64; 2],
    /// (s)
    pub time: Vec<f64>,
    pub position: Vec<f64>,
    pub torque: Vec<f64>,
}
