//! The noise of every joint: from the periods, or from what the model leaves.

use super::ar_noise::NoiseModel;
use super::model::AugmentedModel;
use super::motion_error::motion_error_variance;
use super::normal_equations::Data;
use crate::model::Robot;

/// The noise of every joint: from the periods where there are at least two, with what errors of the positions add; otherwise from
/// what the model leaves.
pub(crate) fn floor(robot: &Robot, data: &Data, model: &AugmentedModel) -> Vec<NoiseModel> {
    let Some(torque_noise) = from_periods(robot, data, &vec![0.0; robot.joint_count()]) else {
        return residual_noise(data, model);
    };
    let system = data.with_noise(torque_noise.clone()).fit(model.clone());
    let hidden = motion_error_variance(&system.model, data.stretches);
    from_periods(robot, data, &hidden).unwrap_or(torque_noise)
}

/// `hidden`: per joint, variance of errors that no period shows.
fn from_periods(robot: &Robot, data: &Data, hidden: &[f64]) -> Option<Vec<NoiseModel>> {
    (0..robot.joint_count())
        .map(|j| NoiseModel::from_periods_and(data.stretches, j, hidden[j]))
        .collect()
}

/// Noise taken from the residual of an ordinary fit, weights refined once by the noise found.
fn residual_noise(data: &Data, model: &AugmentedModel) -> Vec<NoiseModel> {
    let mut noise = vec![NoiseModel::white(1.0); model.robot.joint_count()];
    for _ in 0..2 {
        let weighted = data.with_noise(noise);
        let system = weighted.fit(model.clone());
        noise = weighted.left_as_noise(&system);
    }
    noise
}
