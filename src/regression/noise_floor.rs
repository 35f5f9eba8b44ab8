//! The noise of every joint: from the periods, or from what the model leaves.

use super::ar_noise::NoiseModel;
use super::model::AugmentedModel;
use super::normal_equations::Data;
use crate::model::Robot;

/// The noise of every joint: from the periods where there are at least two, otherwise from what the model leaves.
pub(crate) fn floor(robot: &Robot, data: &Data, model: &AugmentedModel) -> Vec<NoiseModel> {
    let from_periods: Option<Vec<NoiseModel>> = (0..robot.joint_count())
        .map(|j| NoiseModel::from_periods(data.stretches, j))
        .collect();
    from_periods.unwrap_or_else(|| residual_noise(data, model))
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
