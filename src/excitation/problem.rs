//! What is asked: a robot, a Fourier series, a criterion, constraints.

use super::path::{TorqueLimits, TorqueSet};
use crate::dynamics::{Chain, Coulomb, Motion, inverse_dynamics_batch};
use crate::model::{FieldProblem, ModelError, Robot};
use crate::parameters::{BaseParameters, Layout};
use crate::trajectory::sample_count;

/// What makes one trajectory better than another; all are functions of the Gram matrix `M = Y_bᵀ Y_b` and are minimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// `cond(Y_b) = sqrt(λ_max / λ_min)`, the paper's (13).
    ConditionNumber,
    /// The condition number after scaling every column of Y_b to length one: does not depend on units.
    ScaledConditionNumber,
    /// `det(M)^(−1/(2b))`: the geometric mean of the standard deviations along the principal directions.
    DOptimality,
    /// `sqrt(tr(M⁻¹)/b)`: the root-mean-square standard deviation of the base parameters.
    AOptimality,
    /// `sqrt(tr(M⁻¹ C)/n)`, C the mean of `Y_bᵀ Y_b` over random states inside the limits: the expected torque-prediction error.
    IOptimality,
}

impl Criterion {
    /// Whether it is a ratio of singular values, which has kinks where they meet.
    pub fn is_condition_number(self) -> bool {
        matches!(self, Self::ConditionNumber | Self::ScaledConditionNumber)
    }
}

/// How limits on the series become constraints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// (14d)–(14g): triangle-inequality bounds and boxes on the coefficients. Sufficient, not necessary.
    Paper,
    /// The true extremes over time, certified between the samples.
    Exact,
}

/// Where the motion starts; it starts and ends at rest without acceleration either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// At the start position (14c).
    Zero,
    /// Anywhere: the robot moves there first. The mean position of every joint becomes a variable.
    Free,
}

/// A request as it was made; [`Problem::new`] checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct ProblemSpec {
    pub robot: Robot,
    pub order: usize,
    pub fundamental_hz: f64,
    pub sample_rate_hz: f64,
    pub criterion: Criterion,
    pub form: Form,
    pub start: Start,
    /// Position of every joint at the start [rad or m]; for `None` zero where the limits allow it, else the middle of the range.
    pub start_position: Option<Vec<f64>>,
    /// Standard deviation of the torque noise of every joint [N·m or N], for predicted accuracies and the optimality criteria; for
    /// `None` one unit on every joint.
    pub torque_noise: Option<Vec<f64>>,
    /// Limits on the torques that the robot's prior parameters predict.
    pub torque: Option<TorqueLimits>,
}

/// A checked problem with all that follows from it.
#[derive(Debug, Clone)]
pub struct Problem {
    spec: ProblemSpec,
    start_position: Vec<f64>,
    layout: Layout,
    base: BaseParameters,
    chain: Chain,
    samples: usize,
    torque: Option<TorqueSet>,
}

/// More harmonics than any controller's bandwidth carries; keeps accidental requests from asking for hours.
const HIGHEST_ORDER: usize = 50;
/// Numbers in the observation matrix: beyond this one evaluation takes so long that a search learns nothing and cannot stop within a
/// second. The iiwa 14 has room for 12,500 samples, a period of 10 s at more than 1 kHz.
const LARGEST_MATRIX: usize = 5_000_000;

impl Problem {
    /// # Errors
    /// Every field that is wrong, as pointers into the excitation document, with the remedy.
    pub fn new(spec: ProblemSpec) -> Result<Self, ModelError> {
        let mut found = Vec::new();
        series_problems(&spec, &mut found);
        limit_problems(&spec, &mut found);
        let start_position = start_position(&spec, &mut found);
        noise_problems(&spec, &mut found);
        let layout = Layout::standard(&spec.robot);
        let base = BaseParameters::exact(&spec.robot);
        let torque = TorqueSet::new(&spec, &layout, &base, &mut found);
        if !found.is_empty() {
            return Err(ModelError(found));
        }
        let chain = Chain::new(&spec.robot);
        let samples = sample_count(1.0 / spec.fundamental_hz, spec.sample_rate_hz);
        size_problem(samples, spec.robot.joint_count(), base.len())?;
        Ok(Self {
            spec,
            start_position,
            layout,
            base,
            chain,
            samples,
            torque,
        })
    }

