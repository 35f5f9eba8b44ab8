//! Robots, by their joints or as URDF.

use super::own_effect::OwnEffectOrName;
use serde::{Deserialize, Serialize};

/// The name of a known robot, or a robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum RobotOrName {
    /// ID of a robot of the server, or of one that is built in.
    Name(String),
    /// The description in full.
    Robot(Robot),
}

/// A robot by its joints, or as a URDF or MJCF file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum Robot {
    /// Joints with modified DH parameters, DH rows or placements.
    Joints(JointRobot),
    /// A URDF file.
    Urdf(UrdfRobot),
    /// An MJCF file.
    Mjcf(MjcfRobot),
}

/// A serial arm. Every object in it may carry a `source`: where its numbers come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct JointRobot {
    /// Name of the robot.
    pub name: String,
    /// Acceleration of gravity in the base frame [m/s²]; `[0, 0, -9.81]` if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = [f64; 3], required = false))]
    pub gravity: Option<[f64; 3]>,
    /// The joints from the base to the tool.
    pub joints: Vec<Joint>,
    /// Declared friction of every joint; both if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Vec<Friction>, required = false))]
    pub friction: Option<Vec<Friction>>,
    /// Effects with formulas of their own that every identification of this robot has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effects: Option<Vec<OwnEffectOrName>>,
    /// Where the numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// A serial arm as a URDF document.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct UrdfRobot {
    /// The XML document.
    pub urdf: String,
    /// Acceleration of gravity in the base frame [m/s²]; [0, 0, −9.81] if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = [f64; 3], required = false))]
    pub gravity: Option<[f64; 3]>,
    /// Friction terms of every joint; viscous and Coulomb if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Vec<Friction>, required = false))]
    pub friction: Option<Vec<Friction>>,
    /// Link that stands still; the root of the file if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
    /// Last link of the chain, where the file has several. Joints off the chain are locked at zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip: Option<String>,
    /// Capsules by the names of links, in the frames of the file, in the place of its `<collision>` shapes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geometry: Option<std::collections::BTreeMap<String, Vec<Capsule>>>,
    /// Effects with formulas of their own that every identification of this robot has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effects: Option<Vec<OwnEffectOrName>>,
    /// Where the file comes from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// A serial arm as an MJCF document (MuJoCo).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct MjcfRobot {
    /// The XML document, with everything that it includes written out.
    pub mjcf: String,
    /// That of the file if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = [f64; 3], required = false))]
    pub gravity: Option<[f64; 3]>,
    /// Friction terms of every joint; viscous and Coulomb if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Vec<Friction>, required = false))]
    pub friction: Option<Vec<Friction>>,
    /// Body that stands still; the world if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
    /// Last body of the chain, where the file has several. Joints off the chain are locked at zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip: Option<String>,
    /// Capsules by the names of bodies, in the frames of the file, in the place of its geoms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geometry: Option<std::collections::BTreeMap<String, Vec<Capsule>>>,
    /// Effects with formulas of their own that every identification of this robot has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effects: Option<Vec<OwnEffectOrName>>,
    /// Where the file comes from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// A friction term of the declared model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Friction {
    /// `FV · qd`, in N·m·s/rad or N·s/m.
    Viscous,
    /// `FS · sign(qd)`, in N·m or N.
    Coulomb,
}

/// A joint and the link it carries; placed by `mdh`, `dh` or `placement`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// Name of the joint, unique in the robot.
    pub name: String,
    /// Whether the joint turns or slides.
    pub kind: JointKind,
    /// Placement by modified DH parameters of Khalil.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Mdh, required = false))]
    pub mdh: Option<Mdh>,
    /// Placement by a row of a DH table in its own convention.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Dh, required = false))]
    pub dh: Option<Dh>,
    /// Placement by position and orientation, as in URDF.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Placement, required = false))]
    pub placement: Option<Placement>,
    /// Limits of position, speed, acceleration, jerk and torque.
    pub limits: Option<Limits>,
    /// Assumed mass, centre of mass, inertia and friction of the link.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prior: Option<LinkPrior>,
    /// Capsules that together contain the link.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geometry: Option<Vec<Capsule>>,
    /// Bounds that identified parameters stay within.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<JointBounds>,
    /// Axis of the link frame along which the link is long.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slender_axis: Option<Axis>,
    /// Name of the link behind the joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub link: Option<String>,
    /// Where the numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// All points within `radius` of a segment fixed to the link (m, link frame).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct Capsule {
    /// One end of the segment (m).
    pub from: [f64; 3],
    /// The other end of the segment (m).
    pub to: [f64; 3],
    /// Radius, above zero (m).
    pub radius: f64,
    /// Where the numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// How a joint moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Turns about the z axis of its frame (rad, N·m).
    Revolute,
    /// Slides along the z axis of its frame (m, N).
    Prismatic,
}

