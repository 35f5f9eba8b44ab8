//! Lack of fit of a model against the noise, and its errors, joint by joint.

use super::result::{AtRest, JointFit, RmsPair};
use crate::dynamics::Motion;
use crate::regression::{AugmentedModel, Data, Stretch, System, f_tail, raw_residual, squares};

/// Lack of fit per joint: F of the whitened residual's mean square against the noise.
pub(crate) fn fits(data: &Data, system: &System) -> Vec<JointFit> {
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

/// RMS of single measurements about a model, per joint.
pub(crate) fn rms(model: &AugmentedModel, identification: &[Stretch], held_out: &[Stretch]) -> RmsPair {
    RmsPair {
        identification: rms_over(model, identification),
        held_out: rms_over(model, held_out),
    }
}

/// Errors where joints [rest](super::stretch::at_rest), of the model to start from and of the last; `None` where none rests.
pub(crate) fn at_rest(
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
            let step = s.row_interval();
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
