//! Robust estimates: rows with gross errors count for less (Huber 1964).

use super::ar_noise::NoiseModel;
use super::model::AugmentedModel;
use super::normal_equations::{Block, Data, RowWeights, System};
use crate::regression::settings::SETTINGS;

/// Median of the absolute value of a standard normal variable.
const NORMAL_MEDIAN: f64 = 0.674_489_750_196_081_7;

/// Data with Huber's weights, and `model` fitted to them: iteratively reweighted least squares, the scale of every joint from its
/// median residual.
pub(crate) fn robust_system<'a>(data: &Data<'a>, model: &AugmentedModel) -> (Data<'a>, System) {
    let mut scale = vec![1.0; data.noise.len()];
    let mut weighted = data.with_noise(white(&scale));
    let mut system = weighted.fit(model.clone());
    for _ in 0..SETTINGS.huber_rounds {
        let freedom: Vec<f64> = (0..scale.len()).map(|j| freedom(&system, j)).collect();
        let plain = data.with_noise(white(&scale)).linearise(system.model.clone());
        let next: Vec<f64> = (0..scale.len())
            .map(|j| scale[j] * median_residual(&plain, j) / freedom[j].sqrt())
            .map(|s| s.max(f64::MIN_POSITIVE.sqrt()))
            .collect();
        let change = next.iter().zip(&scale).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        let relative: Vec<f64> = next.iter().zip(&scale).map(|(n, s)| n / s).collect();
        scale = next;
        weighted = data.with_noise(white(&scale)).with_row_weights(weights(&plain, &relative));
        system = weighted.fit(system.model);
        if change < SETTINGS.huber_settled {
            break;
        }
    }
    (weighted, system)
}

fn white(scale: &[f64]) -> Vec<NoiseModel> {
    scale.iter().map(|&s| NoiseModel::white(s)).collect()
}

/// Share of the rows of a joint that its parameters have not been spent on; of a joint whose parameters use up its rows a tenth.
fn freedom(system: &System, joint: usize) -> f64 {
    (1.0 - system.spent(joint) / system.rows(joint).max(1) as f64).max(0.1)
}

/// Square roots of Huber's weights `min(1, 1.345 σ/|e|)`, σ per joint in units of what the rows are whitened by.
fn weights(system: &System, sigma: &[f64]) -> RowWeights {
    let root = |e: f64, sigma: f64| (SETTINGS.huber_knee * sigma / e.abs().max(f64::MIN_POSITIVE)).min(1.0).sqrt();
    let joint = |(block, &sigma): (&Block, &f64)| block.residual.iter().map(|&e| root(e, sigma)).collect();
    system
        .blocks
        .iter()
        .map(|joints| joints.iter().zip(sigma).map(joint).collect())
        .collect()
}

/// Standard deviation of the whitened residuals of one joint by their median size, which half of the rows may be wrong without
/// moving far.
fn median_residual(system: &System, joint: usize) -> f64 {
    let own = system.blocks.iter().map(|b| &b[joint]);
    let used = own.flat_map(|b| b.residual.iter().zip(&b.rows).filter(|(_, used)| **used));
    let mut sizes: Vec<f64> = used.map(|(e, _)| e.abs()).collect();
    if sizes.is_empty() {
        return 1.0;
    }
    let middle = sizes.len() / 2;
    let (_, &mut median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    median / NORMAL_MEDIAN
}
