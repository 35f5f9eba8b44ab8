//! How well parameters predict a log that they may never have seen: the paper's Table 4.

use super::{JointRows, Observation, keep_peaks};
use nalgebra::DVector;

/// Prediction errors of one parameter set on one log.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Per joint: root mean square of measured less predicted torque [N m or N].
    pub rms: Vec<f64>,
    /// Per joint: the same in percent of the torque's own root mean square.
    pub percent: Vec<f64>,
}

/// Measured and predicted torque of one joint, for plots.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictionSeries {
    /// Sample of the prepared log that every point stands for.
    pub samples: Vec<usize>,
    pub measured: Vec<f64>,
    /// One series per parameter set.
    pub predicted: Vec<Vec<f64>>,
    /// Row of the observation that every point is.
    pub rows: Vec<usize>,
}

/// Errors of `values` (one per model column) over the used rows of every joint. A joint without rows has NaN.
pub fn validate(observation: &Observation, values: &DVector<f64>) -> Validation {
    let (mut rms, mut percent) = (Vec::new(), Vec::new());
    for (rows, residual) in observation.joints.iter().zip(observation.residuals(values)) {
        let used = rows.used_rows() as f64;
        let error = (residual.norm_squared() / used).sqrt();
        rms.push(error);
        percent.push(100.0 * error / (rows.torque.norm_squared() / used).sqrt());
    }
    Validation { rms, percent }
}

/// About `most` points of every joint for each of several parameter sets, at the same samples; peaks of torque and residual are kept.
pub fn predictions(observation: &Observation, sets: &[&DVector<f64>], most: usize) -> Vec<PredictionSeries> {
    let predicted = observation.predict(sets);
    let series = |(rows, predicted): (&JointRows, &Vec<DVector<f64>>)| {
        let used: Vec<usize> = (0..rows.used.len()).filter(|&r| rows.used[r]).collect();
        let measured: Vec<f64> = used.iter().map(|&r| rows.torque[r]).collect();
        let residual: Vec<f64> = used
            .iter()
            .map(|&r| rows.torque[r] - predicted.first().map_or(0.0, |p| p[r]))
            .collect();
        let picked: Vec<usize> = keep_peaks(&[&measured, &residual], most)
            .into_iter()
            .map(|i| used[i])
            .collect();
        PredictionSeries {
            samples: picked.iter().map(|&r| observation.samples[r]).collect(),
            measured: picked.iter().map(|&r| rows.torque[r]).collect(),
            predicted: predicted.iter().map(|p| picked.iter().map(|&r| p[r]).collect()).collect(),
            rows: picked,
        }
    };
    observation.joints.iter().zip(&predicted).map(series).collect()
}
