//! Friction that grows faster or slower than the speed.

use super::ranges::VISCOUS_EXPONENT;
use super::{
    About, Column, Effect, ParameterInfo, PlotVariable, Scene, Shape, Span, Statements, Written, own_joint, times_position_unit,
};
use crate::model::Robot;

/// `tau_j += f |qd|^α sign qd`. Forms: α = 2, α = 3, α = 1/2, α free.
pub struct NonlinearViscousFriction;

const FIXED: [f64; 3] = [2.0, 3.0, 0.5];

impl NonlinearViscousFriction {
    fn exponent(form: usize, shape: &[f64]) -> f64 {
        FIXED.get(form).copied().unwrap_or_else(|| shape[0])
    }
}

impl Effect for NonlinearViscousFriction {
    fn code(&self) -> &'static str {
        "nonlinear_viscous_friction"
    }

    fn about(&self) -> About {
        About {
            name: "Nonlinear viscous friction",
            phrase: "nonlinear viscous friction",
            meaning: "Viscous friction with a quadratic, cubic or power-law part in speed, typical of grease.",
            over: PlotVariable::Speed,
            identifiable: "when the joint is driven over a wide range of speeds; near α = 0 and α = 1 it is Coulomb and viscous friction",
            rivals: &["stribeck_friction", "asymmetric_viscous_friction"],
            source: "Bittencourt & Gunnarsson 2012; Simoni et al. 2015",
        }
    }

    fn forms(&self) -> usize {
        4
    }

    fn shapes(&self, form: usize, _joints: &[usize], _spans: &[Span]) -> Vec<Shape> {
        // 0 and 1 are columns of the declared model; next to them the coefficient is determined by rounding alone.
        let free = Shape {
            low: VISCOUS_EXPONENT[0],
            high: VISCOUS_EXPONENT[1],
            grid: vec![0.25, 0.35, 0.7, 0.85, 1.25, 1.6, 2.5, 4.0],
        };
        if form == 3 { vec![free] } else { Vec::new() }
    }

    fn is_friction(&self, _form: usize) -> bool {
        true
    }

    fn columns(&self, form: usize, scene: &Scene, joints: &[usize], shape: &[f64]) -> Vec<Column> {
        let alpha = Self::exponent(form, shape);
        vec![own_joint(scene, joints[0], |[_, v, _]| v.abs().powf(alpha) * scene.sign(v))]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let fixed = ["2.0", "3.0", "0.5"].get(w.form).map(ToString::to_string);
        let exponent = fixed.unwrap_or_else(|| w.shape[0].clone());
        w.on_own_joint(|[_, v, _]| format!("{} * pow(fabs({v}), {exponent}) * sign({v})", w.coefficients[0]))
    }

    fn parameters(&self, form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let exponent = FIXED.get(form).map_or("alpha".into(), ToString::to_string);
        let mut list = vec![ParameterInfo::new(
            "coefficient",
            times_position_unit(robot, joints[0], &format!(" (s/rad)^{exponent}")),
        )];
        if form == 3 {
            list.push(ParameterInfo::new("exponent", "1"));
        }
        list
    }
}
