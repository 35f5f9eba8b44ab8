//! Friction that builds up over a distance after reversal instead of jumping.

use super::ranges::{PRESLIDING_WIDTH_M, PRESLIDING_WIDTH_RAD, by_kind};
use super::{About, Column, Effect, ParameterInfo, PlotVariable, Reads, Scene, Shape, Span};
use crate::model::Robot;

/// `tau_j += F (z − sign qd)` with Dahl's state `dz/dq = (1 − z sign qd)/w`, w the width [rad or m].
///
/// With the declared Coulomb friction at the same level F the sum is F z: the state takes the place of the sign. In quasi-static
/// motion LuGre's bristles follow the same equation.
pub struct PreslidingHysteresis;

impl Effect for PreslidingHysteresis {
    fn code(&self) -> &'static str {
        "presliding_hysteresis"
    }

    fn about(&self) -> About {
        About {
            name: "Presliding hysteresis",
            phrase: "presliding friction hysteresis",
            meaning: "Elastic deformation of the contacts before sliding: after a reversal, friction builds up over a small displacement.",
            over: PlotVariable::Position,
            identifiable: "when the joint reverses during the motion and the width is above the travel between two samples",
            rivals: &["stribeck_friction", "nonlinear_viscous_friction", "joint_spring"],
            source: "Dahl 1968; Canudas de Wit et al. 1995 (LuGre)",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Course
    }

    fn shapes(&self, _form: usize, joints: &[usize], spans: &[Span]) -> Vec<Shape> {
        let span = spans[joints[0]];
        // Narrower than a fiftieth of the travel per sample at top speed it is a jump; wider than the range it never slides.
        let narrow = (0.02 * span.speed * span.interval)
            .max(1e-5 * span.range)
            .max(f64::MIN_POSITIVE);
        vec![Shape::geometric(narrow, span.range.max(2.0 * narrow), 18)]
    }

    fn ranges(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<[f64; 2]> {
        vec![by_kind(robot, joints[0], PRESLIDING_WIDTH_RAD, PRESLIDING_WIDTH_M)]
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], shape: &[f64]) -> Vec<Column> {
        let j = joints[0];
        let z = dahl_state(scene, j, shape[0]);
        let values = z.iter().zip(scene.motion.velocities(j)).map(|(z, &v)| z - scene.sign(v));
        vec![Column::on(j, values.collect())]
    }

    fn positive(&self, _form: usize) -> &'static [usize] {
        &[0]
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let joint = &robot.joints()[joints[0]];
        vec![
            ParameterInfo::new("amplitude", joint.effort_unit()),
            ParameterInfo::new("width", joint.position_unit()),
        ]
    }
}

/// The state over the samples: exact between samples that lie on the same side of a reversal, `z → s + (z − s) exp(−|Δq|/w)`.
///
/// A step across a reversal is taken in two: to the turning point (where the cubic through both ends' positions and velocities
/// has its extremum, here by the two velocities) and back. Periodic motions are run through twice so that the start has been
/// forgotten.
fn dahl_state(scene: &Scene, joint: usize, width: f64) -> Vec<f64> {
    let (q, qd) = (scene.motion.positions(joint), scene.motion.velocities(joint));
    let n = q.len();
    let mut z = qd.iter().find(|v| **v != 0.0).map_or(0.0, |v| v.signum());
    let mut states = vec![z; n];
    for round in 0..if scene.periodic { 2 } else { 1 } {
        for s in 0..n {
            let before = match s {
                0 if round == 0 => continue,
                0 => n - 1,
                _ => s - 1,
            };
            z = dahl_step(z, [q[before], qd[before]], [q[s], qd[s]], scene.interval, width);
            states[s] = z;
        }
    }
    states
}

fn dahl_step(z: f64, [q0, v0]: [f64; 2], [q1, v1]: [f64; 2], interval: f64, width: f64) -> f64 {
    let slide = |z: f64, distance: f64| {
        let s = distance.signum();
        if distance == 0.0 {
            z
        } else {
            s + (z - s) * (-distance.abs() / width).exp()
        }
    };
    if v0 * v1 >= 0.0 {
        return slide(z, q1 - q0);
    }
    // Constant acceleration between the two: the turning point lies v0²/(2 a) ahead, and the way back is v1²/(2 a).
    let acceleration = (v1 - v0) / interval;
    slide(slide(z, -0.5 * v0 * v0 / acceleration), 0.5 * v1 * v1 / acceleration)
}
