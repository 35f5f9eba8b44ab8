//! A fault of the data, by name, and what was done about it.

use crate::diagnosis::report::ReportedParameter;

/// Faults of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// Gravity points elsewhere in the base frame than declared.
    GravityDirection,
    /// A torque column has the opposite sign.
    TorqueSign,
    /// Torque columns are in another order than the joints.
    JointOrder,
    /// A torque column is in another unit than stated.
    UnitMismatch,
    /// Single samples are garbage, frozen or clipped.
    BadSamples,
    /// Torques without the part that holds the arm up.
    GravityCompensatedTorque,
    /// Torques that are no torques in one unit: currents, counts, or numbers of no size that a joint has.
    UnitUnknown,
    /// Torques went through a low-pass before they were recorded.
    FilteredTorque,
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
            Self::GravityCompensatedTorque => "gravity_compensated_torque",
            Self::UnitUnknown => "unit_unknown",
            Self::FilteredTorque => "filtered_torque",
        }
    }
}

/// A fault, named.
#[derive(Debug, Clone, PartialEq)]
pub struct DataFault {
    /// Kind of the fault.
    pub fault: FaultKind,
    /// Joints whose columns are concerned.
    pub joints: Vec<String>,
    /// What was seen, and what to do.
    pub detail: String,
    /// What was done about it without asking.
    pub remedy: Remedy,
    /// Numbers that put it right, where there are any.
    pub parameters: Vec<ReportedParameter>,
}

impl DataFault {
    pub(crate) fn new(fault: FaultKind, joints: Vec<String>, detail: String, remedy: Remedy) -> Self {
        Self {
            fault,
            joints,
            detail,
            remedy,
            parameters: Vec::new(),
        }
    }
}

/// What was done about a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Turning the sign round.
    Turn,
    /// Taking gravity where the data have it.
    Reorient,
    /// Leaving the rows out that it has spoiled.
    LeaveOut,
    /// Filtering the model as the torques are.
    Filter,
    /// Nothing: as the data are, nothing physical can be said.
    Nothing,
}

impl Remedy {
    /// In a sentence.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Turn => "The sign was turned in all logs before anything was estimated.",
            Self::Reorient => "Everything was estimated with this direction; put it into the robot's description as `gravity`.",
            Self::LeaveOut => "The rows concerned were left out of the estimate.",
            Self::Filter => {
                "Every column of the model went through the same filter, which leaves the equation as it is; where the controller offers unfiltered torques, record those."
            }
            Self::Nothing => "Nothing was changed, and no effect was looked for: correct the data and identify again.",
        }
    }
}
