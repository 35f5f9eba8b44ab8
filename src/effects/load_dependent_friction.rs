//! Friction that grows with the torque carried.

use super::ranges::LOAD_FRICTION;
use super::{About, Column, Effect, ParameterInfo, PlotVariable, Reads, Scene, Statements, Travel, Written};
use crate::model::Robot;
use nalgebra::DMatrix;

/// `tau_j += μ |tau_rigid,j| sign qd`.
pub struct LoadDependentFriction;

impl Effect for LoadDependentFriction {
    fn code(&self) -> &'static str {
        "load_dependent_friction"
    }

    fn about(&self) -> About {
        About {
            name: "Load-dependent friction",
            phrase: "load-dependent friction",
            meaning: "Friction that grows with the torque that the gear transmits.",
            over: PlotVariable::Torque,
            identifiable: "when the load of the joint changes along the motion: gravity loads do, a joint on a vertical axis needs acceleration",
            rivals: &["torque_gain", "stribeck_friction"],
            source: "Hamon, Gautier, Garrec, Janot 2010",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Arm
    }

    fn reads_torques(&self) -> bool {
        true
    }

    fn is_friction(&self, _form: usize) -> bool {
        true
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        let j = joints[0];
        let load = &scene.rigid[j];
        let values = scene
            .motion
            .velocities(j)
            .iter()
            .zip(load)
            .map(|(&v, t)| t.abs() * scene.sign(v));
        vec![Column::on(j, values.collect())]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let j = w.joints[0];
        w.on_own_joint(|[_, v, _]| format!("{} * fabs(rigid[{j}]) * sign({v})", w.coefficients[0]))
    }

    fn positive(&self, _form: usize) -> &'static [usize] {
        &[0]
    }

    fn is_plausible(&self, coefficients: &[f64], _covariance: &DMatrix<f64>, _travel: Travel) -> bool {
        coefficients[0] < LOAD_FRICTION[1]
    }

    fn parameters(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<ParameterInfo> {
        vec![ParameterInfo::new("coefficient", "1")]
    }
}
