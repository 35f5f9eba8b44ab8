//! Data faults are named as such, on three robots, and no physics is blamed for them.

use crate::bench::*;
use dynident::diagnosis::{
    DataFault, DiagnosisOptions, FaultKind, Finding, RawLog, Remedy, column_faults, diagnose, leave_out, lost_rows, sample_faults,
};
use dynident::model::Robot;
use dynident::preparation::{Log, PreprocessOptions, prepare};
use dynident::regression::Stretch;
use dynident::simulate::{HiddenEffect, LogFault, RecordedLog, corrupt};

/// A log with its faults.
struct Examined {
    faults: Vec<DataFault>,
    /// Without the spoiled rows, signs turned round.
    stretch: Stretch,
}

/// What an identification does with a log: faults of the samples, what they spoil left out, faults of the columns.
fn examined(robot: &Robot, recorded: &RecordedLog) -> Examined {
    let raw = RawLog {
        time: recorded.time.clone(),
        q: recorded.q.clone(),
        tau: recorded.tau.clone(),
    };
    let mut faults = sample_faults(robot, &raw);
    let mut log = Log {
        name: "log".into(),
        rate_hz: RATE,
        start_s: 0.0,
        q: raw.q.clone(),
        qd: None,
        tau: raw.tau.clone(),
        usable: vec![true; raw.q[0].len()],
        channels: Vec::new(),
    };
    leave_out(&mut log, &lost_rows(&raw));
    let prepared = prepare(&log, robot.joint_count(), &PreprocessOptions::default()).unwrap();
    faults.extend(column_faults(robot, &prepared.motion, &prepared.torque));
    let mut stretch = Stretch::new(&prepared, &log);
    for (j, joint) in robot.joints().iter().enumerate() {
        if faults
            .iter()
            .any(|f| f.remedy == Remedy::Turn && f.joints.contains(&joint.name))
        {
            let periods = stretch.periods.iter_mut().map(|p| &mut p[j]);
            periods.chain([&mut stretch.torque[j]]).flatten().for_each(|v| *v = -*v);
        }
    }
    Examined { faults, stretch }
}

impl Examined {
    /// The tracing, where anything physical can be said.
    fn findings(&self, robot: &Robot) -> Vec<Finding> {
        if self.faults.iter().any(|f| f.remedy == Remedy::Nothing) {
            return Vec::new();
        }
        diagnose(robot, std::slice::from_ref(&self.stretch), &[], &DiagnosisOptions::default())
            .report
            .findings
    }
}

