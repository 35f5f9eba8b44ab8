//! A spring across a joint.

use super::{About, Column, Effect, ParameterInfo, Scene, own_joint, times_position_unit};
use crate::model::Robot;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// A hose or a balancing spring is at rest within a turn (or as many metres) of where the joint can be.
const REACH: f64 = TAU;

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

    /// A soft spring with its rest far away is a constant.
    fn contains(&self) -> &'static [&'static str] {
        &["torque_offset"]
    }

    /// The stiffest spring that the data allow holds the constant with its rest at `c/k`.
    fn is_within_reach(&self, coefficients: &[f64], covariance: &DMatrix<f64>) -> bool {
        let stiffest = coefficients[0].abs() + 3.0 * covariance[(0, 0)].max(0.0).sqrt();
        coefficients[1].abs() < REACH * stiffest
    }

    fn reported(&self, _form: usize, coefficients: &[f64], _shape: &[f64]) -> Vec<f64> {
        vec![coefficients[0], -coefficients[1] / coefficients[0]]
    }
}
