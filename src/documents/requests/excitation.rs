//! A request for an excitation trajectory, with what it has to keep to.

use super::knowledge::{DesignModel, Given, Rivals};
use super::own_effect::OwnEffectOrName;
use super::robot::RobotOrName;
use serde::{Deserialize, Serialize};

/// A request for an excitation trajectory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(example = json!({
    "robot": "iiwa14",
    "fourier": {"order": 5, "fundamental_hz": 0.1},
    "sample_rate_hz": 100,
    "criterion": "condition_number",
    "constraints": {"form": "paper", "start": "zero"},
    "search": {"seed": 1, "starts": 64, "time_limit_s": 10}
})))]
#[serde(deny_unknown_fields)]
pub struct ExcitationRequest {
    /// That of `model` if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = RobotOrName, required = false))]
    pub robot: Option<RobotOrName>,
    /// The Fourier series: harmonics, fundamental frequency and sample rate.
    pub fourier: Fourier,
    /// Samples per second of the observation matrix.
    #[cfg_attr(feature = "service", schema(exclusive_minimum = 0))]
    pub sample_rate_hz: f64,
    /// Optimality criterion that the search minimises.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Criterion, required = false, default = "condition_number"))]
    pub criterion: Option<Criterion>,
    /// Limits beside those of the joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Constraints, required = false))]
    pub constraints: Option<Constraints>,
    /// Standard deviation of the torque noise of every joint [N·m or N], for predicted accuracies and detectable sizes; that of
    /// the data of `model`, or 1 (for detectable sizes a thousandth of the effort limits), if left out.
    pub torque_noise: Option<Vec<f64>>,
    /// Budget, starts and seed of the search.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Search, required = false))]
    pub search: Option<Search>,
    /// Model to design for: the columns of its effects join Y_b in every criterion.
    pub model: Option<DesignModel>,
    /// Effects with formulas of their own, beside those of the robot: candidates are among `detectable`, declared ones are
    /// assumed in the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effects: Option<Vec<OwnEffectOrName>>,
    /// Two explanations of one residual, for `rival_evidence`.
    pub rivals: Option<Rivals>,
    /// What is known already: its information is added to that of the new trajectory in every criterion. Up to 100: an
    /// identification holds what all of its logs say.
    #[cfg_attr(feature = "service", schema(max_items = 100))]
    pub given: Option<Vec<Given>>,
    /// Periods of the new trajectory that will be recorded.
    #[cfg_attr(feature = "service", schema(default = 1, minimum = 1))]
    pub periods: Option<u32>,
    /// Trajectories that complement each other, up to 10: each is designed with those before it as given.
    #[cfg_attr(feature = "service", schema(default = 1, minimum = 1, maximum = 10))]
    pub trajectories: Option<u32>,
    /// Factor on the amplitudes, for a first run in the answer.
    #[cfg_attr(feature = "service", schema(exclusive_minimum = 0, maximum = 1))]
    pub backoff: Option<f64>,
    /// An earlier trajectory to go on from, as a design hands it out; of whatever problem for a robot with as many joints.
    pub warm_start: Option<WarmStart>,
}

/// An earlier trajectory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct WarmStart {
    /// Coefficients of a known trajectory of the same order.
    pub coefficients: crate::documents::Coefficients,
    /// Position of every joint around which it moves [rad or m].
    pub offset: Vec<f64>,
    /// Fundamental frequency of that trajectory (Hz).
    pub fundamental_hz: f64,
}

/// The finite Fourier series of every joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Fourier {
    /// Harmonics L, 2 to 50.
    pub order: u32,
    /// Fundamental frequency; the period is its inverse. Of a list the best is found, for recordings of equal length.
    pub fundamental_hz: OneOrSeveral,
    /// Harmonics of every joint, at least two each; all up to the order if left out.
    pub harmonics: Option<Vec<Vec<u32>>>,
}

/// One value for all joints, or one for each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum OneOrSeveral {
    /// The value for every joint.
    One(f64),
    /// One value per joint, in the order of the joints.
    Several(Vec<f64>),
}

/// What is minimised.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// `σ_max/σ_min` of the stacked base regressor.
    ConditionNumber,
    /// The condition number after every column is scaled to length one; independent of units.
    ScaledConditionNumber,
    /// Geometric mean of the standard deviations along the principal directions, `det(M)^(−1/(2b))`.
    DOptimality,
    /// Root mean square standard deviation of the base parameters, `sqrt(tr(M⁻¹)/b)`.
    AOptimality,
    /// Expected error of predicted torques over random states within the limits.
    IOptimality,
    /// Greatest expected BIC difference between two rivals; needs `model` and `rivals`.
    RivalEvidence,
    /// What is recommended: `i_optimality`.
    Recommended,
}

