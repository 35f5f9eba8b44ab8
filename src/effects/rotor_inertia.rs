//! Inertia of the motor, seen through the gear.

use super::{About, Column, Effect, ParameterInfo, PlotVariable, Scene, Statements, Written, own_joint, times_position_unit};
use crate::model::Robot;

/// `tau_j += Ia qdd_j`.
pub struct RotorInertia;

impl Effect for RotorInertia {
    fn code(&self) -> &'static str {
        "rotor_inertia"
    }

    fn about(&self) -> About {
        About {
            name: "Rotor inertia",
            phrase: "rotor inertia",
            meaning: "Inertia of the motor as seen at the joint, rotor inertia times gear ratio squared.",
            over: PlotVariable::Acceleration,
            identifiable: "where the base parameters do not hold it already: on joint 1 it is part of ZZR1, and on the next joints of \
                           ZZR_j as long as their axes keep a constant direction relative to the first",
            rivals: &["torque_gain", "torque_delay", "joint_elasticity"],
            source: "Khalil & Dombre 2004, section 9.3; Gautier & Khalil 1990",
        }
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        vec![own_joint(scene, joints[0], |[_, _, a]| a)]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let (j, c) = (w.joints[0], &w.coefficients[0]);
        Some(Statements {
            torque: vec![(j, format!("{c} * qdd[{j}]"))],
            inertia: vec![(j, j, c.clone())],
        })
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
