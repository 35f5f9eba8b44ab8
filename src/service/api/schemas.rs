//! What requests look like, for the documentation. Requests are read by [`crate::io`]; a test holds the two together.
#![allow(dead_code)]

use serde::Serialize;
use utoipa::ToSchema;

/// A request for an excitation trajectory.
#[derive(Serialize, ToSchema)]
#[schema(as = ExcitationRequest, example = json!({
    "robot": "iiwa14",
    "fourier": {"order": 5, "fundamental_hz": 0.1},
    "sample_rate_hz": 100,
    "criterion": "condition_number",
    "constraints": {"form": "paper", "start": "zero"},
    "search": {"seed": 1, "starts": 64, "time_limit_s": 10}
}))]
#[serde(deny_unknown_fields)]
pub struct ExcitationRequestSchema {
    /// That of `model` if left out.
    #[schema(required = false)]
    robot: RobotOrName,
    fourier: FourierSchema,
    /// Samples per second of the observation matrix.
    #[schema(exclusive_minimum = 0)]
    sample_rate_hz: f64,
    #[schema(required = false, default = "condition_number")]
    criterion: CriterionSchema,
    #[schema(required = false)]
    constraints: ConstraintsSchema,
    /// Standard deviation of the torque noise of every joint [N·m or N], for predicted accuracies; that of the data of `model`, or 1, if left out.
    torque_noise: Option<Vec<f64>>,
    #[schema(required = false)]
    search: SearchSchema,
    /// Model to design for: the columns of its effects join Y_b in every criterion.
    model: Option<DesignModelSchema>,
    /// Two explanations of one residual, for `rival_evidence`.
    rivals: Option<RivalsSchema>,
    /// What is known already: its information is added to that of the new trajectory in every criterion. Up to 100: an identification holds
    /// what all of its logs say.
    #[schema(max_items = 100)]
    given: Option<Vec<GivenSchema>>,
    /// Periods of the new trajectory that will be recorded.
    #[schema(default = 1, minimum = 1)]
    periods: Option<u32>,
    /// Trajectories that complement each other, up to 10: each is designed with those before it as given.
    #[schema(default = 1, minimum = 1, maximum = 10)]
    trajectories: Option<u32>,
    /// Factor on the amplitudes, for a first run in the answer.
    #[schema(exclusive_minimum = 0, maximum = 1)]
    backoff: Option<f64>,
    /// An earlier trajectory to go on from, as a design hands it out; of whatever problem for a robot with as many joints.
    warm_start: Option<WarmStartSchema>,
}

/// A model by the id of its identification, or itself.
#[derive(Serialize, ToSchema)]
#[schema(as = DesignModel)]
#[serde(untagged)]
pub enum DesignModelSchema {
    Reference(ReferenceSchema),
    Model(Box<ModelSchema>),
}

#[derive(Serialize, ToSchema)]
#[schema(as = IdentificationReference)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSchema {
    /// Id of a finished identification.
    identification: String,
}

/// A finding of `model`, and one of the rivals that its data do not exclude.
#[derive(Serialize, ToSchema)]
#[schema(as = Rivals)]
#[serde(deny_unknown_fields)]
pub struct RivalsSchema {
    finding: PlaceOrNumberSchema,
    rival: PlaceOrNumberSchema,
}

/// Effect and joints as in `residual.findings`, or the place in the list of the model's effects, or of that effect's rivals.
#[derive(Serialize, ToSchema)]
#[schema(as = EffectPlaceOrNumber)]
#[serde(untagged)]
pub enum PlaceOrNumberSchema {
    Place(PlaceSchema),
    Number(u32),
}

#[derive(Serialize, ToSchema)]
#[schema(as = EffectPlace)]
#[serde(deny_unknown_fields)]
pub struct PlaceSchema {
    #[schema(example = "torque_offset")]
    effect: String,
    joints: Option<Vec<String>>,
}

/// Data or trajectories there are already.
#[derive(Serialize, ToSchema)]
#[schema(as = Given)]
#[serde(untagged)]
pub enum GivenSchema {
    Identification(ReferenceSchema),
    Design(GivenDesignSchema),
    Trajectory(GivenTrajectorySchema),
    Model(Box<ModelSchema>),
}

