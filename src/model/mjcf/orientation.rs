//! Orientations in the five ways in which MJCF states them.

use super::Compiler;
use crate::spatial::Transform;
use nalgebra::{Matrix3, Quaternion, Rotation3, Unit, UnitQuaternion, Vector3};

/// Attributes that state an orientation, and how many numbers each has.
pub(super) const ORIENTATIONS: [(&str, usize); 5] = [("quat", 4), ("axisangle", 4), ("euler", 3), ("xyaxes", 6), ("zaxis", 3)];

/// Rotation from the numbers of one of [`ORIENTATIONS`]; `None` where they have no direction.
pub(super) fn rotation(attribute: &str, v: &[f64], compiler: &Compiler) -> Option<Matrix3<f64>> {
    let direction = |v: &[f64]| Unit::try_new(Vector3::from_column_slice(v), 1e-9);
    let rounding = compiler.rounding;
    let written = match attribute {
        "quat" => {
            let quaternion = UnitQuaternion::try_new(Quaternion::new(v[0], v[1], v[2], v[3]), 1e-9)?;
            quaternion.to_rotation_matrix().into_inner()
        }
        "axisangle" => {
            let angle = rounding.angle("angle", v[3] * compiler.angle).0;
            Rotation3::from_axis_angle(&direction(&v[..3])?, angle).into_inner()
        }
        "euler" => compiler
            .euler
            .iter()
            .zip(v)
            .fold(Matrix3::identity(), |so_far, (axis, angle)| {
                let angle = rounding.angle("euler", angle * compiler.angle).0;
                let turn = match axis.to_ascii_lowercase() {
                    'x' => Transform::rot_x(angle),
                    'y' => Transform::rot_y(angle),
                    _ => Transform::rot_z(angle),
                };
                // Small letters turn with the body, capitals about fixed axes.
                match axis.is_ascii_lowercase() {
                    true => so_far * turn.rotation,
                    false => turn.rotation * so_far,
                }
            }),
        "xyaxes" => {
            let x = direction(&v[..3])?;
            let y = Vector3::from_column_slice(&v[3..]);
            let y = Unit::try_new(y - *x * x.dot(&y), 1e-9)?;
            Matrix3::from_columns(&[*x, *y, x.cross(&y)])
        }
        // The shortest turn that brings z there.
        _ => Rotation3::rotation_between(&Vector3::z(), direction(v)?.as_ref())
            .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
            .into_inner(),
    };
    Some(rounding.rotation(written))
}
