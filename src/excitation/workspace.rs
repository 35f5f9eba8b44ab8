//! The states a robot may be in: what the torque-prediction error is averaged over.

use super::problem::Problem;
use crate::dynamics::{ColumnSet, Coulomb, Motion, RowBlocks};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// Random states averaged over: the mean of their Gram matrices is known to about 1/sqrt(2000) = 2 %, alike for all designs since the
/// states are always the same ones.
const STATES: usize = 2000;

/// Mean of `Y_bᵀ Y_b` over states drawn uniformly inside the limits (b × b).
///
/// Where a limit is not stated: a full turn either way for a position (1 m for a sliding joint), and for velocities and
/// accelerations what the fastest asked harmonic makes of the position and velocity range.
pub(super) fn workspace_gram(problem: &Problem) -> DMatrix<f64> {
    let spec = problem.spec();
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
    let columns = ColumnSet::new(problem.robot(), problem.layout(), &problem.base().kept);
    let mut rows = RowBlocks::new(&columns, STATES);
    rows.fill(problem.chain(), &columns, &motion, Coulomb::Sign);
    let y = rows.observation_matrix(&columns);
    y.tr_mul(&y) / STATES as f64
}