#[derive(Serialize, ToSchema)]
#[schema(as = GivenDesign)]
#[serde(deny_unknown_fields)]
pub struct GivenDesignSchema {
    /// Id of a finished design.
    excitation: String,
    /// Periods recorded.
    #[schema(default = 1, minimum = 1)]
    periods: Option<u32>,
}

#[derive(Serialize, ToSchema)]
#[schema(as = GivenTrajectory)]
#[serde(deny_unknown_fields)]
pub struct GivenTrajectorySchema {
    coefficients: crate::io::Coefficients,
    /// Position of every joint around which it moves [rad or m].
    offset: Vec<f64>,
    fundamental_hz: f64,
    /// Periods recorded.
    #[schema(default = 1, minimum = 1)]
    periods: Option<u32>,
}

/// An earlier trajectory.
#[derive(Serialize, ToSchema)]
#[schema(as = WarmStart)]
#[serde(deny_unknown_fields)]
pub struct WarmStartSchema {
    coefficients: crate::io::Coefficients,
    /// Position of every joint around which it moves [rad or m].
    offset: Vec<f64>,
    fundamental_hz: f64,
}

/// The finite Fourier series of every joint.
#[derive(Serialize, ToSchema)]
#[schema(as = Fourier)]
#[serde(deny_unknown_fields)]
pub struct FourierSchema {
    /// Harmonics L, 2 to 50.
    order: u32,
    /// Fundamental frequency; the period is its inverse. Of a list the best is found, for recordings of equal length.
    fundamental_hz: OneOrSeveral,
    /// Harmonics of every joint, at least two each; all up to the order if left out.
    harmonics: Option<Vec<Vec<u32>>>,
}

#[derive(Serialize, ToSchema)]
#[serde(untagged)]
pub enum OneOrSeveral {
    One(f64),
    Several(Vec<f64>),
}

/// What is minimised.
#[derive(Serialize, ToSchema)]
#[schema(as = Criterion, rename_all = "snake_case")]
pub enum CriterionSchema {
    ConditionNumber,
    ScaledConditionNumber,
    DOptimality,
    AOptimality,
    IOptimality,
    /// Greatest expected evidence between two rivals; needs `model` and `rivals`.
    RivalEvidence,
    /// What is recommended: `i_optimality`.
    Recommended,
}

#[derive(Serialize, ToSchema)]
#[schema(as = Constraints)]
#[serde(deny_unknown_fields)]
pub struct ConstraintsSchema {
    /// `paper`: triangle-inequality bounds on the coefficients, (14d) to (14g). `exact`: the true extremes over time.
    #[schema(required = false, default = "paper")]
    form: FormSchema,
    /// `zero`: the motion starts and ends at rest in the start position. `free`: at rest anywhere.
    #[schema(required = false, default = "zero")]
    start: StartSchema,
    /// Position of every joint at the start [rad or m]; zero, or the middle of the range, if left out.
    start_position: Option<Vec<f64>>,
    /// Limits on torques, predicted by the robot's prior link parameters; none if left out.
    torque: Option<TorqueLimitsSchema>,
    /// What the arm keeps off; needs `geometry` of its joints. Nothing if left out.
    space: Option<SpaceLimitsSchema>,
}

/// What the arm keeps off, in the base frame.
#[derive(Serialize, ToSchema)]
#[schema(as = SpaceLimits)]
pub struct SpaceLimitsSchema {
    /// Least distance kept from everything (m).
    #[schema(default = 0.02)]
    clearance: Option<f64>,
    /// Floors, walls: the arm stays where `normal · p >= offset`.
    half_spaces: Option<Vec<HalfSpaceSchema>>,
    /// Boxes that the arm stays out of, with edges along the axes of the base frame.
    boxes: Option<Vec<BoxSchema>>,
    /// Links keep off each other, but for neighbours and the pairs named.
    self_collision: Option<SelfCollisionSchema>,
}

