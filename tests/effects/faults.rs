//! Data faults are named as such, on three robots.

use crate::bench::*;
use dynident::dynamics::Motion;
use dynident::residual::{DataFault, FaultKind, RawLog, column_faults, sample_faults};
use dynident::simulate::{LogFault, RecordedLog, corrupt};

/// Faults of the samples, then of the columns along the motion that the positions say.
fn faults(robot: &dynident::model::Robot, log: &RecordedLog) -> Vec<DataFault> {
    let raw = RawLog {
        time: log.time.clone(),
        q: log.q.clone(),
        tau: log.tau.clone(),
    };
    let mut found = sample_faults(robot, &raw);
    if found.is_empty() {
        let prepared = stretch(log, "log");
        let motion = Motion::from_fn(robot.joint_count(), prepared.motion.samples() / 4, |j, s| {
            prepared.motion.get(j, 4 * s)
        });
        let torque: Vec<Vec<f64>> = prepared
            .torque
            .iter()
            .map(|t| t.iter().step_by(4).copied().collect())
            .collect();
        found = column_faults(robot, &motion, &torque);
    }
    found
}

#[test]
fn prop_every_fault_is_named() {
    let cases = [
        (LogFault::FlippedTorque { joints: vec![1] }, FaultKind::TorqueSign),
        (
            LogFault::FlippedTorque {
                joints: vec![0, 1, 2, 3],
            },
            FaultKind::TorqueSign,
        ),
        (
            LogFault::Degrees {
                joints: vec![0, 1, 2, 3],
            },
            FaultKind::UnitMismatch,
        ),
        (LogFault::SwappedTorques { joints: [1, 2] }, FaultKind::JointOrder),
        (LogFault::SwappedPositions { joints: [1, 2] }, FaultKind::JointOrder),
        (LogFault::ConstantTorque { joint: 2 }, FaultKind::BadSamples),
        (LogFault::ClippedTorque { joint: 1, limit: 4.0 }, FaultKind::BadSamples),
        (
            LogFault::Frozen {
                start: 12.0,
                duration: 0.5,
            },
            FaultKind::BadSamples,
        ),
        (LogFault::RepeatedTimes { count: 20 }, FaultKind::BadSamples),
        (LogFault::GarbageRows { count: 5 }, FaultKind::BadSamples),
    ];
    for robot in robots() {
        let [log, _] = logs(&robot, &[], &sensor_noise(robot.joint_count()), 30);
        assert!(
            faults(&robot, &log).is_empty(),
            "{}: {:?}",
            robot.name(),
            faults(&robot, &log)
        );
        for (fault, kind) in &cases {
            let mut bad = log.clone();
            corrupt(&mut bad, fault, 1);
            let found = faults(&robot, &bad);
            assert!(
                found.iter().any(|f| f.fault == *kind),
                "{}: {fault:?} gives {found:?}",
                robot.name()
            );
        }
    }
}