    pub fn robot(&self) -> &Robot {
        &self.spec.robot
    }

    pub fn spec(&self) -> &ProblemSpec {
        &self.spec
    }

    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    pub fn base(&self) -> &BaseParameters {
        &self.base
    }

    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Why no motion at all is possible, if so: a joint that starts on its limit would have to leave it.
    pub fn no_room(&self) -> Option<String> {
        let joints = self.spec.robot.joints().iter().enumerate();
        let mut stuck = joints.filter(|(j, joint)| {
            let rest = self.rest_position(*j);
            joint.limits.position.is_some_and(|[low, high]| rest <= low || rest >= high)
        });
        stuck.next().map(|(_, joint)| {
            format!(
                "joint `{}` starts on its position limit and has nowhere to go: choose another start_position, or start: free",
                joint.name
            )
        })
        .or_else(|| self.too_heavy_at_rest())
    }

    /// The first joint that exceeds its torque limit by holding the arm still, in words.
    fn too_heavy_at_rest(&self) -> Option<String> {
        let limits = self.torque.as_ref()?;
        let joints = self.spec.robot.joint_count();
        let prior = self.layout.prior(&self.spec.robot)?;
        // Just moving, one way and the other: friction is there as soon as anything moves.
        let still = Motion::from_fn(joints, 2, |j, s| [self.rest_position(j), [-1e-9, 1e-9][s], 0.0]);
        let torques = inverse_dynamics_batch(&self.chain, &self.layout, prior.as_slice(), &still, Coulomb::Sign);
        let at = |j: usize| torques[j * still.stride()].abs().max(torques[j * still.stride() + 1].abs());
        let joint = (0..joints).find(|&j| at(j) >= limits.allowed[j])?;
        Some(format!(
            "joint `{}` needs {:.4} to hold the arm where the motion starts and to begin to move, and constraints.torque allows {:.4} N m or N: choose another \
             start_position, a smaller safety_factor or larger limits",
            self.spec.robot.joints()[joint].name,
            at(joint),
            limits.allowed[joint]
        ))
    }

    /// Torque limits with the model that predicts torques.
    pub(super) fn torque(&self) -> Option<&TorqueSet> {
        self.torque.as_ref()
    }

    /// Standard deviation of the torque noise of every joint, as asked or one unit.
    pub fn torque_noise(&self) -> Vec<f64> {
        self.spec
            .torque_noise
            .clone()
            .unwrap_or_else(|| vec![1.0; self.spec.robot.joint_count()])
    }

    /// Samples in one period.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Where the coefficients of `joint` scale from: the start position, or the middle of the range when the start is free.
    pub fn rest_position(&self, joint: usize) -> f64 {
        match (self.spec.start, self.spec.robot.joints()[joint].limits.position) {
            (Start::Free, Some([low, high])) => 0.5 * (low + high),
            _ => self.start_position[joint],
        }
    }

    /// Position at the start [rad or m], one per joint.
    pub fn start_position(&self) -> &[f64] {
        &self.start_position
    }
}

fn positive(pointer: &str, value: f64, unit: &str, found: &mut Vec<FieldProblem>) -> bool {
    let good = value.is_finite() && value > 0.0;
    if !good {
        found.push(FieldProblem::new(
            pointer,
            format!("is {value}; it must be a positive number of {unit}"),
        ));
    }
    good
}

