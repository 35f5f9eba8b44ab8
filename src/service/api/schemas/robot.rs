//! Robots, by their joints or as URDF.

use serde::Serialize;
use utoipa::ToSchema;

/// The name of a known robot, or a robot.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
pub enum RobotOrName {
    Name(String),
    Robot(RobotSchema),
}

/// A robot by its joints, or as a URDF or MJCF file.
#[derive(Serialize, ToSchema)]
#[schema(as = Robot)]
#[serde(untagged)]
pub enum RobotSchema {
    Joints(JointRobotSchema),
    Urdf(UrdfRobotSchema),
    Mjcf(MjcfRobotSchema),
}

/// A serial arm. Every object in it may carry a `source`: where its numbers come from.
#[derive(Serialize, ToSchema)]
#[schema(as = JointRobot)]
#[serde(deny_unknown_fields)]
pub struct JointRobotSchema {
    name: String,
    /// Acceleration of gravity in the base frame [m/s²]; `[0, 0, -9.81]` if left out.
    #[schema(required = false)]
    gravity: [f64; 3],
    joints: Vec<JointSchema>,
    /// Declared friction of every joint; both if left out.
    #[schema(required = false)]
    friction: Vec<FrictionSchema>,
    #[schema(required = false)]
    source: String,
}

/// A serial arm as a URDF document.
#[derive(Serialize, ToSchema)]
#[schema(as = UrdfRobot)]
#[serde(deny_unknown_fields)]
pub struct UrdfRobotSchema {
    /// The XML document.
    urdf: String,
    #[schema(required = false)]
    gravity: [f64; 3],
    #[schema(required = false)]
    friction: Vec<FrictionSchema>,
    /// Link that stands still; the root of the file if left out.
    base: Option<String>,
    /// Last link of the chain, where the file has several. Joints off the chain are locked at zero.
    tip: Option<String>,
    /// Capsules by the names of links, in the frames of the file, in the place of its `<collision>` shapes.
    geometry: Option<std::collections::BTreeMap<String, Vec<CapsuleSchema>>>,
    #[schema(required = false)]
    source: String,
}

/// A serial arm as an MJCF document (MuJoCo).
#[derive(Serialize, ToSchema)]
#[schema(as = MjcfRobot)]
#[serde(deny_unknown_fields)]
pub struct MjcfRobotSchema {
    /// The XML document, with everything that it includes written out.
    mjcf: String,
    /// That of the file if left out.
    #[schema(required = false)]
    gravity: [f64; 3],
    #[schema(required = false)]
    friction: Vec<FrictionSchema>,
    /// Body that stands still; the world if left out.
    base: Option<String>,
    /// Last body of the chain, where the file has several. Joints off the chain are locked at zero.
    tip: Option<String>,
    #[schema(required = false)]
    source: String,
}

#[derive(Serialize, ToSchema)]
#[schema(as = Friction, rename_all = "snake_case")]
pub enum FrictionSchema {
    Viscous,
    Coulomb,
}

/// A joint and the link it carries; placed by `mdh`, `dh` or `placement`.
#[derive(Serialize, ToSchema)]
#[schema(as = Joint)]
#[serde(deny_unknown_fields)]
pub struct JointSchema {
    name: String,
    kind: KindSchema,
    #[schema(required = false)]
    mdh: MdhSchema,
    #[schema(required = false)]
    dh: DhSchema,
    #[schema(required = false)]
    placement: PlacementSchema,
    limits: Option<LimitsSchema>,
    prior: Option<PriorSchema>,
    /// Capsules that together contain the link.
    geometry: Option<Vec<CapsuleSchema>>,
    bounds: Option<JointBoundsSchema>,
    /// Axis of the link frame along which the link is long.
    slender_axis: Option<AxisSchema>,
    /// Name of the link behind the joint.
    #[schema(required = false)]
    link: String,
    #[schema(required = false)]
    source: String,
}

/// All points within `radius` of a segment fixed to the link (m, link frame).
#[derive(Serialize, ToSchema)]
#[schema(as = Capsule)]
pub struct CapsuleSchema {
    from: [f64; 3],
    to: [f64; 3],
    radius: f64,
    #[schema(required = false)]
    source: String,
}

#[derive(Serialize, ToSchema)]
#[schema(as = JointKind, rename_all = "snake_case")]
pub enum KindSchema {
    Revolute,
    Prismatic,
}

