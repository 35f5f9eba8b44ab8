//! Base parameters from random states: the check on the closed form, and the way for anything the closed form does not know.

use super::{Chain, ColumnSet, Coulomb, Motion, RowBlocks};
use crate::model::Robot;
use crate::parameters::{Layout, NumericBase, numeric_base};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Base parameters by rank-revealing elimination of Y at random states drawn from `seed`.
///
/// Twice as many rows as parameters in every joint's block, states of order one in all of q, qd and qdd, so that gravity,
/// velocity and acceleration terms weigh alike. On random arms the columns that stay have more than 1e-4 of their own, those that
/// go less than 1e-12; the tolerance 1e-8 stands between.
pub fn numeric_base_parameters(robot: &Robot, seed: u64) -> NumericBase {
    let layout = Layout::standard(robot);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |half: f64| rng.random_range(-half..half);
    let samples = 2 * layout.len();
    let motion = Motion::from_fn(robot.joint_count(), samples, |_, _| {
        [draw(std::f64::consts::PI), draw(2.0), draw(5.0)]
    });
    let columns = ColumnSet::all(robot, &layout);
    let mut rows = RowBlocks::new(&columns, samples);
    rows.fill(&Chain::new(robot), &columns, &motion, Coulomb::Sign);
    numeric_base(&layout, &rows.observation_matrix(&columns), 1e-8)
}
