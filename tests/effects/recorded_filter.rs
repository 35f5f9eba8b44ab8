//! Logs that were filtered before they were recorded: fewer rows say something new than there are.

use crate::bench::*;
use dynident::diagnosis::FaultKind;
use dynident::preparation::Period;
use dynident::preparation::filter::{LowPass, Padding, zero_phase};
use dynident::simulate::{Experiment, HiddenEffect, RecordedLog, simulate};

/// Positions and torques through the same zero-phase low-pass, as a controller's smoothed channels.
fn filtered(log: &RecordedLog, order: usize, cutoff_hz: f64) -> RecordedLog {
    let rate = 1.0 / (log.time[1] - log.time[0]);
    let filter = LowPass::butterworth(order, cutoff_hz, rate).unwrap();
    let through = |rows: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let row = |r: &Vec<f64>| zero_phase(&filter, r, Padding::Odd, filter.settling_samples());
        rows.iter().map(row).collect()
    };
    RecordedLog {
        q: through(&log.q),
        tau: through(&log.tau),
        ..log.clone()
    }
}

/// Nothing is found, and deviations are calibrated, behind a filter of this cut-off with this knowledge of the period.
fn assert_calibrated(cutoff_hz: f64, period: Period) {
    for robot in [six_axes(), seven_axes()] {
        let noise = sensor_noise(robot.joint_count());
        let rms = calibration(&robot, &noise, period, 70..82, |log| filtered(&log, 2, cutoff_hz));
        println!("{}, filtered at {cutoff_hz} Hz, {period:?}: {rms:.3}", robot.name());
        assert!((0.8..1.25).contains(&rms), "{}: {rms}", robot.name());
    }
}

#[test]
fn prop_deviations_of_logs_filtered_before_recording_are_calibrated() {
    assert_calibrated(40.0, Period::Detect);
}

#[test]
fn prop_deviations_of_filtered_logs_without_periods_are_calibrated() {
    for cutoff_hz in [12.0, 20.0, 40.0, 60.0] {
        assert_calibrated(cutoff_hz, Period::None);
    }
}

/// Torques as the sensors have them are not said to be filtered: of logs that rest at every way-point, where noise of the speeds
/// makes the predicted friction chatter, with friction in the arm and without, and at every rate.
#[test]
fn prop_no_filter_is_found_where_there_is_none() {
    for (i, robot) in robots().iter().enumerate() {
        for (k, rate_hz) in [50.0, 200.0, 1000.0].into_iter().enumerate() {
            let seed = 10 * i as u64 + k as u64;
            let parameters = match k {
                1 => bodies(robot, seed),
                _ => frictionless_bodies(robot, seed),
            };
            let log = simulate(&Experiment {
                robot,
                parameters: &parameters,
                trajectory: &single_run(robot.joint_count(), seed),
                periods: 1.0,
                rate_hz,
                effects: &[],
                noise: &sensor_noise(robot.joint_count()),
                seed,
            });
            let report = diagnosed(robot, &log, Period::None).report;
            let what = format!("{} at {rate_hz} Hz", robot.name());
            assert!(report.data_faults.is_empty(), "{what}: {:?}", report.data_faults);
            assert!(report.findings.is_empty(), "{what}: {:?}", report.findings);
        }
    }
}

#[test]
fn prop_a_narrow_filter_before_recording_is_no_effect() {
    // Noise behind so narrow a filter is slow, and above a twentieth of a joint's torque it looks like torques that do not
    // repeat: the period is stated.
    let period = Period::Known {
        period_s: 10.0,
        order: None,
    };
    assert_calibrated(10.0, period);
}

/// Forwards alone, as a controller filters while it moves: positions and torques are as late as each other.
fn causally_filtered(log: &RecordedLog, order: usize, cutoff_hz: f64) -> RecordedLog {
    let rate = 1.0 / (log.time[1] - log.time[0]);
    let filter = LowPass::butterworth(order, cutoff_hz, rate).unwrap();
    let section = |x: Vec<f64>, b: [f64; 3], a: [f64; 2]| -> Vec<f64> {
        // In the steady state of the first value.
        let (mut inputs, mut outputs) = ([x[0]; 2], [x[0]; 2]);
        let step = |v: f64| {
            let y = b[0] * v + b[1] * inputs[0] + b[2] * inputs[1] - a[0] * outputs[0] - a[1] * outputs[1];
            (inputs, outputs) = ([v, inputs[0]], [y, outputs[0]]);
            y
        };
        x.into_iter().map(step).collect()
    };
    let row = |r: &Vec<f64>| filter.sections.iter().fold(r.clone(), |x, s| section(x, s.b, s.a));
    RecordedLog {
        q: log.q.iter().map(row).collect(),
        tau: log.tau.iter().map(row).collect(),
        ..log.clone()
    }
}

/// A spring behind filters of several orders, cut-offs and rates is found, with its value and nothing beside it, and the filter
/// is reported.
#[test]
fn prop_a_spring_behind_a_filter_is_found_alone() {
    let robot = four_axes();
    let (joint, stiffness) = (2, 1.2);
    let spring = HiddenEffect::JointSpring {
        joint,
        stiffness,
        rest: 0.1,
    };
    for (rate_hz, order, cutoff_hz, causal) in [
        (200.0, 2, 40.0, false),
        (1000.0, 2, 40.0, false),
        (200.0, 1, 15.0, false),
        (500.0, 4, 25.0, false),
        (200.0, 2, 20.0, true),
        (1000.0, 1, 30.0, true),
    ] {
        let recorded = simulate(&Experiment {
            robot: &robot,
            parameters: &bodies(&robot, 5),
            trajectory: &excitation(4, 5),
            periods: 6.0,
            rate_hz,
            effects: std::slice::from_ref(&spring),
            noise: &sensor_noise(4),
            seed: 5,
        });
        let log = match causal {
            true => causally_filtered(&recorded, order, cutoff_hz),
            false => filtered(&recorded, order, cutoff_hz),
        };
        // As for the narrow filter above.
        let period = Period::Known {
            period_s: 10.0,
            order: None,
        };
        let report = diagnosed(&robot, &log, period).report;
        let what = format!("{rate_hz} Hz behind order {order} at {cutoff_hz} Hz, causal {causal}");
        let found: Vec<_> = report
            .findings
            .iter()
            .map(|f| (&f.effect, &f.joints, &f.parameters))
            .collect();
        println!(
            "{what}: {:?} {found:?}",
            report.data_faults.iter().map(|f| &f.detail).collect::<Vec<_>>()
        );
        assert_eq!(found.len(), 1, "{what}: {found:?}");
        assert!(found[0].0 == "joint_spring" && found[0].1 == &["J3"], "{what}: {found:?}");
        let value = &found[0].2[0];
        assert!((value.value - stiffness).abs() < 4.0 * value.std_dev, "{what}: {value:?}");
        let [fault] = &report.data_faults[..] else {
            panic!("{what}: {:?}", report.data_faults);
        };
        assert_eq!(fault.fault, FaultKind::FilteredTorque);
    }
}