#[derive(Serialize, ToSchema)]
#[schema(as = HalfSpace)]
pub struct HalfSpaceSchema {
    #[schema(example = "floor")]
    name: String,
    normal: [f64; 3],
    /// (m)
    offset: f64,
}

#[derive(Serialize, ToSchema)]
#[schema(as = Box)]
pub struct BoxSchema {
    #[schema(example = "table")]
    name: String,
    /// (m)
    center: [f64; 3],
    /// Lengths of the edges (m).
    size: [f64; 3],
}

#[derive(Serialize, ToSchema)]
#[schema(as = SelfCollision)]
pub struct SelfCollisionSchema {
    /// Pairs of joint names whose links may touch.
    ignore: Option<Vec<[String; 2]>>,
}

/// Torque limits along the trajectory.
#[derive(Serialize, ToSchema)]
#[schema(as = TorqueLimits)]
#[serde(deny_unknown_fields)]
pub struct TorqueLimitsSchema {
    /// Largest torque of every joint [N·m or N]; the robot's `effort` limits if left out.
    limits: Option<Vec<f64>>,
    /// Predicted torques stay below the limit over this factor.
    #[schema(default = 1.25, minimum = 1.0)]
    safety_factor: Option<f64>,
}

#[derive(Serialize, ToSchema)]
#[schema(as = Form, rename_all = "snake_case")]
pub enum FormSchema {
    Paper,
    Exact,
}

#[derive(Serialize, ToSchema)]
#[schema(as = Start, rename_all = "snake_case")]
pub enum StartSchema {
    Zero,
    Free,
}

/// How long and how widely to search.
#[derive(Serialize, ToSchema)]
#[schema(as = Search)]
#[serde(deny_unknown_fields)]
pub struct SearchSchema {
    /// The same seed and number of evaluations give the same answer.
    #[schema(default = 1)]
    seed: Option<u64>,
    /// Random starts made at least before a search without limits may end.
    #[schema(default = 64)]
    starts: Option<u32>,
    /// Time after which the best trajectory found is handed back (s), up to a day. All of it is used. If it is left out, the search ends
    /// when it has converged, after 60 s at the latest.
    time_limit_s: Option<f64>,
    /// Evaluations of the criterion after which no new round begins.
    max_evaluations: Option<u64>,
    /// Local solves per round, so many at most run at the same time: raise it on a machine with more than sixteen cores. Part of what
    /// makes a run repeatable.
    #[schema(default = 16)]
    jobs_per_round: Option<u32>,
}

/// The name of a known robot, or a robot.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
pub enum RobotOrName {
    Name(String),
    Robot(RobotSchema),
}

/// A robot by its joints, or as a URDF file.
#[derive(Serialize, ToSchema)]
#[schema(as = Robot)]
#[serde(untagged)]
pub enum RobotSchema {
    Joints(JointRobotSchema),
    Urdf(UrdfRobotSchema),
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
    /// Last link of the chain, where the file has several.
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

/// A joint and the link it carries; placed by `mdh` or by `placement`.
#[derive(Serialize, ToSchema)]
#[schema(as = Joint)]
#[serde(deny_unknown_fields)]
pub struct JointSchema {
    name: String,
    kind: KindSchema,
    #[schema(required = false)]
    mdh: MdhSchema,
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

/// A log upload: the request and the files.
#[derive(Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct IdentifyUpload {
    request: IdentifyRequestSchema,
    /// Logs to identify from: CSV, plain or gzip.
    #[schema(format = Binary)]
    log: Vec<String>,
    /// Logs that the fit does not see.
    #[schema(format = Binary, required = false)]
    validation: Vec<String>,
}

/// A model, and logs to hold against it.
#[derive(Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ValidateUpload {
    request: ValidateRequestSchema,
    /// Logs to predict: CSV, plain or gzip.
    #[schema(format = Binary)]
    log: Vec<String>,
}

