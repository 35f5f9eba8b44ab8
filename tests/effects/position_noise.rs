//! Noise of positions bends parameters alike in every period, and shows in no scatter of the torques.

use crate::bench::*;
use dynident::preparation::Period;
use dynident::simulate::Noise;

/// Nothing is found on twelve logs each of two arms, and deviations are calibrated.
fn assert_calibrated(position: f64, period: Period) {
    for robot in [six_axes(), seven_axes()] {
        let noise = Noise {
            position,
            ..sensor_noise(robot.joint_count())
        };
        let rms = calibration(&robot, &noise, period, 40..52, |log| log);
        println!("{}, {position} rad, {period:?}: {rms:.3}", robot.name());
        assert!(
            (0.8..1.25).contains(&rms),
            "{}, {position} rad, {period:?}: {rms}",
            robot.name()
        );
    }
}

/// Noise of a resolver, and forty times that of a good encoder.
#[test]
fn prop_deviations_with_noise_of_positions_are_calibrated() {
    assert_calibrated(2e-4, Period::Detect);
    assert_calibrated(1e-3, Period::Detect);
}

#[test]
fn prop_deviations_with_noise_of_positions_without_periods_are_calibrated() {
    assert_calibrated(2e-4, Period::None);
    assert_calibrated(1e-3, Period::None);
}
