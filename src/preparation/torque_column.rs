//! What a torque column can say: how finely it was recorded, and whether it says anything of its joint at all.

use crate::model::INPUT_LIMITS;
use serde::Serialize;

/// Why the torque of a joint takes no part in anything that is made from a log.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Exclusion {
    /// Every sample has this value [N m or N]: not connected, or not recorded.
    ConstantTorque(f64),
    /// The largest torque, which no joint of an arm has in N m (N) [N m or N].
    ImplausibleTorque(f64),
    /// The joint does not move: its torque is whatever static friction or a brake holds.
    Still,
}

impl std::fmt::Display for Exclusion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::ConstantTorque(value) => write!(
                f,
                "its torque is constant ({}): not connected, or not recorded",
                short(*value)
            ),
            Self::ImplausibleTorque(largest) => write!(
                f,
                "its torque reaches {} N m (N), which is no torque of a joint: check the column, its unit and scale",
                short(*largest)
            ),
            Self::Still => write!(
                f,
                "its position does not change: it stands still, and its torque is what static friction or a brake holds"
            ),
        }
    }
}

/// Four digits, with a power of ten where the number would be long.
fn short(value: f64) -> String {
    match value.abs() {
        size if size == 0.0 || (1e-3..1e6).contains(&size) => format!("{}", (value * 1e4).round() / 1e4),
        size if size.is_finite() => format!("{value:.3e}"),
        _ => "more than 1e308".into(),
    }
}

/// Largest torques that joints have: from far below what a watch needs to far above what the largest crane lifts [N m or N].
const PLAUSIBLE: std::ops::Range<f64> = 1e-9..INPUT_LIMITS.measured_torque;

/// A column whose largest torque is below this part of the largest of all joints is rounding beside them: torque channels resolve
/// 24 bits (6e-8) at best.
const LEAST_SHARE: f64 = 1e-9;

/// A spread below this part of the value is rounding of one number.
const SAME: f64 = 1e-12;

/// Why each joint's torque is to be left out, by the samples that are data. `still` are joints that do not move.
pub(crate) fn exclusions(torque: &[Vec<f64>], usable: &[bool], still: &[bool]) -> Vec<Option<Exclusion>> {
    let ranges: Vec<[f64; 2]> = torque.iter().map(|tau| range(tau, usable)).collect();
    let size = |[low, high]: [f64; 2]| low.abs().max(high.abs());
    // What is no torque itself is no measure for the others.
    let all = ranges.iter().map(|r| size(*r)).filter(|s| *s < PLAUSIBLE.end);
    let largest = all.fold(0.0, f64::max);
    let one = |(&[low, high], &still): (&[f64; 2], &bool)| {
        let size = size([low, high]);
        if size.is_infinite() {
            Some(Exclusion::ImplausibleTorque(size))
        } else if high - low <= SAME * size {
            Some(Exclusion::ConstantTorque(0.5 * low + 0.5 * high))
        } else if !PLAUSIBLE.contains(&size) || size < LEAST_SHARE * largest {
            Some(Exclusion::ImplausibleTorque(size))
        } else {
            still.then_some(Exclusion::Still)
        }
    };
    ranges.iter().zip(still).map(one).collect()
}

/// Lowest and highest value of the samples that are data; zeros where there is none. What is no number (the sum of infinities) is
/// beyond all of them.
fn range(column: &[f64], usable: &[bool]) -> [f64; 2] {
    let number = |v: &f64| if v.is_nan() { f64::INFINITY } else { *v };
    let values = column.iter().zip(usable).filter(|(_, u)| **u).map(|(v, _)| number(v));
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
    if low <= high { [low, high] } else { [0.0; 2] }
}

/// Steps finer than this part of the largest value are not looked for: torque channels resolve 24 bits (6e-8) at best, and the
/// multiples of finer steps are lost in the rounding of doubles.
const FINEST: f64 = 1e-7;

/// A remainder below this part of a step is the rounding of decimals: a column of 1e7 steps holds them to 1e-9 of its largest
/// value, a hundredth of a step.
const ROUNDING: f64 = 0.01;

