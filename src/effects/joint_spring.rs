//! A spring across a joint.

use super::{
    About, Column, Effect, ParameterInfo, PlotVariable, Scene, Statements, Travel, Written, own_joint, times_position_unit,
};
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
            name: "Joint spring",
            phrase: "a joint spring",
            meaning: "Torque proportional to the distance from a rest position: a counterbalance, a hose or a cable.",
            over: PlotVariable::Position,
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

    fn statements(&self, w: &Written) -> Option<Statements> {
        let c = &w.coefficients;
        w.on_own_joint(|[q, _, _]| format!("{} * {q} + {}", c[0], c[1]))
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        vec![
            ParameterInfo::new("stiffness", times_position_unit(robot, joints[0], "/rad")),
            ParameterInfo::new("rest_position", robot.joints()[joints[0]].position_unit()),
        ]
    }

    fn positive(&self, _form: usize) -> &'static [usize] {
        &[0]
    }

    /// At rest in the middle of the motion, where it pulls least.
    fn units(&self, _form: usize, _count: usize, middle: f64) -> Vec<Vec<f64>> {
        vec![vec![1.0, -middle]]
    }

    /// Stiff beyond doubt (three standard deviations), and at rest where the joint can be, as far as the data tell: otherwise it
    /// is a torque offset.
    fn is_plausible(&self, coefficients: &[f64], covariance: &DMatrix<f64>, travel: Travel) -> bool {
        let [k, c] = [coefficients[0], coefficients[1]];
        if k < 3.0 * covariance[(0, 0)].max(0.0).sqrt() {
            return false;
        }
        // The rest is −c/k.
        let (rest, slope) = (-c / k, [c / (k * k), -1.0 / k]);
        let variance: f64 = (0..2)
            .map(|a| (0..2).map(|b| slope[a] * slope[b] * covariance[(a, b)]).sum::<f64>())
            .sum();
        let doubt = 3.0 * variance.max(0.0).sqrt();
        rest + doubt > travel.low && rest - doubt < travel.high
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

    /// At rest a turn away on either side.
    fn borders(&self) -> Vec<Vec<f64>> {
        vec![vec![1.0, REACH], vec![1.0, -REACH]]
    }

    /// The softest spring that holds the constant from within reach.
    fn brought_within_reach(&self, coefficients: &[f64]) -> Vec<f64> {
        let softest = coefficients[1].abs() / REACH;
        vec![coefficients[0].abs().max(softest).copysign(coefficients[0]), coefficients[1]]
    }

    fn reported(&self, _form: usize, coefficients: &[f64], _shape: &[f64]) -> Vec<f64> {
        vec![coefficients[0], -coefficients[1] / coefficients[0]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The border is where the rule changes its mind, and what is brought within reach lies on it.
    #[test]
    fn prop_borders_part_springs_that_could_be_there_from_constants() {
        let (certain, spring) = (DMatrix::zeros(2, 2), JointSpring);
        for border in spring.borders() {
            let at = |share: f64| [0.3 * border[0], 0.3 * share * border[1]];
            assert!(spring.is_within_reach(&at(0.999), &certain) && !spring.is_within_reach(&at(1.001), &certain));
            let brought = spring.brought_within_reach(&at(5.0));
            // Multiples of one direction have no area between them; rounding of products of the order of 10.
            assert!((brought[0] * border[1] - brought[1] * border[0]).abs() < 1e-12, "{brought:?}");
            assert_eq!(spring.brought_within_reach(&at(0.5)), at(0.5));
        }
    }
}
