//! What can be wrong with a request, field by field.

use super::{Criterion, Given, ProblemSpec};
use crate::model::{FieldProblem, INPUT_LIMITS, ModelError, counted, shortest};
use crate::trajectory::{Trajectory, sample_count};

/// Numbers that one evaluation goes through: beyond this it takes so long that a search learns nothing and cannot stop within a
/// second. The iiwa 14 has room for 10,300 samples, a period of 10 s at 1 kHz.
const LARGEST_EVALUATION: usize = 9_000_000;

/// Of one sample: the rows of all joints and their weights, motion and its gradient, and the series with its derivatives.
fn numbers_per_sample(joints: usize, parameters: usize, order: usize) -> usize {
    2 * joints * parameters.max(1) + 6 * joints + 3 * (2 * order + 1)
}

fn positive(pointer: &str, value: f64, unit: &str, found: &mut Vec<FieldProblem>) -> bool {
    let good = value.is_finite() && value > 0.0;
    if !good {
        found.push(FieldProblem::new(
            pointer,
            format!("is {}; it must be a positive number of {unit}", shortest(value)),
        ));
    }
    good
}

pub(super) fn series_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
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
    } else if spec.order > INPUT_LIMITS.harmonics {
        found.push(FieldProblem::new(
            "/fourier/order",
            format!("is {}, the highest accepted is {}", spec.order, INPUT_LIMITS.harmonics),
        ));
    }
    if !(fundamental && rate) {
        return;
    }
    let [low, high] = INPUT_LIMITS.fundamental_hz;
    if !(low..=high).contains(&spec.fundamental_hz) {
        let detail = format!("is {:e}; a fundamental is from {low:e} to {high:e} Hz", spec.fundamental_hz);
        found.push(FieldProblem::new("/fourier/fundamental_hz", detail));
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

pub(super) fn harmonic_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
    let Some(lists) = &spec.harmonics else { return };
    let joints = spec.robot.joint_count();
    if lists.len() != joints {
        let detail = format!("has {} lists, the robot has {joints} joints", lists.len());
        found.push(FieldProblem::new("/fourier/harmonics", detail));
    }
    for (i, list) in lists.iter().enumerate() {
        let ascending = list.windows(2).all(|w| w[0] < w[1]);
        let inside = list.iter().all(|l| (1..=spec.order).contains(l));
        if list.len() < 2 || !ascending || !inside {
            let shown: Vec<_> = list.iter().take(INPUT_LIMITS.harmonics).collect();
            let detail = format!(
                "is {shown:?}; a joint has at least two harmonics between 1 and the order, {}, ascending",
                spec.order
            );
            let hint = "rest at the start binds two of them together: with one harmonic nothing would move";
            found.push(FieldProblem::new(format!("/fourier/harmonics/{i}"), detail).with_hint(hint));
        }
    }
}

/// What is known already has to fit the columns; whoever hands it in made it for them.
pub(super) fn knowledge_problems(spec: &ProblemSpec, columns: usize) -> Result<(), ModelError> {
    let knowledge = &spec.knowledge;
    let joints = spec.robot.joint_count();
    let mut found = Vec::new();
    for (i, given) in knowledge.given.iter().enumerate() {
        if let Given::Motion { series, .. } = given {
            let samples = sample_count(series.duration(), spec.sample_rate_hz);
            if let Err(e) = size_problem(samples, joints, columns, series.order()) {
                let placed = |p: FieldProblem| FieldProblem::new(format!("/given/{i}/fundamental_hz"), p.detail);
                found.extend(e.0.into_iter().map(placed));
            }
        }
        let fits = match given {
            Given::Motion { series, .. } => series.offset.len() == joints,
            Given::Information(matrix) => matrix.shape() == (columns, columns),
        };
        if !fits {
            let detail = "is of another robot or model: its joints or parameters are not those of this problem";
            found.push(FieldProblem::new(format!("/given/{i}"), detail));
        }
    }
    if spec.criterion == Criterion::RivalEvidence && knowledge.rivals.is_none() {
        let detail = "is missing: rival_evidence needs the two effects to tell apart";
        let hint = "give `model`, and in `rivals` a finding of it and one of the finding's rivals";
        found.push(FieldProblem::new("/rivals", detail).with_hint(hint));
    }
    if !(knowledge.periods.is_finite() && knowledge.periods >= 1.0) {
        found.push(FieldProblem::new(
            "/periods",
            format!("is {}; at least one period is recorded", knowledge.periods),
        ));
    }
    if found.is_empty() { Ok(()) } else { Err(ModelError(found)) }
}

pub(super) fn size_problem(samples: usize, joints: usize, parameters: usize, order: usize) -> Result<(), ModelError> {
    let most = LARGEST_EVALUATION / numbers_per_sample(joints, parameters, order);
    if samples <= most {
        return Ok(());
    }
    let detail = format!("gives {samples} samples per period, the most for this robot and order is {most}");
    let hint = "some hundred samples per harmonic are enough: lower the rate, or raise the fundamental";
    Err(ModelError(vec![FieldProblem::new("/sample_rate_hz", detail).with_hint(hint)]))
}

pub(super) fn limit_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
    for (i, joint) in spec.robot.joints().iter().enumerate() {
        let l = &joint.limits;
        if l.velocity.is_none() && l.acceleration.is_none() && l.jerk.is_none() {
            let detail = format!("joint `{}` has no limit on its velocity, acceleration or jerk", joint.name);
            let hint = "give at least its velocity limit: without one the best trajectory is as fast as its range allows";
            found.push(FieldProblem::new(format!("/robot/joints/{i}/limits"), detail).with_hint(hint));
        }
    }
}

pub(super) fn noise_problems(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) {
    let Some(noise) = &spec.torque_noise else { return };
    let joints = spec.robot.joint_count();
    if noise.len() != joints {
        found.push(FieldProblem::new(
            "/torque_noise",
            format!(
                "has {}, the robot has {}",
                counted(noise.len(), "value"),
                counted(joints, "joint")
            ),
        ));
    }
    let [low, high] = INPUT_LIMITS.torque_noise;
    for (i, &v) in noise.iter().enumerate().take(joints) {
        let pointer = format!("/torque_noise/{i}");
        if positive(&pointer, v, "N m or N", found) && !(low..=high).contains(&v) {
            let detail = format!("is {v:e}; the noise of a measured torque is from {low:e} to {high:e} N m or N");
            let hint = "one standard deviation of what is measured while the arm moves";
            found.push(FieldProblem::new(pointer, detail).with_hint(hint));
        }
    }
}

/// Zero, or the middle of the range where zero leaves less than a tenth of the range on one side.
fn default_start(limits: Option<[f64; 2]>) -> f64 {
    match limits {
        Some([low, high]) if low.max(-high) > -0.1 * (high - low) => 0.5 * (low + high),
        _ => 0.0,
    }
}

pub(super) fn start_position(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) -> Vec<f64> {
    let joints = spec.robot.joints();
    let Some(given) = &spec.start_position else {
        return joints.iter().map(|j| default_start(j.limits.position)).collect();
    };
    if given.len() != joints.len() {
        let detail = format!(
            "has {}, the robot has {}",
            counted(given.len(), "value"),
            counted(joints.len(), "joint")
        );
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
