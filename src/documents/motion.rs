//! Robots and motions as they are drawn.

use super::cursor::{Cursor, Findings};
use super::requests;
use super::robot::{NamedRobots, RobotDocument, read_robot_or_name};
use super::warm_start::read_trajectory;
use crate::formats::json::Parsed;
use crate::model::FieldProblem;
use crate::trajectory::FourierSeries;
use serde::Serialize;

/// Samples of one period beyond which no screen shows more.
const MOST_SAMPLES: u64 = 20_000;
const USUAL_SAMPLES: u64 = 1_000;

/// A checked request.
#[derive(Debug, Clone)]
pub struct MotionRequest {
    /// The robot that is drawn.
    pub robot: RobotDocument,
    /// The trajectory; nothing to draw the robot at rest only.
    pub series: Option<FourierSeries>,
    /// Number of samples over one period.
    pub samples: usize,
}

/// A robot as it is drawn, and what a motion asks of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Motion))]
pub struct MotionDocument {
    /// Name of the robot.
    pub robot: String,
    /// In the base frame [m/s²].
    pub gravity: [f64; 3],
    /// The joints from the base on.
    pub joints: Vec<DrawnJoint>,
    /// The sampled motion; null without a trajectory.
    pub motion: Option<SampledMotion>,
    /// Capsules that self-collision and obstacles are checked with, in the frames of the joints.
    pub shape: Vec<DrawnCapsule>,
    /// Whether nobody described the shape, and it was made from the kinematics.
    pub shape_guessed: bool,
    /// The robot by its joints, as `POST /robots` takes it: of a URDF file, all that was read.
    pub description: requests::JointRobot,
    /// What to know about how the robot was read.
    pub notes: Vec<String>,
}

/// A joint: it turns about, or slides along, the z axis of its frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct DrawnJoint {
    /// Name of the joint.
    pub name: String,
    /// `revolute` or `prismatic`.
    pub kind: &'static str,
    /// Pose of the joint's frame in the one before it at q = 0: rows of the rotation.
    pub rotation: [[f64; 3]; 3],
    /// (m)
    pub translation: [f64; 3],
    /// Rotation from this frame to the link frame of the robot's description, in which link parameters are given.
    pub description_frame: [[f64; 3]; 3],
    /// Least and largest position, in `position_unit`; null without a limit.
    pub position_limits: Option<[f64; 2]>,
    /// Largest speed [rad/s or m/s]; null without a limit.
    pub velocity_limit: Option<f64>,
    /// Largest acceleration [rad/s² or m/s²]; null without a limit.
    pub acceleration_limit: Option<f64>,
    /// Largest jerk [rad/s³ or m/s³]; null without a limit.
    pub jerk_limit: Option<f64>,
    /// Largest torque or force, in `effort_unit`; null without a limit.
    pub effort_limit: Option<f64>,
    /// `rad` for a revolute joint, `m` for a prismatic one.
    #[cfg_attr(feature = "service", schema(example = "rad"))]
    pub position_unit: &'static str,
    /// `N m` for a revolute joint, `N` for a prismatic one.
    #[cfg_attr(feature = "service", schema(example = "N m"))]
    pub effort_unit: &'static str,
    /// What was known of the link beforehand, in this frame.
    pub prior: Option<DrawnLink>,
}

/// All points within a distance of a segment.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct DrawnCapsule {
    /// Number of the joint that moves it.
    pub joint: usize,
    /// (m)
    pub from: [f64; 3],
    /// (m)
    pub to: [f64; 3],
    /// (m)
    pub radius: f64,
}

/// A link as a body, in the frame of its joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct DrawnLink {
    /// (kg)
    pub mass: f64,
    /// (m)
    pub center_of_mass: [f64; 3],
    /// About the centre of mass [kg m²].
    pub inertia: [[f64; 3]; 3],
}

/// One period, sampled evenly; every list has one entry per joint, in it one per sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct SampledMotion {
    /// (s)
    pub time: Vec<f64>,
    /// Positions `q[i][k]` of joint i at sample k [rad or m].
    pub q: Vec<Vec<f64>>,
    /// Velocities `qd[i][k]` [rad/s or m/s].
    pub qd: Vec<Vec<f64>>,
    /// Accelerations `qdd[i][k]` [rad/s² or m/s²].
    pub qdd: Vec<Vec<f64>>,
    /// Expected torque `torque[i][k]` from the robot's prior parameters [N m or N]; null where a link has none.
    pub torque: Option<Vec<Vec<f64>>>,
    /// Origin of the last frame in the base frame (m), per sample.
    pub end: Vec<[f64; 3]>,
}

/// Reads a request.
///
/// # Errors
/// Everything that is wrong with it and its robot.
pub fn read_motion_request(parsed: &Parsed, known: &dyn NamedRobots) -> Result<MotionRequest, Vec<FieldProblem>> {
    let findings = Findings::new(parsed.problems.clone());
    let read = read(&Cursor::root(&parsed.value, &findings), known);
    match read {
        Some(request) if findings.is_empty() => Ok(request),
        _ => Err(findings.into_list()),
    }
}

fn read(cursor: &Cursor, known: &dyn NamedRobots) -> Option<MotionRequest> {
    let fields = cursor.fields_of::<requests::MotionRequest>()?;
    let robot = fields.required("robot").and_then(|c| read_robot_or_name(&c, known));
    let samples = fields.nullable("samples").and_then(|c| c.whole(2, MOST_SAMPLES));
    let joints = robot.as_ref().map(|r| r.robot.joint_count());
    let series = fields
        .nullable("trajectory")
        .and_then(|c| read_trajectory(&c, &c.fields_of::<requests::Series>()?, joints));
    Some(MotionRequest {
        robot: robot?,
        series,
        samples: samples.unwrap_or(USUAL_SAMPLES) as usize,
    })
}
