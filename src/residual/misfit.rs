//! Lack of fit and errors of a model, joint by joint.

use super::report::AtRest;
use super::system::{Data, System};
use super::{AugmentedModel, JointFit, RmsPair, Stretch};
use crate::dynamics::Motion;
use crate::identification::f_tail;

/// Lack of fit per joint: F of the whitened residual's mean square against the noise.
pub(super) fn fits(data: &Data, system: &System) -> Vec<JointFit> {
    (0..data.noise.len())
        .map(|j| {
            let noise = &data.noise[j];
            let freedom = (system.rows(j) as f64 - system.spent(j)).max(1.0);
            let statistic = system.joint_chi_square(j) / freedom;
            let p_value = f_tail(statistic, [freedom, noise.degrees_of_freedom.max(1.0)]);
            let (sum, count, repetitions) = raw_residual(data, system, j);
            JointFit {
                joint: system.model.robot.joints()[j].name.clone(),
                statistic,
                p_value,
                degrees_of_freedom: [freedom, noise.degrees_of_freedom],
                residual_rms: (sum / count.max(1.0)).sqrt(),
                expected_rms: if count > 0.0 {
                    noise.std_dev / repetitions.sqrt()
                } else {
                    0.0
                },
            }
        })
        .collect()
}

/// Sum of squares of the mean residual of a joint, rows, and repetitions.
pub(super) fn raw_residual(data: &Data, system: &System, joint: usize) -> (f64, f64, f64) {
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
fn squares(stretch: &Stretch, joint: usize, predicted: &[f64], keep: &[bool]) -> (f64, f64) {
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

/// RMS of single measurements about a model, per joint.
pub(super) fn rms(model: &AugmentedModel, identification: &[Stretch], held_out: &[Stretch]) -> RmsPair {
    RmsPair {
        identification: rms_over(model, identification),
        held_out: rms_over(model, held_out),
    }
}

/// Errors where joints [rest](super::stretch::at_rest), of the model to start from and of the last; `None` where none rests.
pub(super) fn at_rest(
    first: &AugmentedModel,
    last: &AugmentedModel,
    identification: &[Stretch],
    held_out: &[Stretch],
) -> Option<AtRest> {
    let rests = |stretches: &[Stretch]| stretches.iter().any(|s| s.resting.iter().flatten().any(|r| *r));
    let rows = |s: &Stretch, _: &Motion, j: usize| s.resting[j].clone();
    let of = |model: &AugmentedModel| RmsPair {
        identification: rms_of(model, identification, rows),
        held_out: rms_of(model, held_out, rows),
    };
    let seconds = |j: usize| {
        let one = |s: &Stretch| {
            let step = s.interval * s.motion.samples() as f64 / s.rows().max(1) as f64;
            s.resting[j].iter().filter(|r| **r).count() as f64 * step * s.repetitions() as f64
        };
        identification.iter().map(one).sum()
    };
    (rests(identification) || rests(held_out)).then(|| AtRest {
        seconds: (0..first.robot.joint_count()).map(seconds).collect(),
        rms_before: of(first),
        rms_after: of(last),
    })
}

fn rms_over(model: &AugmentedModel, stretches: &[Stretch]) -> Vec<f64> {
    rms_of(model, stretches, |s, motion, j| s.kept(motion, j))
}

/// RMS over the rows of every joint that `rows` picks by stretch, distorted motion and joint; NaN where there are none.
fn rms_of(model: &AugmentedModel, stretches: &[Stretch], rows: impl Fn(&Stretch, &Motion, usize) -> Vec<bool>) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); if stretches.is_empty() { 0 } else { stretches[0].joints() }];
    for stretch in stretches {
        let e = model.evaluate(stretch, None);
        for (j, total) in sums.iter_mut().enumerate() {
            let (sum, count) = squares(stretch, j, &e.torque[j], &rows(stretch, &e.motion, j));
            total.0 += sum;
            total.1 += count;
        }
    }
    // A joint without rows has no error: NaN, which documents have as null.
    sums.into_iter()
        .map(|(sum, count): (f64, f64)| (sum / count).sqrt())
        .collect()
}