/// Limits of a design beside those that the robot describes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Constraints {
    /// `paper`: triangle-inequality bounds on the coefficients, (14d) to (14g). `exact`: the true extremes over time.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Form, required = false, default = "paper"))]
    pub form: Option<Form>,
    /// `zero`: the motion starts and ends at rest in the start position. `free`: at rest anywhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Start, required = false, default = "zero"))]
    pub start: Option<Start>,
    /// Position of every joint at the start [rad or m]; zero, or the middle of the range, if left out.
    pub start_position: Option<Vec<f64>>,
    /// Limits on torques, predicted by the robot's prior link parameters; none if left out.
    pub torque: Option<TorqueLimits>,
    /// Obstacles and self-collision to avoid; needs `geometry` of the joints. None if left out.
    pub space: Option<SpaceLimits>,
}

/// Obstacles and self-collision to avoid, in the base frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct SpaceLimits {
    /// Least distance kept from everything (m).
    #[cfg_attr(feature = "service", schema(default = 0.02))]
    pub clearance: Option<f64>,
    /// Floors, walls: the arm stays where `normal · p >= offset`.
    pub half_spaces: Option<Vec<HalfSpace>>,
    /// Boxes that the arm stays out of, with edges along the axes of the base frame.
    pub boxes: Option<Vec<BoxObstacle>>,
    /// Avoid self-collision, except between neighbours and the pairs named.
    pub self_collision: Option<SelfCollision>,
}

/// The arm stays where `normal · x ≥ offset`, x in the base frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct HalfSpace {
    /// Name in messages and in the clearances of the answer.
    #[cfg_attr(feature = "service", schema(example = "floor"))]
    pub name: String,
    /// Normal of the plane, pointing to where the arm may be; of any length but zero.
    pub normal: [f64; 3],
    /// (m)
    pub offset: f64,
}

/// A box with edges along the axes of the base frame, which the arm avoids.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = Box))]
pub struct BoxObstacle {
    /// Name in messages and in the clearances of the answer.
    #[cfg_attr(feature = "service", schema(example = "table"))]
    pub name: String,
    /// (m)
    pub center: [f64; 3],
    /// Lengths of the edges (m).
    pub size: [f64; 3],
}

/// Minimum distance between links that are not neighbours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct SelfCollision {
    /// Pairs of joint names whose links may touch.
    pub ignore: Option<Vec<[String; 2]>>,
}

/// Torque limits along the trajectory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct TorqueLimits {
    /// Largest torque of every joint [N·m or N]; the robot's `effort` limits if left out.
    pub limits: Option<Vec<f64>>,
    /// Predicted torques stay below the limit over this factor.
    #[cfg_attr(feature = "service", schema(default = 1.25, minimum = 1.0))]
    pub safety_factor: Option<f64>,
}

/// How limits on the series become constraints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// Bounds (14d)–(14g) of the paper on the coefficients: sufficient, not necessary.
    Paper,
    /// The true extremes over time, certified between the samples.
    Exact,
}

/// Where the motion starts; it starts and ends at rest in either case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// At `start_position`, or at zero if there is none.
    Zero,
    /// At a position that the search chooses; the robot moves there first.
    Free,
}

/// How long and how widely to search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// The same seed and number of evaluations give the same answer.
    #[cfg_attr(feature = "service", schema(default = 1))]
    pub seed: Option<u64>,
    /// Random starts made at least before a search without limits may end.
    #[cfg_attr(feature = "service", schema(default = 64))]
    pub starts: Option<u32>,
    /// Time after which the best trajectory found is handed back (s), up to a day. All of it is used. If it is left out, the
    /// search ends when it has converged, after 60 s at the latest.
    pub time_limit_s: Option<f64>,
    /// Evaluations of the criterion after which no new round begins.
    pub max_evaluations: Option<u64>,
    /// Local solves per round, so many at most run at the same time: raise it on a machine with more than sixteen cores. Part of
    /// what makes a run repeatable.
    #[cfg_attr(feature = "service", schema(default = 16))]
    pub jobs_per_round: Option<u32>,
}

/// How a trajectory is handed out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum TrajectoryFormat {
    /// Comma-separated values, a header and one row per sample.
    Csv,
    /// JSON object with `columns` and `rows`.
    Json,
    /// `trajectory_msgs/msg/JointTrajectory` of ROS 2 as JSON.
    JointTrajectory,
    /// Goal of `control_msgs/action/FollowJointTrajectory` as YAML.
    Yaml,
    /// Program of `servoj` for controllers of Universal Robots.
    Urscript,
    /// MCAP with `sensor_msgs/msg/JointState` messages.
    Mcap,
    /// NumPy archive with the arrays `time`, `q`, `qd` and `qdd`.
    Npz,
}