/// What to make of the logs. A log is a table with a header: `time, q1 … qn, tau1 … taun` (optional `qd1 …`), or as `columns` says.
#[derive(Serialize, ToSchema)]
#[schema(as = IdentifyRequest, example = json!({"robot": "iiwa14", "period_s": 10, "estimator": "wls"}))]
#[serde(deny_unknown_fields)]
pub struct IdentifyRequestSchema {
    robot: RobotOrName,
    /// Id of the excitation that was executed, or its document: gives the period and the highest harmonic.
    #[schema(value_type = Option<Object>)]
    excitation: Option<String>,
    /// Period of the motion (s); found in the data if neither this nor `excitation` is given.
    period_s: Option<f64>,
    columns: Option<ColumnsSchema>,
    preprocess: Option<PreprocessSchema>,
    #[schema(required = false, default = "wls")]
    estimator: EstimatorSchema,
    /// Estimate a constant torque for every joint.
    #[schema(default = false)]
    offset: Option<bool>,
    feasible: Option<FeasibleSchema>,
    /// Points of every series of measured and predicted torque in the answer.
    #[schema(default = 0)]
    prediction_points: Option<u32>,
    /// Trace what the model leaves over.
    #[schema(default = true)]
    trace: Option<bool>,
}

/// The model, and how to read the logs.
#[derive(Serialize, ToSchema)]
#[schema(as = ValidateRequest)]
#[serde(deny_unknown_fields)]
pub struct ValidateRequestSchema {
    model: ModelSchema,
    columns: Option<ColumnsSchema>,
    #[schema(value_type = Option<Object>)]
    excitation: Option<String>,
    period_s: Option<f64>,
    preprocess: Option<PreprocessSchema>,
    #[schema(default = 0)]
    prediction_points: Option<u32>,
    /// Trace what has changed since the model was made; needs a model with its `augmented` part.
    #[schema(default = true)]
    trace: Option<bool>,
}

/// The JSON model of an identification; a robot with parameters for every link does as well.
#[derive(Serialize, ToSchema)]
#[schema(as = Model)]
#[serde(deny_unknown_fields)]
pub struct ModelSchema {
    robot: RobotOrName,
    /// Constant torque of every joint (N·m or N).
    offsets: Option<Vec<f64>>,
    #[schema(value_type = Option<Vec<Object>>)]
    base_parameters: Option<Vec<String>>,
    /// What tracing has added; needed to tell what has changed since.
    augmented: Option<AugmentedModelSchema>,
    /// In words, what a URDF of this model does not hold.
    not_in_urdf: Option<Vec<String>>,
}

/// Effects with the base parameters they were fitted with, and how well all are known.
#[derive(Serialize, ToSchema)]
#[schema(as = AugmentedModel)]
pub struct AugmentedModelSchema {
    effects: Vec<AddedEffectSchema>,
    base_values: Vec<f64>,
    /// Inverse covariance of the base values, then of coefficients and free shapes effect by effect.
    information: Vec<Vec<f64>>,
    noise: Option<ModelNoiseSchema>,
}

/// Torque noise of the data, as white noise that hides slow signals as much.
#[derive(Serialize, ToSchema)]
#[schema(as = ModelNoise)]
#[serde(deny_unknown_fields)]
pub struct ModelNoiseSchema {
    /// Of every joint [N·m or N].
    std_dev: Vec<f64>,
    /// Rows per second that it is of.
    rate_hz: f64,
}

/// An effect with its values.
#[derive(Serialize, ToSchema)]
#[schema(as = AddedEffect)]
pub struct AddedEffectSchema {
    #[schema(example = "torque_offset")]
    effect: String,
    joints: Vec<String>,
    /// Variant of the effect, from 0.
    form: u32,
    coefficients: Vec<f64>,
    shape: Vec<f64>,
    /// How many of the shape parameters were estimated, from the first.
    free_shapes: u32,
    /// Least and largest value of every shape parameter; null is none.
    bounds: Vec<Vec<Option<f64>>>,
    /// The same values by name, with units.
    #[schema(value_type = Option<Vec<Object>>)]
    parameters: Option<Vec<String>>,
    /// Effects that the data do not exclude in its place.
    rivals: Option<Vec<RivalEffectSchema>>,
}

