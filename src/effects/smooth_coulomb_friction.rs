//! Coulomb friction without a jump.

use super::ranges::{FRICTION_LEAD, SMOOTHING_M, SMOOTHING_RAD, by_kind};
use super::{About, Column, Effect, ParameterInfo, PlotVariable, Scene, Shape, Span, Statements, Written, own_joint};
use crate::model::Robot;

/// `tau_j += F (s(qd/v) − sign qd)`: with the declared Coulomb friction at the same level F the sum is `F s(qd/v)`, which goes
/// through zero with the speed. Forms: `s = tanh`; `s` a straight line up to the level (`qd/v` within ±1); and the line as a
/// function of `(qd + T qdd)/v`. The last is friction that a simulator computes as a soft constraint: it acts on the speed that
/// the joint is about to have, T = `dmax timeconst / 2` of MuJoCo's `solimp` and `solref`.
pub struct SmoothCoulombFriction;

/// The form with a lead.
const LEADS: usize = 2;

fn smooth(form: usize, x: f64) -> f64 {
    if form == 0 { x.tanh() } else { x.clamp(-1.0, 1.0) }
}

impl Effect for SmoothCoulombFriction {
    fn code(&self) -> &'static str {
        "smooth_coulomb_friction"
    }

    fn about(&self) -> About {
        About {
            name: "Smooth Coulomb friction",
            phrase: "Coulomb friction smooth around zero speed",
            meaning: "Coulomb friction whose sign changes gradually around zero speed.",
            over: PlotVariable::Speed,
            identifiable: "when samples lie within the speed over which it grows; which of its shapes it has is hard to tell",
            rivals: &["presliding_hysteresis", "stribeck_friction", "torque_delay"],
            source: "Andersson, Söderberg & Björklund 2007 (smoothed friction laws); Todorov 2014 (friction loss as a soft constraint)",
        }
    }

    fn forms(&self) -> usize {
        3
    }

    fn shapes(&self, form: usize, joints: &[usize], spans: &[Span]) -> Vec<Shape> {
        // Below a thousandth of the top speed no row is left that shows it; above a third it is viscous friction. Within three
        // deviations of the speed its sign is not known, and a jump at the wrong instant looks as smooth: eight deviations wide
        // on 2 of 104 logs with noise of positions of 1e-3 rad, at reversals so slow that the jump is off by milliseconds.
        let Span { speed, speed_error, .. } = spans[joints[0]];
        let speed = speed.max(f64::MIN_POSITIVE);
        let least = (1e-3 * speed).max(10.0 * speed_error);
        let mut shapes = vec![Shape::geometric(least, (0.3 * speed).max(2.0 * least), 12)];
        if form == LEADS {
            shapes.push(Shape {
                low: FRICTION_LEAD[0],
                high: FRICTION_LEAD[1],
                grid: vec![0.005, 0.02],
            });
        }
        shapes
    }

    fn ranges(&self, form: usize, robot: &Robot, joints: &[usize]) -> Vec<[f64; 2]> {
        let velocity = by_kind(robot, joints[0], SMOOTHING_RAD, SMOOTHING_M);
        match form {
            LEADS => vec![velocity, FRICTION_LEAD],
            _ => vec![velocity],
        }
    }

    fn is_friction(&self, _form: usize) -> bool {
        true
    }

    fn columns(&self, form: usize, scene: &Scene, joints: &[usize], shape: &[f64]) -> Vec<Column> {
        let lead = if form == LEADS { shape[1] } else { 0.0 };
        let missing = |[_, v, a]: [f64; 3]| smooth(form, (v + lead * a) / shape[0]) - scene.sign(v);
        vec![own_joint(scene, joints[0], missing)]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let (c, s) = (&w.coefficients[0], &w.shape);
        w.on_own_joint(|[_, v, a]| {
            let smooth = match w.form {
                0 => format!("tanh({v} / {})", s[0]),
                1 => format!("clamp({v} / {})", s[0]),
                _ => format!("clamp(({v} + {} * {a}) / {})", s[1], s[0]),
            };
            format!("{c} * ({smooth} - sign({v}))")
        })
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
        if form == LEADS {
            list.push(ParameterInfo::new("lead", "s"));
        }
        list
    }
}
