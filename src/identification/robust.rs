//! Huber's weights: rows far off count by their distance, not by its square.

use super::normal::JointNormal;
use super::preprocess::spectrum::median;
use super::{JointRows, Observation};
use nalgebra::DVector;

/// Residual, in standard deviations, from which on a row's weight falls (Huber 1964: 95 % efficiency on normal noise).
const KNEE: f64 = 1.345;

/// Normal equations with every row weighted by `min(1, 1.345 σⱼ/|e|)`. One joint's rows are copied at a time.
pub(super) fn robust_normals(observations: &[Observation], values: &DVector<f64>, sigma: &[f64]) -> Vec<JointNormal> {
    let weighted = |rows: &JointRows, s: f64| {
        let mut rows = rows.clone();
        for (r, e) in rows.residual(values).iter().enumerate() {
            let weight = (KNEE * s / e.abs()).min(1.0).sqrt();
            if weight < 1.0 {
                rows.torque[r] *= weight;
                rows.matrix.row_mut(r).scale_mut(weight);
            }
        }
        JointNormal::of(&rows)
    };
    let joint = |(j, &s): (usize, &f64)| JointNormal::sum(observations.iter().map(|o| weighted(&o.joints[j], s)));
    sigma.iter().enumerate().map(joint).collect()
}

/// Of normal numbers the median distance from zero is 0.6745 standard deviations.
const NORMAL_MEDIAN: f64 = 0.674_489_750_196_081_7;

/// σ of joint `j` from the median of |e|, which half of the rows may be wrong without moving far. `freedom` is the share of the rows
/// that parameters have not been spent on.
pub(super) fn median_sigma(observations: &[Observation], j: usize, values: &DVector<f64>, freedom: f64) -> f64 {
    let mut errors = Vec::new();
    for rows in observations.iter().map(|o| &o.joints[j]) {
        let residual = rows.residual(values);
        errors.extend(
            residual
                .iter()
                .zip(&rows.used)
                .filter(|(_, used)| **used)
                .map(|(e, _)| e.abs()),
        );
    }
    if errors.is_empty() {
        return 0.0;
    }
    median(errors) / (NORMAL_MEDIAN * freedom.sqrt())
}
