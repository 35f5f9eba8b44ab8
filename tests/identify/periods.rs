//! Finding and cutting periods.

use crate::simulated::{TORQUE_NOISE, Virtual, excitation, noisy, way_points};
use dynident::preparation::{Log, Period, PreprocessOptions, detect_period, prepare};

fn stay(log: &Log, samples: usize) -> Log {
    let mut late = log.clone();
    late.q.iter_mut().chain(&mut late.tau).for_each(|x| {
        let first = x[0];
        x.splice(0..0, std::iter::repeat_n(first, samples));
    });
    late.usable = vec![true; log.samples() + samples];
    late
}

#[test]
fn prop_the_period_is_found_to_a_fraction_of_a_sample() {
    let robot = Virtual::iiwa14();
    for (period_s, rate_hz) in [(10.0, 200.0), (7.3333, 100.0), (12.567, 250.0)] {
        let log = noisy(&robot.clean(&excitation(6, period_s), rate_hz, 4), 1e-4, &TORQUE_NOISE, 1);
        let found = detect_period(&log).unwrap();
        assert!((found - period_s).abs() * rate_hz < 0.05, "{found} for {period_s}");
    }
}

#[test]
fn prop_a_motion_that_never_repeats_has_no_period() {
    let robot = Virtual::iiwa14();
    let log = noisy(&robot.clean(&way_points(1), 200.0, 1), 1e-4, &TORQUE_NOISE, 1);
    assert_eq!(detect_period(&log), None);
    let once = noisy(&robot.clean(&excitation(6, 10.0), 200.0, 1), 1e-4, &TORQUE_NOISE, 1);
    assert_eq!(detect_period(&once), None);
}

#[test]
fn prop_a_robot_that_starts_late_loses_no_whole_period() {
    let robot = Virtual::iiwa14();
    let running = robot.clean(&excitation(7, 10.0), 100.0, 4);
    for wait in [0, 37, 250] {
        let log = noisy(&stay(&running, wait), 1e-5, &TORQUE_NOISE, 3);
        let prepared = prepare(&log, 7, &PreprocessOptions::default()).unwrap();
        let periods = prepared.periods.as_ref().unwrap();
        assert_eq!((periods.count, periods.samples), (4, 1000), "wait {wait}");
        // The smoothing over a hundredth of the period blurs the start by that much.
        assert!(periods.first.abs_diff(wait) <= 10, "wait {wait}, first {}", periods.first);
    }
}

#[test]
fn prop_partial_periods_at_both_ends_are_left_out() {
    let robot = Virtual::iiwa14();
    let long = robot.clean(&excitation(8, 10.0), 100.0, 5);
    let log = noisy(&long.slice(310..4700), 1e-5, &TORQUE_NOISE, 3);
    let prepared = prepare(&log, 7, &PreprocessOptions::default()).unwrap();
    assert_eq!(prepared.periods.as_ref().unwrap().count, 4);
    assert_eq!(prepared.samples(), 1000);
}

#[test]
fn prop_a_stated_period_that_the_log_does_not_hold_is_refused() {
    let robot = Virtual::iiwa14();
    let log = robot.clean(&excitation(8, 10.0), 100.0, 1);
    let options = PreprocessOptions {
        period: Period::Known {
            period_s: 25.0,
            order: None,
        },
        ..Default::default()
    };
    let error = prepare(&log, 7, &options).unwrap_err().to_string();
    assert!(
        error.contains("no whole period of 25 s") && error.contains("check the period"),
        "{error}"
    );
    let options = PreprocessOptions {
        period: Period::Known {
            period_s: f64::NAN,
            order: None,
        },
        ..Default::default()
    };
    assert!(prepare(&log, 7, &options).is_err());
}
