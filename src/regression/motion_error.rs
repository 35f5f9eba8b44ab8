//! What errors in the measured motion do to the torque that a model predicts.

use super::dataset::Stretch;
use super::model::AugmentedModel;
use super::rows::clear_of_reversals;
use crate::dynamics::{Coulomb, Motion};
use crate::effects::Motions;
use crate::regression::settings::SETTINGS;

/// Variance of white noise on the torque of every joint, for one measurement, that weighs as much as what errors in the positions
/// do to it [(N·m)² or N²]; the largest of all stretches that repeat.
///
/// To first order a motion off by `δ` predicts a torque off by `∂τ/∂q δ + ∂τ/∂q̇ δ' + ∂τ/∂q̈ δ''`. The periods' mean is taken
/// along one motion, so that no scatter of the periods shows it. Errors of different joints and of different derivatives are
/// taken for independent.
///
/// The errors lie below the motion's highest frequency, where the model's columns lie as well: their variance is spread over few
/// of the spectrum's lines, and counts by the density there ([`MotionError`](crate::preparation::MotionError)).
pub(crate) fn motion_error_variance(model: &AugmentedModel, stretches: &[Stretch]) -> Vec<f64> {
    let nothing = vec![0.0; model.robot.joint_count()];
    let repeating = stretches.iter().filter(|s| s.periods.len() >= 2);
    repeating.map(|s| of_stretch(model, s)).fold(nothing, |largest, own| {
        largest.iter().zip(own).map(|(a, b)| a.max(b)).collect()
    })
}

fn of_stretch(model: &AugmentedModel, stretch: &Stretch) -> Vec<f64> {
    let at = sampled(stretch.motion.samples());
    let motion = Motion::from_fn(stretch.joints(), at.len(), |j, s| stretch.motion.get(j, at[s]));
    let predicted = |motion: &Motion| model.torques(Motions::stiff(motion), &model.robot, None).declared;
    let undisturbed = predicted(&motion);
    let samples_per_row = match stretch.samples.as_slice() {
        [first, second, ..] => (second - first) as f64,
        _ => 1.0,
    };
    let mut variance = vec![0.0; stretch.joints()];
    for (joint, error) in stretch.motion_error.iter().enumerate() {
        // At a reversal the sign of friction is not known; such rows are left out of every fit.
        let clear = clear_of_reversals(stretch.motion.velocities(joint), stretch.periodic);
        for (order, size) in error.std_dev.iter().enumerate().filter(|(_, size)| **size > 0.0) {
            let off = disturbed(&motion, joint, order, *size);
            let weight = stretch.repetitions() as f64 * (error.density[order] / samples_per_row).max(1.0);
            let sign = |m: &Motion, s: usize| Coulomb::Sign.value(m.velocities(joint)[s]);
            let rows: Vec<usize> = (0..at.len())
                .filter(|&s| clear[at[s]] && sign(&motion, s) == sign(&off, s))
                .collect();
            for (own, (after, before)) in variance.iter_mut().zip(predicted(&off).iter().zip(&undisturbed)) {
                let square: f64 = rows.iter().map(|&s| (after[s] - before[s]).powi(2)).sum();
                *own += weight * square / rows.len().max(1) as f64;
            }
        }
    }
    variance
}

/// Samples of a motion of `count`, evenly spread, enough for a mean square.
fn sampled(count: usize) -> Vec<usize> {
    let used = count.min(SETTINGS.motion_error_samples);
    (0..used).map(|i| i * count / used).collect()
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

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::model::{Friction, Joint, JointKind, Mdh, Robot};
    use crate::preparation::MotionError;
    use nalgebra::Vector3;

    /// A planar arm with friction.
    pub fn two_links() -> Robot {
        let joint = |name: &str, d: f64| {
            let mdh = Mdh {
                alpha: 0.0,
                d,
                theta: 0.0,
                r: 0.0,
            };
            Joint::from_mdh(name, JointKind::Revolute, mdh)
        };
        let friction = Friction {
            viscous: true,
            coulomb: true,
        };
        let gravity = Vector3::new(0.0, -9.81, 0.0);
        Robot::new("two links", gravity, vec![joint("q1", 0.0), joint("q2", 0.4)], friction).unwrap()
    }

    /// A joint that turns back at samples where its velocity is exactly zero, or a rounding error on either side of it.
    #[test]
    fn prop_reversals_add_no_error_of_friction() {
        for velocity in [0.0, -0.0, 1e-17, -1e-17] {
            let wave = |s: usize| std::f64::consts::TAU * s as f64 / 128.0;
            let motion = Motion::from_fn(2, 128, |j, s| match j {
                1 if s % 64 == 0 => [wave(s).cos(), velocity, 0.0],
                _ => [wave(s).cos(), -wave(s).sin(), -wave(s).cos()],
            });
            let error = MotionError {
                std_dev: [1e-15; 3],
                density: [1.0; 3],
            };
            let stretch = Stretch {
                motion_error: vec![error; 2],
                ..Stretch::of_motion(motion, 0.01, true)
            };
            let robot = two_links();
            let mut model = AugmentedModel::declared(&robot);
            model.values.fill(1.0);
            let variance = motion_error_variance(
                &model,
                &[Stretch {
                    periods: vec![stretch.torque.clone(); 2],
                    ..stretch
                }],
            );
            // Coulomb friction of 1 N·m at one row would be 1e-2; the rest is in proportion to the error.
            assert!(variance.iter().all(|v| (0.0..1e-25).contains(v)), "{variance:?}");
        }
    }
}
