//! How well parameters predict a log that they may never have seen: the paper's Table 4.

use super::Observation;
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
    pub predicted: Vec<f64>,
}

/// Errors of `values` (one per model column) over the used rows of every joint. A joint without rows has NaN.
pub fn validate(observation: &Observation, values: &DVector<f64>) -> Validation {
    let (mut rms, mut percent) = (Vec::new(), Vec::new());
    for rows in &observation.joints {
        let used = rows.used_rows() as f64;
        let error = (rows.residual(values).norm_squared() / used).sqrt();
        rms.push(error);
        percent.push(100.0 * error / (rows.torque.norm_squared() / used).sqrt());
    }
    Validation { rms, percent }
}

/// At most `most` evenly spaced points of joint `j`.
pub fn prediction(observation: &Observation, j: usize, values: &DVector<f64>, most: usize) -> PredictionSeries {
    let rows = &observation.joints[j];
    let predicted = rows.predict(values);
    let used: Vec<usize> = (0..rows.used.len()).filter(|&r| rows.used[r]).collect();
    let picked: Vec<usize> = used
        .iter()
        .copied()
        .step_by(used.len().div_ceil(most.max(1)).max(1))
        .collect();
    PredictionSeries {
        samples: picked.iter().map(|&r| observation.samples[r]).collect(),
        measured: picked.iter().map(|&r| rows.torque[r]).collect(),
        predicted: picked.iter().map(|&r| predicted[r]).collect(),
    }
}