fn series_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
    let fundamental = positive("/fourier/fundamental_hz", spec.fundamental_hz, "Hz", found);
    let rate = positive("/sample_rate_hz", spec.sample_rate_hz, "Hz", found);
    if spec.order < 2 {
        found.push(
            FieldProblem::new(
                "/fourier/order",
                format!("is {}: rest at the start leaves nothing free below order 2", spec.order),
            )
            .with_hint("use 5 as in the paper, at least 2"),
        );
    } else if spec.order > HIGHEST_ORDER {
        found.push(FieldProblem::new(
            "/fourier/order",
            format!("is {}, the highest accepted is {HIGHEST_ORDER}", spec.order),
        ));
    }
    if !(fundamental && rate) {
        return;
    }
    let samples = sample_count(1.0 / spec.fundamental_hz, spec.sample_rate_hz);
    if samples <= 2 * spec.order {
        found.push(
            FieldProblem::new(
                "/fourier/order",
                format!(
                    "{} harmonics need more than {} samples per period, there are {samples}",
                    spec.order,
                    2 * spec.order
                ),
            )
            .with_hint("raise sample_rate_hz, lower the order or the fundamental"),
        );
    }
}

fn size_problem(samples: usize, joints: usize, parameters: usize) -> Result<(), ModelError> {
    let row_size = joints * parameters.max(1);
    if samples.saturating_mul(row_size) <= LARGEST_MATRIX {
        return Ok(());
    }
    let detail = format!(
        "gives {samples} samples per period, the most for this robot is {}",
        LARGEST_MATRIX / row_size
    );
    let hint = "some hundred samples per harmonic are enough: lower the rate, or raise the fundamental";
    Err(ModelError(vec![FieldProblem::new("/sample_rate_hz", detail).with_hint(hint)]))
}

fn limit_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
    for (i, joint) in spec.robot.joints().iter().enumerate() {
        let l = &joint.limits;
        if l.velocity.is_none() && l.acceleration.is_none() && l.jerk.is_none() && l.position.is_none() {
            found.push(
                FieldProblem::new(
                    format!("/robot/joints/{i}/limits"),
                    format!("joint `{}` has no limit on its motion", joint.name),
                )
                .with_hint("give at least its velocity limit: without one the best trajectory is infinitely fast"),
            );
        }
    }
}

fn noise_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
    let Some(noise) = &spec.torque_noise else { return };
    let joints = spec.robot.joint_count();
    if noise.len() != joints {
        found.push(FieldProblem::new(
            "/torque_noise",
            format!("has {} values, the robot has {joints} joints", noise.len()),
        ));
    }
    for (i, &v) in noise.iter().enumerate() {
        positive(&format!("/torque_noise/{i}"), v, "N m or N", found);
    }
}

/// Zero, or the middle of the range where zero leaves less than a tenth of the range on one side.
fn default_start(limits: Option<[f64; 2]>) -> f64 {
    match limits {
        Some([low, high]) if low.max(-high) > -0.1 * (high - low) => 0.5 * (low + high),
        _ => 0.0,
    }
}

fn start_position(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) -> Vec<f64> {
    let joints = spec.robot.joints();
    let Some(given) = &spec.start_position else {
        return joints.iter().map(|j| default_start(j.limits.position)).collect();
    };
    if given.len() != joints.len() {
        let detail = format!("has {} values, the robot has {} joints", given.len(), joints.len());
        found.push(FieldProblem::new("/constraints/start_position", detail));
        return given.clone();
    }
    for (i, (joint, &q)) in joints.iter().zip(given).enumerate() {
        let pointer = format!("/constraints/start_position/{i}");
        if !q.is_finite() {
            found.push(FieldProblem::new(pointer, "is not finite"));
        } else if let Some([low, high]) = joint.limits.position
            && !(low <= q && q <= high)
        {
            let detail = format!(
                "is {q}, not inside the position limits [{low}, {high}] of joint `{}`",
                joint.name
            );
            found.push(FieldProblem::new(pointer, detail));
        }
    }
    given.clone()
}
