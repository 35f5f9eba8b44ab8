//! The states a robot may be in: what the torque-prediction error is averaged over.

use super::moves::{random_numbers, random_start};
use super::problem::Problem;
use super::variables::Variables;
use crate::dynamics::Motion;
use crate::trajectory::Trajectory;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// Random states averaged over: the mean of their Gram matrices is known to about 1/sqrt(2000) = 2 %, alike for all designs since
/// the states are always the same ones.
const STATES: usize = 2000;

/// Mean of `Y_bᵀ Y_b` over states drawn uniformly inside the limits (all columns).
///
/// Where a limit is not stated: a full turn either way for a position (1 m for a sliding joint), and for velocities and
/// accelerations what the fastest asked harmonic makes of the position and velocity range.
pub(super) fn workspace_gram(problem: &Problem) -> DMatrix<f64> {
    let spec = problem.spec();
    let added = spec.knowledge.added.as_ref();
    if added.is_some_and(|a| (0..a.0.groups()).any(|g| !a.0.is_local(g))) {
        return over_motions(problem);
    }
    let joints = problem.robot().joints();
    let fastest = TAU * spec.fundamental_hz * spec.order as f64;
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let motion = Motion::from_fn(joints.len(), STATES, |j, _| {
        let limits = &joints[j].limits;
        let free = if joints[j].is_revolute() { PI } else { 0.5 };
        let [low, high] = limits.position.unwrap_or([-free, free]);
        let velocity = limits.velocity.unwrap_or(0.5 * (high - low) * fastest);
        let acceleration = limits.acceleration.unwrap_or(velocity * fastest);
        [
            rng.random_range(low..high),
            rng.random_range(-velocity..velocity),
            rng.random_range(-acceleration..acceleration),
        ]
    });
    problem.gram_along(&motion, 1.0, false) / STATES as f64
}

/// Columns that look at other samples have no value at a state. They are averaged over random motions within the limits, as many
/// samples as there are states otherwise.
fn over_motions(problem: &Problem) -> DMatrix<f64> {
    let variables = Variables::new(problem);
    let samples = (20 * problem.spec().order).next_multiple_of(8);
    let rate = samples as f64 * problem.spec().fundamental_hz;
    let motions = STATES.div_ceil(samples);
    let of = |index: usize| {
        let x = random_start(&variables, &mut random_numbers(0, 0, index));
        problem.gram_along(&variables.series(&x).sample(rate), 1.0 / rate, true) / (samples * motions) as f64
    };
    (0..motions)
        .map(of)
        .fold(DMatrix::zeros(problem.columns(), problem.columns()), |a, b| a + b)
}
