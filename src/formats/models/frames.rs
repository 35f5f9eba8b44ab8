//! Frames, names and numbers of a robot as XML descriptions have them.

use crate::model::Robot;
use crate::spatial::Transform;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::f64::consts::PI;

/// Joint frames as the description has them: pose in the frame before, and the joint's axis.
pub(crate) struct Described {
    pub pose: Transform,
    pub axis: Vector3<f64>,
    pub turn: Matrix3<f64>,
}

pub(crate) fn described(robot: &Robot) -> Vec<Described> {
    let mut before = Matrix3::identity();
    robot
        .joints()
        .iter()
        .map(|joint| {
            let turn = joint.description_frame;
            let pose = Transform::from_rotation(before) * joint.placement * Transform::from_rotation(turn.transpose());
            before = turn;
            Described {
                pose,
                axis: turn * Vector3::z(),
                turn,
            }
        })
        .collect()
}

/// Roll, pitch, yaw with `R = Rz(yaw) Ry(pitch) Rx(roll)`.
pub(crate) fn roll_pitch_yaw(r: &Matrix3<f64>) -> [f64; 3] {
    let across = r[(0, 0)].hypot(r[(1, 0)]);
    let pitch = (-r[(2, 0)]).atan2(across);
    // Straight up or down yaw and roll turn about the same line: all of it is given to yaw.
    if across < 1e-9 {
        return [0.0, pitch, (-r[(0, 1)]).atan2(r[(1, 1)])];
    }
    [r[(2, 1)].atan2(r[(2, 2)]), pitch, r[(1, 0)].atan2(r[(0, 0)])]
}

/// Gravity in the root frame of the file that `urdf` writes [m/s²]: URDF has none of its own, and every simulator lets it point
/// along −z.
pub fn urdf_gravity(robot: &Robot) -> Vector3<f64> {
    Vector3::new(0.0, 0.0, -robot.gravity().norm())
}

/// The turn from the base frame to one in which gravity points along −z; `None` where it does already, or there is none.
pub(crate) fn mounting(robot: &Robot) -> Option<Matrix3<f64>> {
    let (gravity, down) = (robot.gravity(), urdf_gravity(robot));
    // Rounding of a vector that was normalised is no other mounting.
    if (gravity - down).norm() <= 1e-12 * gravity.norm() {
        return None;
    }
    // Straight up every half turn about a level axis is as good: about x.
    let turn = Rotation3::rotation_between(&gravity, &down);
    Some(
        turn.unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), PI))
            .into_inner(),
    )
}

/// A name that no link has.
pub(crate) fn base_name(robot: &Robot) -> String {
    free_name(robot, "base_link")
}

/// `wanted`, lengthened until no link has that name.
pub(super) fn free_name(robot: &Robot, wanted: &str) -> String {
    let mut name = wanted.to_string();
    while robot.joints().iter().any(|j| j.link_name == name) {
        name.push('_');
    }
    name
}

/// Shortest text that reads back as the same number.
pub(crate) fn number(v: f64) -> String {
    match v.abs() {
        // Written out, these have up to three hundred digits.
        size if size != 0.0 && !(1e-6..1e16).contains(&size) => format!("{v:e}"),
        _ => format!("{v}"),
    }
}

pub(crate) fn triple(v: &[f64]) -> String {
    v.iter().map(|&x| number(x)).collect::<Vec<_>>().join(" ")
}
