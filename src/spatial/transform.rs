//! Rigid transforms between link frames.

use nalgebra::{Matrix3, Vector3};

/// Pose of a frame B in a frame A: `x_A = rotation · x_B + translation` (translation in metres).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Rotation R, 3 × 3.
    pub rotation: Matrix3<f64>,
    /// Translation p (m).
    pub translation: Vector3<f64>,
}

impl Transform {
    /// The transform that changes nothing.
    pub fn identity() -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation: Vector3::zeros(),
        }
    }

    /// Rotation by `angle` (rad) about the x axis.
    pub fn rot_x(angle: f64) -> Self {
        let (s, c) = exact_sin_cos(angle);
        Self::from_rotation(Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c))
    }

    /// Rotation by `angle` (rad) about the y axis.
    pub fn rot_y(angle: f64) -> Self {
        let (s, c) = exact_sin_cos(angle);
        Self::from_rotation(Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c))
    }

    /// Rotation by `angle` (rad) about the z axis.
    pub fn rot_z(angle: f64) -> Self {
        let (s, c) = exact_sin_cos(angle);
        Self::from_rotation(Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0))
    }

    /// Translation by `(x, y, z)` (m).
    pub fn trans(x: f64, y: f64, z: f64) -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation: Vector3::new(x, y, z),
        }
    }

    /// Rotation alone.
    pub fn from_rotation(rotation: Matrix3<f64>) -> Self {
        Self {
            rotation,
            translation: Vector3::zeros(),
        }
    }

    /// URDF's fixed-axis roll, pitch, yaw: `R = Rz(yaw) Ry(pitch) Rx(roll)`, then the offset `xyz` in the parent frame.
    pub fn from_xyz_rpy(xyz: Vector3<f64>, rpy: Vector3<f64>) -> Self {
        let rotation = (Self::rot_z(rpy.z) * Self::rot_y(rpy.y) * Self::rot_x(rpy.x)).rotation;
        Self {
            rotation,
            translation: xyz,
        }
    }

    /// The transform back: `(Rᵀ, −Rᵀ p)`.
    pub fn inverse(&self) -> Self {
        let transposed = self.rotation.transpose();
        Self {
            rotation: transposed,
            translation: -(transposed * self.translation),
        }
    }

    /// The rotation that takes the z axis onto the unit vector `axis`; a signed permutation when `axis` is a coordinate
    /// axis, so that such robots keep exact zeros in their kinematics.
    pub fn z_onto(axis: &Vector3<f64>) -> Matrix3<f64> {
        let smallest = axis.iamin();
        // The coordinate axis farthest from `axis`, made orthogonal to it, becomes x. For z itself that is x, hence the identity.
        let seed = Vector3::from_fn(|i, _| if i == smallest { 1.0 } else { 0.0 });
        let x = (seed - axis * axis.dot(&seed)).normalize();
        Matrix3::from_columns(&[x, axis.cross(&x), *axis])
    }
}

impl std::ops::Mul for Transform {
    type Output = Transform;

    fn mul(self, other: Transform) -> Transform {
        Transform {
            rotation: self.rotation * other.rotation,
            translation: self.rotation * other.translation + self.translation,
        }
    }
}

/// Sine and cosine in which multiples of a quarter turn are exact: `cos(π/2)` is 0, not 6e-17. The angles of real arms
/// are quarter turns, and base-parameter expressions read `MZ3`, not `MZ3 + 6e-17 MY3`, because of this.
///
/// Robot descriptions round the quarter turn to four decimals and more (`1.5708` is 3.7e-6 off), so anything nearer than
/// 5e-6 rad counts as one: 5 µm at the end of a metre, far below what an arm is built or calibrated to.
fn exact_sin_cos(angle: f64) -> (f64, f64) {
    const QUARTER_TURN: f64 = std::f64::consts::FRAC_PI_2;
    const NEAR: f64 = 5e-6;
    let turns = (angle / QUARTER_TURN).round();
    if (angle - turns * QUARTER_TURN).abs() > NEAR {
        return angle.sin_cos();
    }
    match turns.rem_euclid(4.0) as u8 {
        0 => (0.0, 1.0),
        1 => (1.0, 0.0),
        2 => (0.0, -1.0),
        _ => (-1.0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_inverse_undoes_composition() {
        let t = Transform::from_xyz_rpy(Vector3::new(0.1, -0.4, 2.0), Vector3::new(0.3, -1.2, 2.5));
        let product = t * t.inverse();
        // Three-term products of numbers of order one: a few units in the last place.
        assert!((product.rotation - Matrix3::identity()).amax() < 1e-15);
        assert!(product.translation.amax() < 1e-15);
    }

    #[test]
    fn prop_z_onto_is_a_rotation_that_maps_z() {
        for axis in [
            Vector3::x(),
            -Vector3::y(),
            -Vector3::z(),
            Vector3::z(),
            Vector3::new(0.6, 0.0, -0.8),
        ] {
            let r = Transform::z_onto(&axis);
            assert!((r * Vector3::z() - axis).amax() < 1e-15);
            assert!((r.determinant() - 1.0).abs() < 1e-15);
        }
        assert_eq!(Transform::z_onto(&Vector3::z()), Matrix3::identity());
    }
}
