//! What was understood of a robot's document.

use super::robot::RobotDocument;
use crate::model::{Joint, Robot};
use crate::parameters::BaseParameters;
use serde::Serialize;

/// A robot as it was understood: its chain, limits, bodies, and what to know about how it was read.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = RobotReport))]
pub struct RobotReport {
    /// Name of the robot.
    pub robot: String,
    /// In the base frame [m/s²].
    pub gravity: [f64; 3],
    /// From base to tip.
    pub joints: Vec<ReportedJoint>,
    /// Sum over all links that move (kg); null where a link has no prior.
    pub moving_mass_kg: Option<f64>,
    /// Number of base parameters, friction included.
    pub base_parameters: usize,
    /// What was locked, left out, or read otherwise than it is written.
    pub notes: Vec<String>,
}

/// A joint and the link it carries, with all that is locked to it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct ReportedJoint {
    /// Name of the joint.
    pub name: String,
    /// `revolute` or `prismatic`.
    pub kind: &'static str,
    /// The link behind the joint.
    pub link: String,
    /// Null: no limit is known.
    pub position: Option<[f64; 2]>,
    /// Largest speed [rad/s or m/s]; null without a limit.
    pub velocity: Option<f64>,
    /// Largest acceleration [rad/s² or m/s²]; null without a limit.
    pub acceleration: Option<f64>,
    /// Largest jerk [rad/s³ or m/s³]; null without a limit.
    pub jerk: Option<f64>,
    /// Largest torque or force, in `effort_unit`; null without a limit.
    pub effort: Option<f64>,
    /// `rad` for a revolute joint, `m` for a prismatic one.
    #[cfg_attr(feature = "service", schema(example = "rad"))]
    pub position_unit: &'static str,
    /// `N m` for a revolute joint, `N` for a prismatic one.
    #[cfg_attr(feature = "service", schema(example = "N m"))]
    pub effort_unit: &'static str,
    /// (kg); null where the link has no prior.
    pub mass: Option<f64>,
    /// From the joint's axis frame (m).
    pub center_of_mass: Option<[f64; 3]>,
    /// Capsules that contain the link.
    pub capsules: usize,
}

impl RobotReport {
    /// Lists the joints and limits as they were read, with notes on what was left out.
    pub fn from_document(read: &RobotDocument) -> Self {
        let robot: &Robot = &read.robot;
        let masses: Option<Vec<f64>> = robot.joints().iter().map(|j| Some(j.prior?.inertia.mass)).collect();
        Self {
            robot: robot.name().to_string(),
            gravity: robot.gravity().into(),
            joints: robot.joints().iter().map(reported).collect(),
            moving_mass_kg: masses.map(|m| m.iter().sum()),
            base_parameters: BaseParameters::exact(robot).len(),
            notes: read.notes.clone(),
        }
    }
}

fn reported(joint: &Joint) -> ReportedJoint {
    let l = &joint.limits;
    ReportedJoint {
        name: joint.name.clone(),
        kind: if joint.is_revolute() { "revolute" } else { "prismatic" },
        link: joint.link_name.clone(),
        position: l.position,
        velocity: l.velocity,
        acceleration: l.acceleration,
        jerk: l.jerk,
        effort: l.effort,
        position_unit: joint.position_unit(),
        effort_unit: joint.effort_unit(),
        mass: joint.prior.map(|p| p.inertia.mass),
        center_of_mass: joint
            .prior
            .map(|p| (joint.description_frame * p.inertia.center_of_mass).into()),
        capsules: joint.geometry.len(),
    }
}
