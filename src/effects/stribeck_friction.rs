//! Friction that falls with speed just after breaking away.

use super::ranges::{STRIBECK_EXPONENT, STRIBECK_VELOCITY_M, STRIBECK_VELOCITY_RAD, by_kind};
use super::{About, Column, Effect, ParameterInfo, PlotVariable, Scene, Shape, Span, Statements, Written, own_joint};
use crate::model::Robot;

/// `tau_j += F exp(-(|qd|/v_s)^δ) sign qd`. Forms: δ = 2 (Gaussian), δ = 1 (exponential), δ free.
pub struct StribeckFriction;

impl Effect for StribeckFriction {
    fn code(&self) -> &'static str {
        "stribeck_friction"
    }

    fn about(&self) -> About {
        About {
            name: "Stribeck friction",
            phrase: "Stribeck friction",
            meaning: "Friction that is larger at low speed and falls to its Coulomb level as the lubricant film builds up.",
            over: PlotVariable::Speed,
            identifiable: "when the joint is driven below and well above the Stribeck velocity; a very small v_s hides in the samples around \
                           reversal, a very large one in viscous and Coulomb friction",
            rivals: &[
                "nonlinear_viscous_friction",
                "presliding_hysteresis",
                "load_dependent_friction",
            ],
            source: "Bittencourt & Gunnarsson 2012; Armstrong-Hélouvry 1994",
        }
    }

    fn forms(&self) -> usize {
        3
    }

    fn shapes(&self, form: usize, joints: &[usize], spans: &[Span]) -> Vec<Shape> {
        // Below a hundredth of the top speed hardly a sample is left that shows it; above the top speed it is a parabola at most.
        let speed = spans[joints[0]].speed.max(f64::MIN_POSITIVE);
        let mut shapes = vec![Shape::geometric(0.01 * speed, speed, 14)];
        if form == 2 {
            shapes.push(Shape {
                low: STRIBECK_EXPONENT[0],
                high: STRIBECK_EXPONENT[1],
                grid: vec![0.5, 1.5, 3.0],
            });
        }
        shapes
    }

    fn ranges(&self, form: usize, robot: &Robot, joints: &[usize]) -> Vec<[f64; 2]> {
        let velocity = by_kind(robot, joints[0], STRIBECK_VELOCITY_RAD, STRIBECK_VELOCITY_M);
        if form == 2 {
            vec![velocity, STRIBECK_EXPONENT]
        } else {
            vec![velocity]
        }
    }

    fn is_friction(&self, _form: usize) -> bool {
        true
    }

    fn columns(&self, form: usize, scene: &Scene, joints: &[usize], shape: &[f64]) -> Vec<Column> {
        let exponent = [2.0, 1.0, shape.get(1).copied().unwrap_or(2.0)][form];
        let bump = |[_, v, _]: [f64; 3]| (-(v.abs() / shape[0]).powf(exponent)).exp() * scene.sign(v);
        vec![own_joint(scene, joints[0], bump)]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let fixed = ["2.0", "1.0"].get(w.form).map(ToString::to_string);
        let exponent = fixed.unwrap_or_else(|| w.shape[1].clone());
        let (c, s) = (&w.coefficients[0], &w.shape[0]);
        w.on_own_joint(|[_, v, _]| format!("{c} * exp(-pow(fabs({v}) / {s}, {exponent})) * sign({v})"))
    }

    fn positive(&self, _form: usize) -> &'static [usize] {
        &[0]
    }

    fn parameters(&self, form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let joint = &robot.joints()[joints[0]];
        let mut list = vec![
            ParameterInfo::new("amplitude", joint.effort_unit()),
            ParameterInfo::new("velocity", format!("{}/s", joint.position_unit())),
        ];
        if form == 2 {
            list.push(ParameterInfo::new("exponent", "1"));
        }
        list
    }
}
