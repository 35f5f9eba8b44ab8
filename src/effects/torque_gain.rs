//! A torque channel with the wrong scale.

use super::ranges::GAIN;
use super::{About, Effect, EffectKind, ParameterInfo, PlotVariable, Reads, Scene, World};
use crate::model::Robot;

/// `tau_j = (1 + γ) tau_true,j`.
pub struct TorqueGain;

impl Effect for TorqueGain {
    fn code(&self) -> &'static str {
        "torque_gain"
    }

    fn about(&self) -> About {
        About {
            name: "Torque gain",
            phrase: "a torque scale error",
            meaning: "The torque channel has a wrong factor, such as a torque constant or gear ratio that is off.",
            over: PlotVariable::Torque,
            identifiable: "relative to the other joints, through the inertial parameters they share; on a joint that shares none it is \
                           the parameters' scale",
            rivals: &["load_dependent_friction", "rotor_inertia", "joint_elasticity"],
            source: "Gautier & Briot 2014 (drive gains)",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Arm
    }

    fn kind(&self) -> EffectKind {
        EffectKind::Distortion
    }

    fn places(&self, robot: &Robot) -> Vec<Vec<usize>> {
        // With one joint nothing is left to compare its scale with.
        (0..robot.joint_count())
            .filter(|_| robot.joint_count() > 1)
            .map(|j| vec![j])
            .collect()
    }

    fn distort(&self, _scene: &Scene, joints: &[usize], theta: &[f64], world: &mut World) {
        world.gain[joints[0]] *= 1.0 + theta[0];
    }

    fn keeps_motion(&self) -> bool {
        true
    }

    fn steps(&self) -> &'static [f64] {
        &[1e-4]
    }

    fn ranges(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<[f64; 2]> {
        vec![[-GAIN, GAIN]]
    }

    fn is_rare(&self) -> bool {
        true
    }

    fn parameters(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<ParameterInfo> {
        vec![ParameterInfo::new("gain", "1")]
    }

    fn reported(&self, _form: usize, _coefficients: &[f64], shape: &[f64]) -> Vec<f64> {
        vec![1.0 + shape[0]]
    }
}
