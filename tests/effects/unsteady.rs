//! Torque that changes while the log runs, whatever the robot does: nothing in the list of effects does that, and it is a
//! remainder.

use crate::bench::*;
use dynident::diagnosis::{Remainder, Verdict};
use dynident::simulate::HiddenEffect;

/// The only remainder: on the third joint, along `variable`, of this size [N·m].
fn is_of_third_joint(remainder: Option<&Remainder>, variable: &str, rms: f64) {
    let rest = remainder.expect("something is left");
    assert_eq!(
        (rest.joints.as_slice(), rest.depends_on.as_slice()),
        (["J3".to_string()].as_slice(), [variable.to_string()].as_slice())
    );
    assert!((rest.rms[0] - rms).abs() < 0.1 * rms, "{} for {rms}", rest.rms[0]);
}

/// A sensor's zero that drifts while it warms up: 1.5 N·m that die out within the log. Its mean is an offset; what goes with time
/// is a remainder, and neither friction that drifts nor a touch.
#[test]
fn prop_a_slow_drift_depends_on_time() {
    let drift = HiddenEffect::TorqueDrift {
        joint: 2,
        torque: 1.5,
        time_constant: 25.0,
    };
    let report = traced(&seven_axes(), &[drift], &sensor_noise(7), 1).report;
    let found: Vec<(&str, &str)> = report
        .findings
        .iter()
        .map(|f| (f.effect.as_str(), f.joints[0].as_str()))
        .collect();
    assert_eq!(found, [("torque_offset", "J3")]);
    assert_eq!(report.verdict, Verdict::PartlyExplained);
    // Mean and deviation of exp(−t/25 s) over 60 s are 0.379 and 0.251.
    let offset = &report.findings[0].parameters[0];
    assert!((offset.value - 0.568).abs() < 0.03, "{offset:?}");
    is_of_third_joint(report.remainder.as_ref(), "time", 0.3765);
    assert!(report.remainder.as_ref().unwrap().predicted_share > 0.95);
    // What nothing explains stays in the error, and out of the noise floor.
    let left = report.rms_after.identification[2];
    assert!((report.noise_floor[2] - 0.2).abs() < 0.01, "{:?}", report.noise_floor);
    assert!((left - 0.2f64.hypot(0.3765)).abs() < 0.02, "{left}");
}

/// Another level in every period, in no order: six touches as long as a period each would say the same, and nobody touches a
/// robot like that.
#[test]
fn prop_levels_in_no_order_depend_on_the_period() {
    let levels = [0.5, -0.5, 0.4, -0.4, 0.6, -0.6];
    let touch = |(p, level): (usize, &f64)| HiddenEffect::ExternalContact {
        start: 10.0 * p as f64,
        end: 10.0 * (p + 1) as f64,
        torque: (0..7).map(|j| if j == 2 { *level } else { 0.0 }).collect(),
    };
    let hidden: Vec<HiddenEffect> = levels.iter().enumerate().map(touch).collect();
    let report = traced(&seven_axes(), &hidden, &sensor_noise(7), 2).report;
    assert!(report.findings.is_empty(), "{:?}", report.findings);
    assert_eq!(report.verdict, Verdict::Unexplained);
    is_of_third_joint(report.remainder.as_ref(), "period", 0.507);
}

/// Without periods the drift is slower than what the motion brings about; and where there is none, none is reported.
#[test]
fn prop_a_drift_is_seen_without_periods_too() {
    let robot = seven_axes();
    for seed in 3..6 {
        let nothing = once(&robot, &[], &sensor_noise(7), seed).report.remainder;
        assert!(nothing.is_none(), "seed {seed}: {nothing:?}");
    }
    let drift = HiddenEffect::TorqueDrift {
        joint: 2,
        torque: 1.5,
        time_constant: 25.0,
    };
    let rest = once(&robot, &[drift], &sensor_noise(7), 3)
        .report
        .remainder
        .expect("something is left");
    assert_eq!(
        (rest.joints.as_slice(), rest.depends_on.as_slice()),
        (["J3".to_string()].as_slice(), ["time".to_string()].as_slice())
    );
}

/// A gear that warms up, on a log without periods: "nothing is missing" was said beside seven times the noise.
#[test]
fn prop_friction_that_changes_is_seen_without_periods_too() {
    for (robot, joint) in [(six_axes(), 2), (seven_axes(), 3)] {
        for seed in 3..6 {
            let drift = HiddenEffect::FrictionDrift {
                joint,
                viscous: 0.5,
                coulomb: 0.5,
                time_constant: 20.0,
            };
            let report = once(&robot, &[drift], &sensor_noise(robot.joint_count()), seed).report;
            let rest = report.remainder.expect("something is left");
            let expected = ["time".to_string(), format!("qd{}", joint + 1)];
            assert_eq!(
                (rest.joints.as_slice(), rest.depends_on.as_slice()),
                ([format!("J{}", joint + 1)].as_slice(), expected.as_slice()),
                "{} seed {seed}: {rest:?}",
                robot.name()
            );
            assert_eq!(report.verdict, Verdict::Unexplained, "{} seed {seed}", robot.name());
        }
    }
}
