//! A spring across a joint.

use super::{About, Column, Effect, ParameterInfo, Scene, own_joint, times_position_unit};
use crate::model::Robot;

/// `tau_j += k (q_j − q0)`; as columns, k q and the constant −k q0.
pub struct JointSpring;

impl Effect for JointSpring {
    fn code(&self) -> &'static str {
        "joint_spring"
    }

    fn about(&self) -> About {
        About {
            meaning: "hoses and cables that bend with the joint, springs that balance gravity",
            identifiable: "over a travel on which q is not a combination of the gravity terms sin q and cos q of the joint; with little \
                           travel it is a torque offset",
            rivals: &["torque_offset", "base_tilt", "encoder_offset", "position_ripple"],
            source: "Khalil & Dombre 2004, section 9.3 (balancing springs)",
        }
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        vec![
            own_joint(scene, joints[0], |[q, _, _]| q),
            own_joint(scene, joints[0], |_| 1.0),
        ]
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        vec![
            ParameterInfo::new("stiffness", times_position_unit(robot, joints[0], "/rad")),
            ParameterInfo::new("rest_position", robot.joints()[joints[0]].position_unit()),
        ]
    }

    fn reported(&self, _form: usize, coefficients: &[f64], _shape: &[f64]) -> Vec<f64> {
        vec![coefficients[0], -coefficients[1] / coefficients[0]]
    }
}
