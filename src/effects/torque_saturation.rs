//! A motor whose torque is not proportional to its current.

use super::{About, Column, Effect, ParameterInfo, PlotVariable, Reads, Scene, Statements, Written};
use crate::model::Robot;

/// `tau_j += c tau_j³`, τ being the torque of the declared model and c > 0. Motors whose iron saturates need more current for
/// every further newton metre: torques that were computed from currents with one torque constant are too large at high load. The
/// cube is the first odd term of the characteristic beyond the gain.
pub struct TorqueSaturation;

impl Effect for TorqueSaturation {
    fn code(&self) -> &'static str {
        "torque_saturation"
    }

    fn about(&self) -> About {
        About {
            name: "Torque saturation",
            phrase: "saturation of the torque signal",
            meaning: "The torque channel is not proportional to the torque: a motor's iron saturates at high current.",
            over: PlotVariable::Torque,
            identifiable: "when the load of the joint changes over a wide range; over a narrow one it is a torque gain",
            rivals: &["torque_gain", "load_dependent_friction"],
            source: "Krause, Wasynczuk, Sudhoff & Pekarek 2013 (saturation of machines)",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Arm
    }

    fn reads_torques(&self) -> bool {
        true
    }

    fn positive(&self, _form: usize) -> &'static [usize] {
        &[0]
    }

    fn is_rare(&self) -> bool {
        true
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        let j = joints[0];
        vec![Column::on(j, scene.declared[j].iter().map(|t| t.powi(3)).collect())]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let t = format!("declared[{}]", w.joints[0]);
        w.on_own_joint(|_| format!("{} * {t} * {t} * {t}", w.coefficients[0]))
    }

    fn example(&self, count: usize, noise: f64, load: f64) -> Vec<f64> {
        vec![4.0 * noise / load.powi(3); count]
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let unit = format!("1/({})^2", robot.joints()[joints[0]].effort_unit());
        vec![ParameterInfo::new("coefficient", unit)]
    }
}
