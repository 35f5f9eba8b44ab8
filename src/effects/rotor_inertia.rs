//! Inertia of the motor, seen through the gear.

use super::{About, Column, Effect, ParameterInfo, Scene, own_joint, times_position_unit};
use crate::model::Robot;

/// `tau_j += Ia qdd_j`.
pub struct RotorInertia;

impl Effect for RotorInertia {
    fn code(&self) -> &'static str {
        "rotor_inertia"
    }

    fn about(&self) -> About {
        About {
            meaning: "reflected inertia of rotor and gear (ratio squared times rotor inertia); with link-side sensors it is not in the torque",
            identifiable: "where the base parameters do not hold it already: on joint 1 it is part of ZZR1, and on the next joints of \
                           ZZR_j as long as their axes keep a constant direction relative to the first",
            rivals: &["torque_gain", "torque_delay", "joint_elasticity"],
            source: "Khalil & Dombre 2004, section 9.3; Gautier & Khalil 1990",
        }
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        vec![own_joint(scene, joints[0], |[_, _, a]| a)]
    }

    fn positive(&self, _form: usize) -> &'static [usize] {
        &[0]
    }

    fn is_everyday(&self) -> bool {
        true
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let unit = if robot.joints()[joints[0]].is_revolute() {
            "kg m^2".into()
        } else {
            times_position_unit(robot, joints[0], " s^2/rad")
        };
        vec![ParameterInfo::new("inertia", unit)]
    }
}