/// Modified DH parameters of Khalil: `Rot_x(alpha) Trans_x(d) Rot_z(theta) Trans_z(r)` [rad, m].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Mdh {
    /// Angle between the z axes, about the x axis before (rad).
    pub alpha: f64,
    /// Distance between the z axes, along the x axis before (m).
    pub d: f64,
    /// Angle between the x axes, about z (rad); the zero position of a revolute joint.
    pub theta: f64,
    /// Distance between the x axes, along z (m); the zero position of a prismatic joint.
    pub r: f64,
    /// Where the numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// A row of a DH table in the convention that it is published in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Dh {
    /// The convention that a, alpha, d and theta are meant in.
    pub convention: DhConvention,
    /// (m)
    pub a: f64,
    /// (rad)
    pub alpha: f64,
    /// (m)
    pub d: f64,
    /// (rad)
    pub theta: f64,
    /// Where the numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// `standard`: `Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha)`, link parameters in the frame at its end. `craig` and `khalil`:
/// `Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum DhConvention {
    /// Classic DH, after Denavit and Hartenberg (1955).
    Standard,
    /// Modified DH, after Craig, "Introduction to Robotics".
    Craig,
    /// Modified DH, after Khalil and Kleinfinger (1986).
    Khalil,
}

/// A joint frame in the link frame before it, as in URDF.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// (m)
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = [f64; 3], required = false))]
    pub xyz: Option<[f64; 3]>,
    /// Roll, pitch, yaw about fixed axes (rad).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = [f64; 3], required = false))]
    pub rpy: Option<[f64; 3]>,
    /// Axis of the joint in its own frame; z if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = [f64; 3], required = false))]
    pub axis: Option<[f64; 3]>,
    /// Where the numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// Limits of a joint (rad, m and per second; N·m, N); what is left out or null is not limited.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Least and largest position [rad or m].
    pub position: Option<[f64; 2]>,
    /// Largest speed [rad/s or m/s].
    pub velocity: Option<f64>,
    /// Largest acceleration [rad/s² or m/s²].
    pub acceleration: Option<f64>,
    /// Largest jerk [rad/s³ or m/s³].
    pub jerk: Option<f64>,
    /// Largest torque [N·m] or force (N).
    pub effort: Option<f64>,
    /// Where the numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// What is known of a link beforehand, in its own frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct LinkPrior {
    /// (kg)
    pub mass: f64,
    /// (m)
    pub center_of_mass: [f64; 3],
    /// Inertia tensor about the centre of mass, in axes parallel to the link frame.
    pub inertia: Inertia,
    /// [N·m·s/rad or N·s/m]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = f64, required = false))]
    pub viscous: Option<f64>,
    /// [N·m or N]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = f64, required = false))]
    pub coulomb: Option<f64>,
    /// Where the numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// Inertia tensor about the centre of mass [kg m²].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Inertia {
    /// `∫ (y² + z²) dm` [kg m²].
    pub xx: f64,
    /// `−∫ x y dm` [kg m²].
    pub xy: f64,
    /// `−∫ x z dm` [kg m²].
    pub xz: f64,
    /// `∫ (x² + z²) dm` [kg m²].
    pub yy: f64,
    /// `−∫ y z dm` [kg m²].
    pub yz: f64,
    /// `∫ (x² + y²) dm` [kg m²].
    pub zz: f64,
}

/// What identification keeps the parameters of a link between, `[lower, upper]`, in its frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct JointBounds {
    /// (kg)
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<[f64; 2]>,
    /// x, y, z in the link frame (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub center_of_mass: Option<Vec<Vec<f64>>>,
    /// About the centre of mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia: Option<InertiaBounds>,
    /// N·m·s/rad or N·s/m
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viscous: Option<[f64; 2]>,
    /// N·m or N
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coulomb: Option<[f64; 2]>,
    /// Where the numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = String, required = false))]
    pub source: Option<String>,
}

/// kg·m²
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct InertiaBounds {
    /// Bounds of `∫ (y² + z²) dm`; null for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub xx: Option<[f64; 2]>,
    /// Bounds of `−∫ x y dm`; null for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub xy: Option<[f64; 2]>,
    /// Bounds of `−∫ x z dm`; null for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub xz: Option<[f64; 2]>,
    /// Bounds of `∫ (x² + z²) dm`; null for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yy: Option<[f64; 2]>,
    /// Bounds of `−∫ y z dm`; null for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yz: Option<[f64; 2]>,
    /// Bounds of `∫ (x² + y²) dm`; null for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zz: Option<[f64; 2]>,
}

/// An axis of a frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}
