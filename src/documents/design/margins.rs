//! How far a trajectory stays from its limits, and the arm from what is around it.

use crate::excitation::{Design, Margin, Problem, Quantity};
use crate::model::Joint;
use serde::Serialize;

/// One side of one limit of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct MarginDocument {
    /// Name of the joint.
    pub joint: String,
    /// `position`, `velocity`, `acceleration`, `jerk`, or with torque limits `torque`.
    pub quantity: &'static str,
    /// `lower` or `upper`.
    pub side: &'static str,
    /// The limit, in `unit`.
    pub limit: f64,
    /// Extreme value reached.
    pub peak: f64,
    /// Proven bound on the extreme over all time.
    pub certified_peak: f64,
    /// Time of the extreme (s).
    pub at_s: f64,
    /// Part of the way from the middle of the range to the limit that is left.
    pub margin: f64,
    /// Left side over right side of the paper's bound (14d) or (14e), with the paper's constraints.
    pub bound_used: Option<f64>,
    /// Unit of the limit and of the extreme value: rad or m, with their time derivatives, N m or N.
    #[cfg_attr(feature = "service", schema(example = "rad/s"))]
    pub unit: &'static str,
}

/// How near a link comes to an obstacle or another link.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct ClearanceDocument {
    /// Joint that carries the link.
    pub joint: String,
    /// Name of the obstacle, or of the joint that carries the other link.
    pub from: String,
    /// Least distance seen (m).
    pub least: f64,
    /// When (s).
    pub at_s: f64,
    /// Proven bound on the least distance over all time (m).
    pub certified: f64,
    /// Distance asked for (m).
    pub asked: f64,
}

pub(super) fn margin_documents(problem: &Problem, margins: &[Margin]) -> Vec<MarginDocument> {
    let joints = problem.robot().joints();
    margins.iter().map(|m| margin_document(&joints[m.joint], m)).collect()
}

pub(super) fn clearance_documents(problem: &Problem, design: &Design) -> Vec<ClearanceDocument> {
    let joints = problem.robot().joints();
    let of = |c: &crate::excitation::Clearance| ClearanceDocument {
        joint: joints[c.joint].name.clone(),
        from: c.from.clone(),
        least: c.least,
        at_s: c.at_s,
        certified: c.certified,
        asked: c.asked,
    };
    design.clearances.iter().map(of).collect()
}

fn margin_document(joint: &Joint, m: &Margin) -> MarginDocument {
    MarginDocument {
        joint: joint.name.clone(),
        quantity: m.quantity.name(),
        side: if m.limit < m.peak { "lower" } else { "upper" },
        limit: m.limit,
        peak: m.peak,
        certified_peak: m.certified_peak,
        at_s: m.at_s,
        margin: m.margin,
        bound_used: m.bound_used,
        unit: unit(joint, m.quantity),
    }
}

fn unit(joint: &Joint, quantity: Quantity) -> &'static str {
    let units = if joint.is_revolute() {
        ["rad", "rad/s", "rad/s^2", "rad/s^3", "N m"]
    } else {
        ["m", "m/s", "m/s^2", "m/s^3", "N"]
    };
    units[quantity as usize]
}
