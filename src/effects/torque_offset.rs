//! A constant torque: sensor zero, amplifier bias, or a Coulomb level that differs between the directions.

use super::{About, Column, Effect, ParameterInfo, PlotVariable, Scene, Statements, Written, own_joint};
use crate::model::Robot;

/// `tau_j += o`.
pub struct TorqueOffset;

impl Effect for TorqueOffset {
    fn code(&self) -> &'static str {
        "torque_offset"
    }

    fn about(&self) -> About {
        About {
            name: "Torque offset",
            phrase: "a constant torque offset",
            meaning: "A constant torque of a joint, from the zero of its sensor or current measurement.",
            over: PlotVariable::Time,
            identifiable: "always, as soon as the joint moves; a joint spring with the same mean torque needs travel to be distinguished from it",
            rivals: &["joint_spring", "base_tilt", "asymmetric_viscous_friction", "external_contact"],
            source: "Janot, Gautier, Brunot 2019 (EMPS); Khalil & Dombre 2004, section 12.3",
        }
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        vec![own_joint(scene, joints[0], |_| 1.0)]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        w.on_own_joint(|_| w.coefficients[0].clone())
    }

    fn is_everyday(&self) -> bool {
        true
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        vec![ParameterInfo::new("offset", robot.joints()[joints[0]].effort_unit())]
    }
}
