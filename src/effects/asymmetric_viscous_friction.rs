//! Viscous friction that differs between the directions.

use super::{About, Column, Effect, ParameterInfo, PlotVariable, Scene, Statements, Written, own_joint, times_position_unit};
use crate::model::Robot;

/// `tau_j += a |qd|`: half the difference of the two directions' coefficients.
pub struct AsymmetricViscousFriction;

impl Effect for AsymmetricViscousFriction {
    fn code(&self) -> &'static str {
        "asymmetric_viscous_friction"
    }

    fn about(&self) -> About {
        About {
            name: "Asymmetric viscous friction",
            phrase: "direction-dependent viscous friction",
            meaning: "Viscous friction that differs between the two directions of motion.",
            over: PlotVariable::Speed,
            identifiable: "when both directions are driven at several speeds; at one speed it is a torque offset",
            rivals: &["torque_offset", "nonlinear_viscous_friction"],
            source: "Bittencourt & Gunnarsson 2012",
        }
    }

    fn is_friction(&self, _form: usize) -> bool {
        true
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        vec![own_joint(scene, joints[0], |[_, v, _]| v * scene.sign(v))]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        w.on_own_joint(|[_, v, _]| format!("{} * fabs({v})", w.coefficients[0]))
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        vec![ParameterInfo::new(
            "coefficient",
            times_position_unit(robot, joints[0], " s/rad"),
        )]
    }
}
