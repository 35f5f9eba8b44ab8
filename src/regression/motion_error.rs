//! What errors in the measured motion do to the torque that a model predicts.

use super::dataset::Stretch;
use super::model::AugmentedModel;
use crate::dynamics::Motion;
use crate::regression::settings::SETTINGS;

/// Variance of white noise on the torque of every joint, for one measurement, that weighs as much as what errors in the positions do to it [(N·m)² or N²]; the
/// largest of all stretches that repeat.
///
/// To first order a motion off by `δ` predicts a torque off by `∂τ/∂q δ + ∂τ/∂q̇ δ' + ∂τ/∂q̈ δ''`. The periods' mean is taken along one motion, so that no scatter
/// of the periods shows it. Errors of different joints and of different derivatives are taken for independent.
///
/// The errors lie below the motion's highest frequency, where the model's columns lie as well: their variance is spread over few of the spectrum's lines, and counts by
/// the density there ([`MotionError::density`](crate::preparation::MotionError)).
pub(crate) fn motion_error_variance(model: &AugmentedModel, stretches: &[Stretch]) -> Vec<f64> {
    let nothing = vec![0.0; model.robot.joint_count()];
    let repeating = stretches.iter().filter(|s| s.periods.len() >= 2);
    repeating.map(|s| of_stretch(model, s)).fold(nothing, |largest, own| {
        largest.iter().zip(own).map(|(a, b)| a.max(b)).collect()
    })
}

fn of_stretch(model: &AugmentedModel, stretch: &Stretch) -> Vec<f64> {
    let motion = sampled(&stretch.motion);
    let predicted = |motion: &Motion| model.torques(motion, &model.robot, None).declared;
    let undisturbed = predicted(&motion);
    let samples_per_row = match stretch.samples.as_slice() {
        [first, second, ..] => (second - first) as f64,
        _ => 1.0,
    };
    let mut variance = vec![0.0; stretch.joints()];
    for (joint, error) in stretch.motion_error.iter().enumerate() {
        for (order, size) in error.std_dev.iter().enumerate().filter(|(_, size)| **size > 0.0) {
            let off = disturbed(&motion, joint, order, *size);
            let weight = stretch.repetitions() as f64 * (error.density(order) / samples_per_row).max(1.0);
            // At a reversal the sign of friction is not known; such rows are left out of every fit.
            let rows: Vec<usize> = (0..motion.samples())
                .filter(|&s| motion.velocities(joint)[s].signum() == off.velocities(joint)[s].signum())
                .collect();
            for (own, (after, before)) in variance.iter_mut().zip(predicted(&off).iter().zip(&undisturbed)) {
                let square: f64 = rows.iter().map(|&s| (after[s] - before[s]).powi(2)).sum();
                *own += weight * square / rows.len().max(1) as f64;
            }
        }
    }
    variance
}

/// Samples of a motion, evenly spread, enough for a mean square.
fn sampled(motion: &Motion) -> Motion {
    let count = motion.samples().min(SETTINGS.motion_error_samples);
    let at = |i: usize| i * motion.samples() / count;
    Motion::from_fn(motion.joints(), count, |j, i| {
        [
            motion.positions(j)[at(i)],
            motion.velocities(j)[at(i)],
            motion.accelerations(j)[at(i)],
        ]
    })
}

/// The same with derivative `order` of one joint off by `size`.
fn disturbed(motion: &Motion, joint: usize, order: usize, size: f64) -> Motion {
    let mut off = motion.clone();
    for s in 0..motion.samples() {
        let mut state = [
            motion.positions(joint)[s],
            motion.velocities(joint)[s],
            motion.accelerations(joint)[s],
        ];
        state[order] += size;
        off.set(joint, s, state);
    }
    off
}