/// A rival of an effect, as it was fitted in its place.
#[derive(Serialize, ToSchema)]
#[schema(as = RivalEffect)]
pub struct RivalEffectSchema {
    #[schema(example = "torque_offset")]
    effect: String,
    joints: Vec<String>,
    /// Variant of the effect, from 0.
    form: u32,
    coefficients: Vec<f64>,
    shape: Vec<f64>,
    /// How many of the shape parameters were estimated, from the first.
    free_shapes: u32,
    /// Least and largest value of every shape parameter; null is none.
    bounds: Vec<Vec<Option<f64>>>,
    /// The same values by name, with units.
    #[schema(value_type = Option<Vec<Object>>)]
    parameters: Option<Vec<String>>,
    /// Twice the log of the evidence ratio in favour of the finding.
    evidence: f64,
    /// Base parameters of that fit.
    base_values: Vec<f64>,
    /// Information that its columns have in common with those of the model.
    cross: Vec<Vec<f64>>,
    /// Information of its own columns.
    own: Vec<Vec<f64>>,
}

#[derive(Serialize, ToSchema)]
#[schema(as = Estimator, rename_all = "snake_case")]
pub enum EstimatorSchema {
    Ols,
    Wls,
    Robust,
}

/// Which column is what. Values become `matrix · (unit · scale · sign · value) + offset`.
#[derive(Serialize, ToSchema)]
#[schema(as = Columns)]
#[serde(deny_unknown_fields)]
pub struct ColumnsSchema {
    /// Header of the time column.
    time: Option<String>,
    #[schema(default = "s")]
    time_unit: Option<String>,
    /// Samples per second, where there is no time column.
    sample_rate_hz: Option<f64>,
    position: Option<ColumnQuantitySchema>,
    velocity: Option<ColumnQuantitySchema>,
    torque: Option<ColumnQuantitySchema>,
    /// Matrix R with motor positions p = R q: then q = R⁻¹ p, and torques Rᵀ c.
    coupling: Option<Vec<Vec<f64>>>,
}

/// The columns of one quantity. What is per joint may be one value for all.
#[derive(Serialize, ToSchema)]
#[schema(as = ColumnQuantity)]
#[serde(deny_unknown_fields)]
pub struct ColumnQuantitySchema {
    headers: Option<Vec<String>>,
    /// Name of another of the logs that has these columns, row for row beside it (velocity and torque).
    file: Option<String>,
    /// `rad`, `deg`, `rev`, `m`, `mm`; per second for velocities, `rpm`; `N m`, `mN m`, `kN m`, `N`, `kN`, `A` for torques.
    #[schema(value_type = Option<Object>)]
    unit: Option<Vec<String>>,
    /// Gear ratio, N·m/A.
    #[schema(value_type = Option<Object>)]
    scale: Option<Vec<f64>>,
    /// 1 or -1.
    #[schema(value_type = Option<Object>)]
    sign: Option<Vec<f64>>,
    /// Added at the end (rad or m, N·m or N).
    #[schema(value_type = Option<Object>)]
    offset: Option<Vec<f64>>,
    matrix: Option<Vec<Vec<f64>>>,
}

/// How logs are prepared. The answer says what was chosen where nothing is given, and why.
#[derive(Serialize, ToSchema)]
#[schema(as = Preprocess)]
#[serde(deny_unknown_fields)]
pub struct PreprocessSchema {
    #[schema(required = false, default = "automatic")]
    method: MethodSchema,
    /// Average over periods where the log repeats.
    #[schema(default = true)]
    average: Option<bool>,
    position_filter: Option<FilterSchema>,
    torque_filter: Option<FilterSchema>,
    discard_edges_s: Option<f64>,
    decimation: Option<u32>,
    /// Speed below which a joint's rows are left out (rad/s or m/s).
    dead_zone: Option<f64>,
}

