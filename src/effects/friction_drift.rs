//! Friction that changes while the robot runs.

use super::{About, Column, Effect, EffectKind, ParameterInfo, PlotVariable, Scene, Statements, Written, own_joint};
use crate::model::Robot;

/// `tau_j += (dFV qd + dFS sign qd) g(t)`: over the periods of a log g is the course of warming up, `exp(−t/T)`; against an
/// existing model it is 1.
pub struct FrictionDrift;

impl Effect for FrictionDrift {
    fn code(&self) -> &'static str {
        "friction_drift"
    }

    fn about(&self) -> About {
        About {
            name: "Friction drift",
            phrase: "friction that changes over time",
            meaning: "Friction changes during the log, for example while the gear warms up.",
            over: PlotVariable::Time,
            identifiable: "with periods looked at one by one (their average hides it), or against an existing model",
            rivals: &["torque_offset", "nonlinear_viscous_friction"],
            source: "Bittencourt & Gunnarsson 2012 (temperature)",
        }
    }

    fn kind(&self) -> EffectKind {
        EffectKind::AgainstModel
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        vec![
            own_joint(scene, joints[0], |[_, v, _]| v),
            own_joint(scene, joints[0], |[_, v, _]| scene.sign(v)),
        ]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let c = &w.coefficients;
        w.on_own_joint(|[_, v, _]| format!("{} * {v} + {} * sign({v})", c[0], c[1]))
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let joint = &robot.joints()[joints[0]];
        let viscous = if joint.is_revolute() { "N m s/rad" } else { "N s/m" };
        vec![
            ParameterInfo::new("viscous_change", viscous),
            ParameterInfo::new("coulomb_change", joint.effort_unit()),
        ]
    }
}
