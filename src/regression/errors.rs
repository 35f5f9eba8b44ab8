//! Lack of fit and errors of a model, joint by joint.

use super::dataset::Stretch;
use super::model::AugmentedModel;
use super::normal_equations::{Data, System};

/// Sum of squares of the mean residual of a joint, rows, and repetitions.
pub(crate) fn raw_residual(data: &Data, system: &System, joint: usize) -> (f64, f64, f64) {
    let (mut sum, mut count) = (0.0, 0.0);
    for (stretch, (e, blocks)) in data.stretches.iter().zip(system.evaluated.iter().zip(&system.blocks)) {
        let rows = blocks[joint]
            .rows
            .iter()
            .zip(stretch.torque[joint].iter().zip(&e.torque[joint]));
        for (_, (y, f)) in rows.filter(|(keep, _)| **keep) {
            sum += (y - f) * (y - f);
            count += 1.0;
        }
    }
    (sum, count, data.stretches.first().map_or(1, Stretch::repetitions) as f64)
}

/// Errors of a model on one log.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictionErrors {
    /// Per joint: root mean square of measured less predicted torque, of single measurements [N·m or N].
    pub rms: Vec<f64>,
    /// Per joint: the same in percent of the torque's own root mean square.
    pub percent: Vec<f64>,
}

impl AugmentedModel {
    /// How well the model predicts `stretch`, which it may never have seen.
    pub fn errors(&self, stretch: &Stretch) -> PredictionErrors {
        let e = self.evaluate(stretch, None);
        let still = vec![0.0; stretch.rows()];
        let of = |j: usize| {
            let keep = stretch.kept(&e.motion, j);
            let root = |predicted: &[f64]| {
                let (sum, count) = squares(stretch, j, predicted, &keep);
                (sum / count).sqrt()
            };
            (root(&e.torque[j]), root(&still))
        };
        let (rms, own): (Vec<f64>, Vec<f64>) = (0..stretch.joints()).map(of).unzip();
        let percent = rms.iter().zip(own).map(|(r, own)| 100.0 * r / own).collect();
        PredictionErrors { rms, percent }
    }
}

/// Sum of the squares of single measurements about `predicted` over the rows that are kept, and their number.
pub(crate) fn squares(stretch: &Stretch, joint: usize, predicted: &[f64], keep: &[bool]) -> (f64, f64) {
    let mean = std::slice::from_ref(&stretch.torque);
    let records = if stretch.periods.is_empty() {
        mean
    } else {
        &stretch.periods[..]
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for record in records {
        for s in (0..keep.len()).filter(|&s| keep[s]) {
            sum += (record[joint][s] - predicted[s]).powi(2);
            count += 1.0;
        }
    }
    (sum, count)
}
