//! Angles and lengths as files have them: rounded.
//!
//! Vendors publish quarter turns as 3.1416, 1.57079 or 3.14. Taken as written, axes that are parallel are not, quite: parameters
//! that the arm can never show become base parameters, and the condition number grows by orders of magnitude. So an angle that is
//! a rounded quarter turn is read as the quarter turn.

use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Whether numbers are read as they were meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rounding {
    /// Rounded quarter turns are quarter turns.
    #[default]
    Meant,
    /// To the last digit: for what the program itself has written.
    AsWritten,
}

/// Angles this near to a quarter turn (rad) are one: kinematic calibration resolves 1e-4.
const NEAR: f64 = 1e-5;
/// Lengths below this (m) are zero: real geometry starts at micrometres.
const NO_LENGTH: f64 = 1e-6;
/// Changes below this change nothing that is reported: rounding of products of sines and lengths.
const UNNOTICED: f64 = 1e-9;
/// Decimals to which π and its multiples are found rounded or cut off. With more, the difference is below `NEAR`.
const DECIMALS: std::ops::RangeInclusive<i32> = 2..=6;
/// Rounded quarter turns are at most this far off (rad): 2π written as 6.28.
const FARTHEST: f64 = 3.3e-3;
/// Quarter turns either way that are looked at: two full turns.
const MOST_QUARTERS: f64 = 8.0;

/// The multiple of a quarter turn that `angle` (rad) is when read as rounded, `angle` itself where it is none.
fn exact_angle(angle: f64) -> f64 {
    let quarters = (angle / FRAC_PI_2).round();
    let exact = quarters * FRAC_PI_2;
    let off = (angle - exact).abs();
    if quarters.abs() > MOST_QUARTERS || off > FARTHEST || off.is_nan() {
        return angle;
    }
    let rounded = off <= NEAR || DECIMALS.into_iter().any(|d| is_rounding(angle, quarters, d));
    if rounded { exact } else { angle }
}

/// Whether `angle` is so many quarter turns, or so many times half of π, rounded or cut off at `decimals`.
fn is_rounding(angle: f64, quarters: f64, decimals: i32) -> bool {
    let scale = 10f64.powi(decimals);
    let forms = |v: f64| [(v * scale).round() / scale, (v * scale).trunc() / scale];
    let of_turn = forms(quarters * FRAC_PI_2);
    let of_pi = forms(PI).map(|p| 0.5 * quarters * p);
    // 1e-12: rounding of the division and of the text.
    of_turn.iter().chain(&of_pi).any(|v| (angle - v).abs() < 1e-12)
}

/// What was changed in reading, in words; `None` where nothing was that anybody would notice.
fn change(name: &str, written: f64, read: f64) -> Option<String> {
    ((written - read).abs() > UNNOTICED).then(|| match read {
        0.0 => format!("{name} {written} is read as 0"),
        _ => {
            let quarters = (read / FRAC_PI_2).round() as i64;
            let turn = match quarters {
                1 | -1 => "a quarter turn".to_string(),
                2 | -2 => "a half turn".to_string(),
                4 | -4 => "a full turn".to_string(),
                n => format!("{} quarter turns", n.abs()),
            };
            format!("{name} {written} is read as {turn} ({read})")
        }
    })
}

impl Rounding {
    /// An angle, and what was changed about it.
    pub fn angle(self, name: &str, written: f64) -> (f64, Option<String>) {
        match self {
            Self::AsWritten => (written, None),
            Self::Meant => {
                let read = exact_angle(written);
                (read, change(name, written, read))
            }
        }
    }

    /// A length (m): what is below a micrometre is an error of conversion.
    pub fn length(self, name: &str, written: f64) -> (f64, Option<String>) {
        let is_zero = self == Self::Meant && written.abs() < NO_LENGTH;
        let read = if is_zero { 0.0 } else { written };
        (read, change(name, written, read))
    }

    /// Three angles.
    pub fn angles(self, name: &str, written: Vector3<f64>) -> (Vector3<f64>, Vec<String>) {
        three([0, 1, 2].map(|i| self.angle(name, written[i])))
    }

    /// Three lengths.
    pub fn lengths(self, name: &str, written: Vector3<f64>) -> (Vector3<f64>, Vec<String>) {
        three([0, 1, 2].map(|i| self.length(name, written[i])))
    }

    /// A unit vector.
    pub fn axis(self, written: Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::AsWritten => written,
            Self::Meant => exact_axis(written),
        }
    }

    /// A rotation, of several that were merged.
    pub fn rotation(self, written: Matrix3<f64>) -> Matrix3<f64> {
        match self {
            Self::AsWritten => written,
            Self::Meant => exact_rotation(written),
        }
    }
}

fn three(each: [(f64, Option<String>); 3]) -> (Vector3<f64>, Vec<String>) {
    let read = Vector3::from_fn(|i, _| each[i].0);
    (read, each.into_iter().filter_map(|e| e.1).collect())
}

/// A unit vector without the components that are errors of conversion.
fn exact_axis(axis: Vector3<f64>) -> Vector3<f64> {
    axis.map(|v| if v.abs() < NEAR { 0.0 } else { v }).normalize()
}

/// A rotation with every axis along an axis of the other frame where it is nearly so.
fn exact_rotation(rotation: Matrix3<f64>) -> Matrix3<f64> {
    let near_whole = |v: &f64| v.abs() < NEAR || (v.abs() - 1.0).abs() < NEAR;
    match rotation.iter().all(near_whole) {
        true => rotation.map(f64::round),
        false => rotation,
    }
}

#[cfg(test)]
// Rounded multiples of π are what is tested.
#[allow(clippy::approx_constant)]
mod tests {
    use super::*;

    #[test]
    fn rounded_quarter_turns_are_read_as_quarter_turns() {
        for (written, quarters) in [
            (3.1416, 2.0),
            (3.1415, 2.0),
            (3.14159, 2.0),
            (3.14, 2.0),
            (3.142, 2.0),
            (1.57079, 1.0),
            (1.5708, 1.0),
            (-1.571, -1.0),
            (1.57, 1.0),
            (1.5707, 1.0),
            (-1.570_796_3, -1.0),
            (1.570_796_370_506_286_6, 1.0),
            (0.5 * 3.14159, 1.0),
            (1.5 * 3.1416, 3.0),
            (4.71, 3.0),
            (4.712, 3.0),
            (6.28, 4.0),
            (-6.2832, -4.0),
            (2.7e-18, 0.0),
            (-3e-6, 0.0),
        ] {
            assert_eq!(exact_angle(written), quarters * FRAC_PI_2, "{written}");
        }
    }

    #[test]
    fn calibrated_and_other_angles_stay_as_they_are() {
        for written in [
            1.570_962, 1.572, 3.1402, 0.785_398, 2.0944, 0.5236, 1.0, 1e-4, -1.5692, 3.1, 20.42, 1e300,
        ] {
            assert_eq!(exact_angle(written), written);
        }
        assert!(exact_angle(f64::NAN).is_nan());
    }

    #[test]
    fn rotations_and_axes_are_exact_where_they_are_meant_to_be() {
        let nearly = Vector3::new(0.0, -4.9e-12, 1.0);
        assert_eq!(exact_axis(nearly), Vector3::z());
        let turn = nalgebra::Rotation3::from_euler_angles(1.570_795, 0.0, 0.0).into_inner();
        assert_eq!(
            exact_rotation(turn),
            Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0)
        );
        let tilted = nalgebra::Rotation3::from_euler_angles(0.3, 0.0, 0.0).into_inner();
        assert_eq!(exact_rotation(tilted), tilted);
    }
}