/// Standard deviation that recording has added to a column: `d/√12` for values that are whole multiples of d (decimals of a file,
/// counts of a converter), and that of the finest step where there is none to be seen. No noise floor is below it.
pub(crate) fn resolution(column: &[f64], usable: &[bool]) -> f64 {
    let finest = finest(column, usable);
    common_step(column, usable, finest).unwrap_or(finest) / 12f64.sqrt()
}

/// The step that all values of a column are multiples of; `None` where there is none to be seen.
pub(crate) fn step_of(column: &[f64], usable: &[bool]) -> Option<f64> {
    common_step(column, usable, finest(column, usable))
}

/// Finest step that is looked for in a column.
fn finest(column: &[f64], usable: &[bool]) -> f64 {
    let [low, high] = range(column, usable);
    FINEST * low.abs().max(high.abs())
}

/// Variance of rounding to steps `d` that the mean over repetitions keeps, where each is measured with noise of standard
/// deviation `noise`. Without noise every repetition is rounded alike, `d²/12`; noise smooths the steps, and of that
/// `exp(−4π² σ²/d²)` remains (Widrow & Kollár, Quantization Noise, 2008).
pub(crate) fn rounded_alike(step: f64, noise: f64) -> f64 {
    if step <= 0.0 {
        return 0.0;
    }
    step * step / 12.0 * (-(std::f64::consts::TAU * noise / step).powi(2)).exp()
}

/// Greatest common divisor of the differences of all values; `None` where it is below `finest`.
fn common_step(column: &[f64], usable: &[bool], finest: f64) -> Option<f64> {
    let mut values = column.iter().zip(usable).filter(|(_, u)| **u).map(|(v, _)| *v);
    let first = values.next()?;
    let mut step = 0.0;
    for value in values.filter(|v| *v != first) {
        step = divisor((value - first).abs(), step);
        if step <= finest {
            return None;
        }
    }
    (step > finest).then_some(step)
}

/// Euclid's algorithm, with nearest multiples; a where b is zero. Where a is a multiple of b, it says more closely what b is:
/// rounding of a is divided by many.
fn divisor(mut a: f64, mut b: f64) -> f64 {
    while b > 0.0 {
        let count = (a / b).round();
        let rest = (a - count * b).abs();
        if rest <= ROUNDING * b {
            return if count > 1.0 { a / count } else { b };
        }
        (a, b) = (b, rest);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(scale: f64) -> Vec<f64> {
        (0..500)
            .map(|s| scale * (3.0 * (0.07 * s as f64).sin() + (0.313 * s as f64).cos()))
            .collect()
    }

    #[test]
    fn prop_steps_of_decimals_and_converters_are_found_at_any_scale() {
        for scale in [1e-6, 1.0, 37.0, 1e6] {
            for step in [1e-5 * scale, 4.0 / 4096.0 * scale, 0.1 * scale] {
                let column: Vec<f64> = wave(scale).iter().map(|v| (v / step).round() * step).collect();
                let found = resolution(&column, &[true; 500]) * 12f64.sqrt();
                assert!((found / step - 1.0).abs() < 1e-6, "{found} for {step}");
            }
            let smooth = resolution(&wave(scale), &[true; 500]);
            assert!(smooth < 1e-6 * scale, "{smooth} at {scale}");
        }
    }

    #[test]
    fn prop_columns_that_are_no_torque_are_excluded_at_any_scale_of_the_others() {
        for scale in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
            let endless = wave(1.0).iter().map(|v| if *v > 2.0 { f64::INFINITY } else { *v }).collect();
            let none = wave(1.0).iter().map(|v| if *v > 2.0 { f64::NAN } else { *v }).collect();
            for odd in [
                wave(1e-150),
                wave(1e150),
                vec![0.0; 500],
                vec![2.5; 500],
                vec![-1e150; 500],
                vec![f64::INFINITY; 500],
                endless,
                none,
            ] {
                let torque = [wave(scale), odd, wave(0.01 * scale)];
                let found = exclusions(&torque, &[true; 500], &[false, false, true]);
                assert_eq!(found[0], None, "{scale}");
                assert!(matches!(
                    found[1],
                    Some(Exclusion::ConstantTorque(_) | Exclusion::ImplausibleTorque(_))
                ));
                assert_eq!(found[2], Some(Exclusion::Still));
            }
        }
    }
}