/// `fourier_fit`: derivatives from the harmonics above the noise. `parallel_filter`: one filter for torque and every regressor column.
/// `paper`: order 20 at 2 Hz for positions, order 12 at 1.6 Hz for torques, central differences.
#[derive(Serialize, ToSchema)]
#[schema(as = PreprocessMethod, rename_all = "snake_case")]
pub enum MethodSchema {
    Automatic,
    FourierFit,
    ParallelFilter,
    Paper,
}

/// Butterworth low-pass, run forwards and backwards.
#[derive(Serialize, ToSchema)]
#[schema(as = Filter)]
#[serde(deny_unknown_fields)]
pub struct FilterSchema {
    order: u32,
    cutoff_hz: f64,
}

/// Physical parameters. `consistent` (or `convex`): least squares with a positive definite pseudo-inertia of every link. `paper`: the
/// nonlinear problem (10a-d) from many starts, and its gap to a lower bound. `both`: the first is the model, the second is told beside it.
#[derive(Serialize, ToSchema)]
#[schema(as = Feasible)]
#[serde(deny_unknown_fields)]
pub struct FeasibleSchema {
    #[schema(required = false, default = "consistent")]
    method: FeasibleMethodSchema,
    /// Weight of the pull towards the robot's prior parameters.
    #[schema(default = 1.0)]
    prior_weight: Option<f64>,
    /// Least eigenvalue of the pseudo-inertia, in units of the prior link's.
    #[schema(default = 1e-4)]
    least_eigenvalue: Option<f64>,
    /// Least viscous friction (N·m·s/rad or N·s/m).
    #[schema(default = 0.0)]
    least_viscous: Option<f64>,
    /// On single links, in the place of the robot's own.
    bounds: Option<Vec<LinkBoundsSchema>>,
    /// Per link, in the place of the robot's own; null for none (`paper`).
    slender_axes: Option<Vec<Option<AxisSchema>>>,
    /// Whether (10d) holds besides (10c) (`paper`).
    #[schema(default = true)]
    gazebo: Option<bool>,
    /// Which triangle inequality of the moments of inertia holds (`paper`).
    #[schema(required = false, default = "principal")]
    triangle: TriangleSchema,
    /// Local solves (`paper`).
    #[schema(default = 8, minimum = 1, maximum = 1000)]
    starts: Option<u32>,
    /// Of the random starts (`paper`).
    #[schema(default = 1)]
    seed: Option<u64>,
}

#[derive(Serialize, ToSchema)]
#[schema(as = FeasibleMethod, rename_all = "snake_case")]
pub enum FeasibleMethodSchema {
    Consistent,
    Convex,
    Paper,
    Both,
    None,
}

#[derive(Serialize, ToSchema)]
#[schema(as = Axis, rename_all = "snake_case")]
pub enum AxisSchema {
    X,
    Y,
    Z,
}

/// `principal`: of the principal moments, as simulators check it. `diagonal`: of the tensor's diagonal, as in the paper. `none`: not asked.
#[derive(Serialize, ToSchema)]
#[schema(as = Triangle, rename_all = "snake_case")]
pub enum TriangleSchema {
    Principal,
    Diagonal,
    None,
}

/// Bounds on one link, `[lower, upper]`, in its frame.
#[derive(Serialize, ToSchema)]
#[schema(as = LinkBounds)]
#[serde(deny_unknown_fields)]
pub struct LinkBoundsSchema {
    /// From 1.
    link: u32,
    /// (kg)
    mass: Option<[f64; 2]>,
    /// x, y, z in the link frame (m).
    center_of_mass: Option<Vec<Vec<f64>>>,
    /// About the centre of mass (`paper` alone).
    inertia: Option<InertiaBoundsSchema>,
    /// N·m·s/rad or N·s/m
    viscous: Option<[f64; 2]>,
    /// N·m or N
    coulomb: Option<[f64; 2]>,
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

/// How a trajectory is handed out.
#[derive(Serialize, ToSchema)]
#[schema(rename_all = "lowercase")]
pub enum TrajectoryFormat {
    Csv,
    Json,
}

/// How an identified model is handed out.
#[derive(Serialize, ToSchema)]
#[schema(rename_all = "lowercase")]
pub enum ModelFormat {
    Json,
    Urdf,
}
