//! Lack of fit and errors of a model, joint by joint.

use super::report::AtRest;
use super::system::{Data, System};
use super::{AugmentedModel, JointFit, RmsPair, Stretch};
use crate::dynamics::Motion;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Lack of fit per joint: F of the whitened residual's mean square against the noise.
pub(super) fn fits(data: &Data, system: &System) -> Vec<JointFit> {
    (0..data.noise.len())
        .map(|j| {
            let noise = &data.noise[j];
            let freedom = (system.rows(j) as f64 - system.spent(j)).max(1.0);
            let statistic = system.joint_chi_square(j) / freedom;
            let p_value = FisherSnedecor::new(freedom, noise.degrees_of_freedom.max(1.0)).map_or(f64::NAN, |f| f.sf(statistic));
            let (sum, count, repetitions) = raw_residual(data, system, j);
            JointFit {
                joint: system.model.robot.joints()[j].name.clone(),
                statistic,
                p_value,
                degrees_of_freedom: [freedom, noise.degrees_of_freedom],
                residual_rms: (sum / count.max(1.0)).sqrt(),
                expected_rms: noise.std_dev / repetitions.sqrt(),
            }
        })
        .collect()
}

/// Sum of squares of the mean residual of a joint, rows, and repetitions.
fn raw_residual(data: &Data, system: &System, joint: usize) -> (f64, f64, f64) {
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

/// RMS over the rows of every joint that `rows` picks by stretch, distorted motion and joint; zero where there are none.
fn rms_of(model: &AugmentedModel, stretches: &[Stretch], rows: impl Fn(&Stretch, &Motion, usize) -> Vec<bool>) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); if stretches.is_empty() { 0 } else { stretches[0].joints() }];
    for stretch in stretches {
        let e = model.evaluate(stretch, None);
        for (j, total) in sums.iter_mut().enumerate() {
            let keep = rows(stretch, &e.motion, j);
            let single = [stretch.torque.clone()];
            let records = if stretch.periods.is_empty() {
                &single[..]
            } else {
                &stretch.periods[..]
            };
            for record in records {
                for s in (0..keep.len()).filter(|&s| keep[s]) {
                    total.0 += (record[j][s] - e.torque[j][s]).powi(2);
                    total.1 += 1.0;
                }
            }
        }
    }
    sums.into_iter()
        .map(|(sum, count): (f64, f64)| (sum / count.max(1.0)).sqrt())
        .collect()
}
