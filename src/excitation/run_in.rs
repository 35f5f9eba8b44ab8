//! From a given pose into the periodic motion, and out of it, within the limits of the design.
//!
//! Both are half a period of a Fourier series of order 3 with the frequency `1/(2T)`. Positions, velocities and accelerations at
//! both ends are met exactly, and where both ends are at rest the jerk is zero too. What proves a design proves them: the margins
//! of the whole period hold for its half.

use super::backoff::holds;
use super::problem::Problem;
use crate::trajectory::{FourierSeries, Trajectory};
use std::f64::consts::PI;

/// Harmonics that three conditions at either end need.
const ORDER: usize = 3;
/// Part of a joint's velocity limit that is used where the duration is not given: a person beside the arm can still stop it.
const GENTLE: f64 = 0.25;
/// The shortest duration that is chosen (s).
const SHORTEST_S: f64 = 1.0;
/// The longest duration that is tried or taken (s): what does not fit into two minutes does not fit.
pub const LONGEST_RUN_IN_S: f64 = 120.0;
/// By how much a duration grows where a limit does not hold.
const GROWN: f64 = 1.25;

/// Where a run begins or ends, and how long it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSpec {
    /// Positions of the joints at rest [rad or m].
    pub pose: Vec<f64>,
    /// (s); the shortest gentle one within all limits where `None`.
    pub duration_s: Option<f64>,
    /// The duration is rounded up to whole samples of this rate (Hz).
    pub rate_hz: f64,
}

/// Why there is no run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoRun {
    /// The pose has another number of joints.
    Joints,
    /// The pose is not within the limits of the joint.
    Pose(usize),
    /// A limit does not hold on the way, in the duration asked for or in any.
    Limits,
}

/// The way from a pose at rest to where `series` begins, as the first half of the period of a series.
///
/// # Errors
/// [`NoRun`].
pub fn run_in(problem: &Problem, series: &FourierSeries, spec: &RunSpec) -> Result<FourierSeries, NoRun> {
    run(problem, series, spec, false)
}

/// The way from where a period of `series` ends to a pose at rest, as the first half of the period of a series.
///
/// # Errors
/// [`NoRun`].
pub fn run_out(problem: &Problem, series: &FourierSeries, spec: &RunSpec) -> Result<FourierSeries, NoRun> {
    run(problem, series, spec, true)
}

fn run(problem: &Problem, series: &FourierSeries, spec: &RunSpec, out: bool) -> Result<FourierSeries, NoRun> {
    let n = problem.robot().joint_count();
    if spec.pose.len() != n {
        return Err(NoRun::Joints);
    }
    let within = |j: usize| {
        problem.robot().joints()[j]
            .limits
            .position
            .is_none_or(|[low, high]| (low..=high).contains(&spec.pose[j]))
    };
    if let Some(joint) = (0..n).find(|&j| !within(j)) {
        return Err(NoRun::Pose(joint));
    }
    let whole = |duration: f64| (duration * spec.rate_hz - 1e-9).ceil().max(1.0) / spec.rate_hz;
    let tried = |duration: f64| {
        let way = way(series, &spec.pose, whole(duration), out);
        holds(problem, &way).then_some(way)
    };
    if let Some(duration) = spec.duration_s {
        return tried(duration).ok_or(NoRun::Limits);
    }
    let mut duration = gentle(problem, series, &spec.pose);
    while duration <= LONGEST_RUN_IN_S {
        if let Some(way) = tried(duration) {
            return Ok(way);
        }
        duration *= GROWN;
    }
    Err(NoRun::Limits)
}

/// Between two states of rest the largest velocity is `0.75 π |Δ| / T`.
fn gentle(problem: &Problem, series: &FourierSeries, pose: &[f64]) -> f64 {
    let joints = problem.robot().joints().iter().enumerate();
    let needed = joints.filter_map(|(j, joint)| {
        let distance = (series.state(j, 0.0)[0] - pose[j]).abs();
        Some(0.75 * PI * distance / (GENTLE * joint.limits.velocity?))
    });
    needed.fold(SHORTEST_S, f64::max)
}

fn way(series: &FourierSeries, pose: &[f64], duration: f64, out: bool) -> FourierSeries {
    let omega = PI / duration;
    let n = pose.len();
    let mut way = FourierSeries::at_rest(vec![0.0; n], ORDER, 0.5 / duration);
    for (j, &rest) in pose.iter().enumerate() {
        let (still, moving) = ([rest, 0.0, 0.0], series.state(j, 0.0));
        let (from, to) = if out { (moving, still) } else { (still, moving) };
        let (offset, cosines, sines) = between(from, to, omega);
        way.offset[j] = offset;
        for l in 1..=ORDER {
            way.a[(j, l - 1)] = sines[l - 1] * omega * l as f64;
            way.b[(j, l - 1)] = -cosines[l - 1] * omega * l as f64;
        }
    }
    way
}

/// `o + Σ c_l cos(l ω t) + s_l sin(l ω t)` from one `[q, qd, qdd]` at t = 0 to another at `t = π/ω`: even harmonics hold the sums
/// of both ends' conditions, odd ones the differences.
fn between(from: [f64; 3], to: [f64; 3], omega: f64) -> (f64, [f64; ORDER], [f64; ORDER]) {
    let [sum, difference] = [1.0, -1.0].map(|sign| [0, 1, 2].map(|k| 0.5 * (from[k] + sign * to[k])));
    let curvature = omega * omega;
    let second = -sum[2] / (4.0 * curvature);
    let third = (-difference[2] / curvature - difference[0]) / 8.0;
    let cosines = [difference[0] - third, second, third];
    let sines = [difference[1] / omega, sum[1] / (2.0 * omega), 0.0];
    (sum[0] - second, cosines, sines)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn prop_both_ends_are_met() {
        let mut series = FourierSeries::at_rest(vec![0.3, -0.2], 2, 0.1);
        series.a = DMatrix::from_row_slice(2, 2, &[0.4, 0.1, -0.3, 0.2]);
        series.b = DMatrix::from_row_slice(2, 2, &[0.2, -0.5, 0.1, 0.6]);
        let (pose, duration) = ([1.0, -0.7], 3.7);
        for out in [false, true] {
            let way = way(&series, &pose, duration, out);
            for j in 0..2 {
                let (still, moving) = ([pose[j], 0.0, 0.0], series.state(j, 0.0));
                let ends = if out { [moving, still] } else { [still, moving] };
                for (t, expected) in [0.0, duration].into_iter().zip(ends) {
                    let found = way.state(j, t);
                    // Sums of a few terms of order one.
                    (0..3).for_each(|k| assert!((found[k] - expected[k]).abs() < 1e-13, "{found:?} {expected:?}"));
                }
            }
        }
    }

    /// Rest to rest without jerk at the ends, and with the largest velocity that the gentle duration counts on.
    #[test]
    fn prop_rest_to_rest_has_no_jerk_at_its_ends() {
        let series = FourierSeries::at_rest(vec![0.8], 2, 0.1);
        let way = way(&series, &[-0.4], 2.0, false);
        let jerk = |t: f64| (way.state(0, t + 1e-6)[2] - way.state(0, t - 1e-6)[2]) / 2e-6;
        // Differences of accelerations of order 1, rounded, over 2e-6.
        assert!(
            jerk(0.0).abs() < 1e-8 / 2e-6 && jerk(0.0).abs() < 1e-3 * jerk(0.4).abs(),
            "{}",
            jerk(0.0)
        );
        assert!((way.state(0, 1.0)[1] - 0.75 * PI * 1.2 / 2.0).abs() < 1e-12);
    }
}
