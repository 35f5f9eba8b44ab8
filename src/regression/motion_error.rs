//! What errors in the measured motion do to the torque that a model predicts.

use super::dataset::Stretch;
use super::model::AugmentedModel;
use crate::dynamics::Motion;
use crate::regression::settings::SETTINGS;

/// Autocovariance, by lag from 0 in rows, of the torque error of every joint that errors in the positions make, for one measurement [(N·m)² or N²]; the largest of
/// all stretches that repeat.
///
/// To first order a motion off by `δ` predicts a torque off by `∂τ/∂q δ + ∂τ/∂q̇ δ' + ∂τ/∂q̈ δ''`. The periods' mean is taken along one motion, so that no scatter
/// of the periods shows it. Errors of different joints and of different derivatives are taken for independent.
pub(crate) fn motion_error_covariance(model: &AugmentedModel, stretches: &[Stretch]) -> Vec<Vec<f64>> {
    let nothing = vec![vec![0.0; SETTINGS.noise_terms + 1]; model.robot.joint_count()];
    let repeating = stretches.iter().filter(|s| s.periods.len() >= 2);
    repeating.map(|s| of_stretch(model, s)).fold(nothing, |largest, own| {
        let pairs = largest.into_iter().zip(own);
        pairs.map(|(a, b)| if b[0] > a[0] { b } else { a }).collect()
    })
}

fn of_stretch(model: &AugmentedModel, stretch: &Stretch) -> Vec<Vec<f64>> {
    let motion = sampled(&stretch.motion);
    let predicted = |motion: &Motion| model.torques(motion, &model.robot, None).declared;
    let undisturbed = predicted(&motion);
    let per_row = match stretch.samples.as_slice() {
        [first, second, ..] => (second - first) as f64,
        _ => 1.0,
    };
    let repetitions = stretch.repetitions() as f64;
    let mut covariance = vec![vec![0.0; SETTINGS.noise_terms + 1]; stretch.joints()];
    for (joint, error) in stretch.motion_error.iter().enumerate() {
        for (order, size) in error.std_dev.iter().enumerate().filter(|(_, size)| **size > 0.0) {
            let off = disturbed(&motion, joint, order, *size);
            let torque = predicted(&off);
            let correlation: Vec<f64> = (0..=SETTINGS.noise_terms)
                .map(|lag| repetitions * error.autocorrelation(order, lag as f64 * per_row))
                .collect();
            // At a reversal the sign of friction is not known; such rows are left out of every fit.
            let rows: Vec<usize> = (0..motion.samples())
                .filter(|&s| motion.velocities(joint)[s].signum() == off.velocities(joint)[s].signum())
                .collect();
            for (own, (after, before)) in covariance.iter_mut().zip(torque.iter().zip(&undisturbed)) {
                let square: f64 = rows.iter().map(|&s| (after[s] - before[s]).powi(2)).sum();
                let variance = square / rows.len().max(1) as f64;
                own.iter_mut().zip(&correlation).for_each(|(c, r)| *c += variance * r);
            }
        }
    }
    covariance
}

/// Samples of a motion, evenly spread, enough for a mean square.
fn sampled(motion: &Motion) -> Motion {
    let count = motion.samples().min(SETTINGS.motion_error_samples);
    let at = |i: usize| i * motion.samples() / count;
    Motion::from_fn(motion.joints(), count, |j, i| {
        [motion.positions(j)[at(i)], motion.velocities(j)[at(i)], motion.accelerations(j)[at(i)]]
    })
}

/// The same with derivative `order` of one joint off by `size`.
fn disturbed(motion: &Motion, joint: usize, order: usize, size: f64) -> Motion {
    let mut off = motion.clone();
    for s in 0..motion.samples() {
        let mut state = [motion.positions(joint)[s], motion.velocities(joint)[s], motion.accelerations(joint)[s]];
        state[order] += size;
        off.set(joint, s, state);
    }
    off
}
