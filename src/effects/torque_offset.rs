//! A constant torque: sensor zero, amplifier bias, or a Coulomb level that differs between the directions.

use super::{About, Column, Effect, ParameterInfo, Scene, own_joint};
use crate::model::Robot;

/// `tau_j += o`.
pub struct TorqueOffset;

impl Effect for TorqueOffset {
    fn code(&self) -> &'static str {
        "torque_offset"
    }

    fn about(&self) -> About {
        About {
            meaning: "a constant torque: zero of the torque sensor or of the current, or a Coulomb level that differs between directions",
            identifiable: "always, as soon as the joint moves; a joint spring with the same mean torque needs travel to be distinguished from it",
            rivals: &["joint_spring", "base_tilt", "asymmetric_viscous_friction", "external_contact"],
            source: "Janot, Gautier, Brunot 2019 (EMPS); Khalil & Dombre 2004, section 12.3",
        }
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        vec![own_joint(scene, joints[0], |_| 1.0)]
    }

    fn is_everyday(&self) -> bool {
        true
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        vec![ParameterInfo::new("offset", robot.joints()[joints[0]].effort_unit())]
    }
}
