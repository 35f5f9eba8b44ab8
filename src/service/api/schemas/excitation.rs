//! A request for an excitation trajectory, with what it has to keep to.

use super::knowledge::{DesignModelSchema, GivenSchema, RivalsSchema};
use super::robot::RobotOrName;
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
    /// Standard deviation of the torque noise of every joint [N·m or N], for predicted accuracies and detectable sizes; that of the data of
    /// `model`, or 1 (for detectable sizes a thousandth of the effort limits), if left out.
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

/// How a trajectory is handed out.
#[derive(Serialize, ToSchema)]
#[schema(as = TrajectoryFormat, rename_all = "snake_case")]
pub enum TrajectoryFormatSchema {
    Csv,
    Json,
    JointTrajectory,
    Yaml,
    Urscript,
    Mcap,
    Npz,
}
