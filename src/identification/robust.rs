//! Huber's weights: rows far off count by their distance, not by its square.

use super::Observation;
use super::normal::{JointNormal, summed};
use super::preprocess::spectrum::median;
use nalgebra::DVector;

/// Residual, in standard deviations, from which on a row's weight falls (Huber 1964: 95 % efficiency on normal noise).
const KNEE: f64 = 1.345;

/// Normal equations with every row weighted by `min(1, 1.345 σⱼ/|e|)`.
pub(super) fn robust_normals(observations: &[Observation], values: &DVector<f64>, sigma: &[f64]) -> Vec<JointNormal> {
    summed(observations, |number, j, normal, matrix, mut torque| {
        let errors = &torque - matrix * observations[number].joints[j].own(values);
        let mut matrix = matrix.clone();
        for (r, e) in errors.iter().enumerate() {
            let weight = (KNEE * sigma[j] / e.abs()).min(1.0).sqrt();
            if weight < 1.0 {
                torque[r] *= weight;
                matrix.row_mut(r).scale_mut(weight);
            }
        }
        normal.add(&matrix, &torque);
    })
}

/// Of normal numbers the median distance from zero is 0.6745 standard deviations.
const NORMAL_MEDIAN: f64 = 0.674_489_750_196_081_7;

/// σ of joint `j` from the median of |e|, which half of the rows may be wrong without moving far. `residuals` has the joints of every
/// observation; `freedom` is the share of the rows that parameters have not been spent on.
pub(super) fn median_sigma(observations: &[Observation], residuals: &[Vec<DVector<f64>>], j: usize, freedom: f64) -> f64 {
    let used = observations.iter().zip(residuals).flat_map(|(o, residual)| {
        let rows = residual[j].iter().zip(&o.joints[j].used);
        rows.filter(|(_, used)| **used).map(|(e, _)| e.abs())
    });
    let errors: Vec<f64> = used.collect();
    if errors.is_empty() {
        return 0.0;
    }
    median(errors) / (NORMAL_MEDIAN * freedom.sqrt())
}