/// Modified DH parameters of Khalil: `Rot_x(alpha) Trans_x(d) Rot_z(theta) Trans_z(r)` [rad, m].
#[derive(Serialize, ToSchema)]
#[schema(as = Mdh)]
#[serde(deny_unknown_fields)]
pub struct MdhSchema {
    alpha: f64,
    d: f64,
    theta: f64,
    r: f64,
    #[schema(required = false)]
    source: String,
}

/// A row of a DH table in the convention that it is published in.
#[derive(Serialize, ToSchema)]
#[schema(as = Dh)]
#[serde(deny_unknown_fields)]
pub struct DhSchema {
    convention: ConventionSchema,
    /// (m)
    a: f64,
    /// (rad)
    alpha: f64,
    /// (m)
    d: f64,
    /// (rad)
    theta: f64,
    #[schema(required = false)]
    source: String,
}

/// `standard`: `Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha)`, link parameters in the frame at its end. `craig` and `khalil`:
/// `Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d)`.
#[derive(Serialize, ToSchema)]
#[schema(as = DhConvention, rename_all = "snake_case")]
#[allow(dead_code)]
pub enum ConventionSchema {
    Standard,
    Craig,
    Khalil,
}

/// A joint frame in the link frame before it, as in URDF.
#[derive(Serialize, ToSchema)]
#[schema(as = Placement)]
#[serde(deny_unknown_fields)]
pub struct PlacementSchema {
    /// (m)
    #[schema(required = false)]
    xyz: [f64; 3],
    /// Roll, pitch, yaw about fixed axes (rad).
    #[schema(required = false)]
    rpy: [f64; 3],
    /// Axis of the joint in its own frame; z if left out.
    #[schema(required = false)]
    axis: [f64; 3],
    #[schema(required = false)]
    source: String,
}

/// Limits of a joint (rad, m and per second; N·m, N); what is left out or null is not limited.
#[derive(Serialize, ToSchema)]
#[schema(as = Limits)]
#[serde(deny_unknown_fields)]
pub struct LimitsSchema {
    position: Option<[f64; 2]>,
    velocity: Option<f64>,
    acceleration: Option<f64>,
    jerk: Option<f64>,
    effort: Option<f64>,
    #[schema(required = false)]
    source: String,
}

/// What is known of a link beforehand, in its own frame.
#[derive(Serialize, ToSchema)]
#[schema(as = LinkPrior)]
#[serde(deny_unknown_fields)]
pub struct PriorSchema {
    /// (kg)
    mass: f64,
    /// (m)
    center_of_mass: [f64; 3],
    inertia: InertiaSchema,
    /// [N·m·s/rad or N·s/m]
    #[schema(required = false)]
    viscous: f64,
    /// [N·m or N]
    #[schema(required = false)]
    coulomb: f64,
    #[schema(required = false)]
    source: String,
}

/// Inertia tensor about the centre of mass [kg m²].
#[derive(Serialize, ToSchema)]
#[schema(as = Inertia)]
#[serde(deny_unknown_fields)]
pub struct InertiaSchema {
    xx: f64,
    xy: f64,
    xz: f64,
    yy: f64,
    yz: f64,
    zz: f64,
}

/// What identification keeps the parameters of a link between, `[lower, upper]`, in its frame.
#[derive(Serialize, ToSchema)]
#[schema(as = JointBounds)]
pub struct JointBoundsSchema {
    /// (kg)
    mass: Option<[f64; 2]>,
    /// x, y, z in the link frame (m).
    center_of_mass: Option<Vec<Vec<f64>>>,
    /// About the centre of mass.
    inertia: Option<InertiaBoundsSchema>,
    /// N·m·s/rad or N·s/m
    viscous: Option<[f64; 2]>,
    /// N·m or N
    coulomb: Option<[f64; 2]>,
    #[schema(required = false)]
    source: String,
}

/// kg·m²
#[derive(Serialize, ToSchema)]
#[schema(as = InertiaBounds)]
pub struct InertiaBoundsSchema {
    xx: Option<[f64; 2]>,
    xy: Option<[f64; 2]>,
    xz: Option<[f64; 2]>,
    yy: Option<[f64; 2]>,
    yz: Option<[f64; 2]>,
    zz: Option<[f64; 2]>,
}

#[derive(Serialize, ToSchema)]
#[schema(as = Axis, rename_all = "snake_case")]
pub enum AxisSchema {
    X,
    Y,
    Z,
}
