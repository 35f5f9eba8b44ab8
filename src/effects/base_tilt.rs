//! A base that does not stand as the model says.

use super::ranges::TILT;
use super::{About, Effect, EffectKind, ParameterInfo, PlotVariable, Reads, Scene, World};
use crate::model::Robot;
use nalgebra::{Rotation3, Vector3};

/// The base is turned by roll about its x axis, then pitch about y: in its frame gravity is `Rᵀ g` with `R = Ry(pitch) Rx(roll)`.
/// Where gravity points along x or y (an arm on a wall), a turn about that axis is none, and yaw about z takes its place: always
/// the two axes that are not nearest to gravity.
pub struct BaseTilt;

/// Roll, pitch and yaw are turns about x, y and z.
const NAMES: [&str; 3] = ["roll", "pitch", "yaw"];

/// The two axes that the base is turned about, in the order of the turns.
fn axes(gravity: Vector3<f64>) -> [usize; 2] {
    match gravity.iamax() {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

/// Gravity in the frame of the base turned by `angles` (rad), two as the effect has.
pub fn tilted(gravity: Vector3<f64>, angles: &[f64]) -> Vector3<f64> {
    let mut turns = [0.0; 3];
    axes(gravity).iter().zip(angles).for_each(|(&at, &angle)| turns[at] = angle);
    Rotation3::from_euler_angles(turns[0], turns[1], turns[2]).inverse() * gravity
}

impl Effect for BaseTilt {
    fn code(&self) -> &'static str {
        "base_tilt"
    }

    fn about(&self) -> About {
        About {
            name: "Base tilt",
            phrase: "a base tilt",
            meaning: "The base is mounted at another angle to gravity than described.",
            over: PlotVariable::Position,
            identifiable: "on robots whose gravity torques change with the first joints; a turn about gravity itself is never seen",
            rivals: &["torque_offset", "encoder_offset"],
            source: "Swevers, Verdonck & De Schutter 2007",
        }
    }

    fn reads(&self) -> Reads {
        Reads::Arm
    }

    fn kind(&self) -> EffectKind {
        EffectKind::Distortion
    }

    fn places(&self, robot: &Robot) -> Vec<Vec<usize>> {
        if robot.gravity().norm() > 0.0 {
            vec![Vec::new()]
        } else {
            Vec::new()
        }
    }

    fn distort(&self, scene: &Scene, _joints: &[usize], theta: &[f64], world: &mut World) {
        world.gravity = tilted(scene.robot.gravity(), theta);
    }

    fn keeps_motion(&self) -> bool {
        true
    }

    fn turns_gravity(&self) -> bool {
        true
    }

    fn steps(&self) -> &'static [f64] {
        &[1e-7, 1e-7]
    }

    fn ranges(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<[f64; 2]> {
        vec![[-TILT, TILT]; 2]
    }

    fn parameters(&self, _form: usize, robot: &Robot, _joints: &[usize]) -> Vec<ParameterInfo> {
        axes(robot.gravity()).map(|at| ParameterInfo::new(NAMES[at], "rad")).to_vec()
    }
}
