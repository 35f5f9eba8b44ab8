//! A torque sensor that feels its neighbour.

use super::ranges::CROSSTALK;
use super::{About, Column, Effect, ParameterInfo, PlotVariable, Reads, Scene, Statements, Travel, Written};
use crate::model::Robot;
use nalgebra::DMatrix;

/// `tau_j += c tau_i`; the joints of a finding are the disturbed one and the one it comes from.
pub struct TorqueCrosstalk;

impl Effect for TorqueCrosstalk {
    fn code(&self) -> &'static str {
        "torque_crosstalk"
    }

    fn about(&self) -> About {
        About {
            name: "Torque crosstalk",
            phrase: "torque crosstalk",
            meaning: "A part of the torque of one joint appears in the measurement of another.",
            over: PlotVariable::Torque,
            identifiable: "when the other joint's torque is not a combination of terms the joint's own row holds",
            rivals: &["transmission_coupling", "torque_gain"],
            source: "Hashimoto 1993 (torque sensors in gears)",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Arm
    }

    fn places(&self, robot: &Robot) -> Vec<Vec<usize>> {
        let n = robot.joint_count();
        (0..n)
            .flat_map(|j| (0..n).filter(move |&i| i != j).map(move |i| vec![j, i]))
            .collect()
    }

    fn reads_torques(&self) -> bool {
        true
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        vec![Column::on(joints[0], scene.declared[joints[1]].clone())]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let (j, i, c) = (w.joints[0], w.joints[1], &w.coefficients[0]);
        Some(Statements {
            torque: vec![(j, format!("{c} * declared[{i}]"))],
            inertia: (0..w.count).map(|k| (j, k, format!("{c} * r[{i}][{k}]"))).collect(),
        })
    }

    fn is_plausible(&self, coefficients: &[f64], _covariance: &DMatrix<f64>, _travel: Travel) -> bool {
        coefficients[0].abs() < CROSSTALK
    }

    fn is_rare(&self) -> bool {
        true
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let unit = |j: usize| robot.joints()[j].effort_unit();
        let (to, from) = (unit(joints[0]), unit(joints[1]));
        vec![ParameterInfo::new(
            "coefficient",
            if to == from { "1".into() } else { format!("({to})/({from})") },
        )]
    }
}