/// Limits that clip this share of a joint's torque.
fn clip(log: &RecordedLog, joint: usize, share: f64) -> LogFault {
    let mut sizes: Vec<f64> = log.tau[joint].iter().map(|t| t.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let limit = sizes[((1.0 - share) * sizes.len() as f64) as usize];
    LogFault::ClippedTorque { joint, limit }
}

/// The fault on these joints, and nothing else, is said of the log.
fn named(robot: &Robot, log: &RecordedLog, fault: &LogFault, kind: FaultKind, joints: &[usize]) -> Examined {
    let mut bad = log.clone();
    corrupt(&mut bad, fault, 1);
    let examined = examined(robot, &bad);
    let found = &examined.faults;
    let names: Vec<&String> = joints.iter().map(|&j| &robot.joints()[j].name).collect();
    let all = |f: &DataFault| names.is_empty() || names.len() == f.joints.len() && names.iter().all(|n| f.joints.contains(n));
    let wanted = found.len() == 1 && found[0].fault == kind && all(&found[0]);
    assert!(wanted, "{}: {fault:?} gives {found:?}", robot.name());
    examined
}

/// And physics is not blamed for it.
fn named_alone(robot: &Robot, log: &RecordedLog, fault: &LogFault, kind: FaultKind, joints: &[usize]) {
    let blamed = named(robot, log, fault, kind, joints).findings(robot);
    assert!(blamed.is_empty(), "{}: {fault:?} is blamed on {blamed:?}", robot.name());
}

#[test]
fn prop_every_fault_is_named_on_every_robot() {
    for robot in robots() {
        let n = robot.joint_count();
        let [log, _] = logs(&robot, &[], &sensor_noise(n), 30);
        let good = examined(&robot, &log);
        assert!(good.faults.is_empty(), "{}: {:?}", robot.name(), good.faults);
        let all: Vec<usize> = (0..n).collect();
        let frozen = LogFault::Frozen {
            start: 12.0,
            duration: 0.5,
        };
        named_alone(
            &robot,
            &log,
            &LogFault::FlippedTorque { joints: vec![1] },
            FaultKind::TorqueSign,
            &[1],
        );
        named_alone(
            &robot,
            &log,
            &LogFault::Degrees { joints: all.clone() },
            FaultKind::UnitMismatch,
            &all,
        );
        named_alone(
            &robot,
            &log,
            &LogFault::SwappedTorques { joints: [1, 2] },
            FaultKind::JointOrder,
            &[1, 2],
        );
        named_alone(
            &robot,
            &log,
            &LogFault::ConstantTorque { joint: 2 },
            FaultKind::BadSamples,
            &[2],
        );
        named_alone(&robot, &log, &clip(&log, 1, 0.2), FaultKind::BadSamples, &[1]);
        named_alone(&robot, &log, &frozen, FaultKind::BadSamples, &[]);
        named_alone(
            &robot,
            &log,
            &LogFault::RepeatedTimes { count: 20 },
            FaultKind::BadSamples,
            &[],
        );
        named_alone(&robot, &log, &LogFault::GarbageRows { count: 5 }, FaultKind::BadSamples, &[]);
    }
}

#[test]
fn prop_column_faults_are_named_on_any_joints() {
    for robot in robots() {
        let n = robot.joint_count();
        let [log, _] = logs(&robot, &[], &sensor_noise(n), 31);
        for j in 0..n {
            named(
                &robot,
                &log,
                &LogFault::FlippedTorque { joints: vec![j] },
                FaultKind::TorqueSign,
                &[j],
            );
        }
        for joints in [vec![0, 2], vec![1, 2, 3], (0..n).collect()] {
            let fault = LogFault::FlippedTorque { joints: joints.clone() };
            named(&robot, &log, &fault, FaultKind::TorqueSign, &joints);
        }
        for joints in [[0, 2], [1, n - 1], [0, n - 1]] {
            named(
                &robot,
                &log,
                &LogFault::SwappedTorques { joints },
                FaultKind::JointOrder,
                &joints,
            );
            named(
                &robot,
                &log,
                &LogFault::SwappedPositions { joints },
                FaultKind::JointOrder,
                &joints,
            );
        }
        named(
            &robot,
            &log,
            &LogFault::Degrees { joints: vec![1] },
            FaultKind::UnitMismatch,
            &[1],
        );
    }
}

#[test]
fn prop_spoiled_samples_are_named_and_left_out() {
    for robot in robots() {
        let n = robot.joint_count();
        let [log, _] = logs(&robot, &[], &sensor_noise(n), 32);
        for joint in [0, 1, n - 1] {
            named_alone(&robot, &log, &clip(&log, joint, 0.01), FaultKind::BadSamples, &[joint]);
        }
        for (start, duration) in [(3.0, 0.1), (27.3, 2.0), (58.0, 5.0)] {
            named_alone(
                &robot,
                &log,
                &LogFault::Frozen { start, duration },
                FaultKind::BadSamples,
                &[],
            );
        }
        named_alone(
            &robot,
            &log,
            &LogFault::GarbageRows { count: 200 },
            FaultKind::BadSamples,
            &[],
        );
    }
}

#[test]
fn prop_an_effect_is_found_beside_a_fault() {
    let robot = seven_axes();
    let spring = HiddenEffect::JointSpring {
        joint: 3,
        stiffness: 1.8,
        rest: 0.2,
    };
    let [log, _] = logs(&robot, &[spring], &sensor_noise(7), 33);
    let faults = [
        LogFault::FlippedTorque { joints: vec![3] },
        LogFault::FlippedTorque { joints: vec![0, 5] },
        clip(&log, 3, 0.02),
        LogFault::Frozen {
            start: 41.0,
            duration: 1.0,
        },
        LogFault::GarbageRows { count: 30 },
    ];
    for fault in faults {
        let mut bad = log.clone();
        corrupt(&mut bad, &fault, 2);
        let examined = examined(&robot, &bad);
        assert_eq!(examined.faults.len(), 1, "{fault:?} gives {:?}", examined.faults);
        let findings = examined.findings(&robot);
        assert_eq!(findings.len(), 1, "{fault:?}: {findings:?}");
        assert_eq!(
            (findings[0].effect.as_str(), findings[0].joints[0].as_str()),
            ("joint_spring", "J4")
        );
        let stiffness = &findings[0].parameters[0];
        // Four standard deviations: one in 16 000 by chance.
        assert!(
            (stiffness.value - 1.8).abs() < 4.0 * stiffness.std_dev,
            "{fault:?}: {stiffness:?}"
        );
    }
}

/// Strong effects bend torques more than a wrong column would leave; none of them is one. A spring pulls like gravity turned
/// round.
#[test]
fn prop_no_effect_is_taken_for_a_wrong_column() {
    let (robot, phi) = published();
    let spring = |joint, stiffness, rest| HiddenEffect::JointSpring { joint, stiffness, rest };
    let springs =
        (0..robot.joint_count()).flat_map(|j| [(0.5, 0.2), (2.0, 0.2), (5.0, -0.4)].map(|(k, rest)| spring(j, k, rest)));
    let others = codes()
        .into_iter()
        .flat_map(|code| [1, 3, 5].map(|j| Hidden::plain(code, j, &robot)))
        .map(|h| h.at(h.largest().min(6.0)));
    for hidden in springs.chain(others) {
        let effects = std::slice::from_ref(&hidden);
        let noise = sensor_noise(robot.joint_count());
        let [log, _] = published_logs(&robot, &phi, [effects, effects], &noise, 5);
        let column = [FaultKind::TorqueSign, FaultKind::JointOrder, FaultKind::UnitMismatch];
        let faults = examined(&robot, &log).faults;
        assert!(faults.iter().all(|f| !column.contains(&f.fault)), "{hidden:?}: {faults:?}");
    }
}
