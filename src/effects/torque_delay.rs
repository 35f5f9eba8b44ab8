//! A torque stream that is late.

use super::interpolation::at_time;
use super::ranges::DELAY;
use super::{About, Effect, EffectKind, ParameterInfo, PlotVariable, Reads, Scene, World};
use crate::model::Robot;

/// `tau(t) = tau_model(t − T)` on all joints; T in seconds, any fraction of a sample.
pub struct TorqueDelay;

impl Effect for TorqueDelay {
    fn code(&self) -> &'static str {
        "torque_delay"
    }

    fn about(&self) -> About {
        About {
            name: "Torque delay",
            phrase: "a torque delay",
            meaning: "The torque channel is late by a constant time relative to the positions.",
            over: PlotVariable::Speed,
            identifiable: "when torques change quickly; on slow motion it is a change of viscous friction and of inertia",
            rivals: &["rotor_inertia", "nonlinear_viscous_friction", "joint_elasticity"],
            source: "Swevers, Verdonck & De Schutter 2007; Gautier 1997 (filter delays)",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Course
    }

    fn kind(&self) -> EffectKind {
        EffectKind::Distortion
    }

    fn places(&self, _robot: &Robot) -> Vec<Vec<usize>> {
        vec![Vec::new()]
    }

    fn distort(&self, scene: &Scene, _joints: &[usize], theta: &[f64], world: &mut World) {
        let before = world.motion.clone();
        for s in 0..scene.samples() {
            for j in 0..before.joints() {
                let state = at_time(
                    &before,
                    j,
                    s as f64 - theta[0] / scene.interval,
                    scene.interval,
                    scene.periodic,
                );
                world.motion.set(j, s, state);
            }
        }
    }

    fn steps(&self) -> &'static [f64] {
        // A tenth of a millisecond: the motion is smooth over that, and sign changes within it are left out of the fit.
        &[1e-4]
    }

    fn is_differenced_both_ways(&self) -> bool {
        true
    }

    /// Half a sample: over less, a reversal of friction lies in the difference in one row of many and is multiplied there, where
    /// over half a sample it is in every second row, as it is in the torque that is late.
    fn least_step(&self, interval: f64) -> f64 {
        0.5 * interval
    }

    fn ranges(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<[f64; 2]> {
        vec![[-DELAY, DELAY]]
    }

    fn is_rare(&self) -> bool {
        true
    }

    fn parameters(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<ParameterInfo> {
        vec![ParameterInfo::new("delay", "s")]
    }
}
