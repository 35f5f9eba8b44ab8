//! Faults of a record: what goes wrong between robot and file.

use super::RecordedLog;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

/// One fault; joints count from 0.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "fault", rename_all = "snake_case", deny_unknown_fields)]
pub enum LogFault {
    /// Torque of these joints with the wrong sign.
    FlippedTorque {
        /// The joints, from 0.
        joints: Vec<usize>,
    },
    /// Positions of these joints in degrees.
    Degrees {
        /// The joints, from 0.
        joints: Vec<usize>,
    },
    /// Torque columns of two joints exchanged.
    SwappedTorques {
        /// The two joints, from 0.
        joints: [usize; 2],
    },
    /// Position columns of two joints exchanged.
    SwappedPositions {
        /// The two joints, from 0.
        joints: [usize; 2],
    },
    /// Torque of a joint stuck at one value.
    ConstantTorque {
        /// Number of the joint, from 0.
        joint: usize,
    },
    /// Torque of a joint limited to ± this value.
    ClippedTorque {
        /// Number of the joint, from 0.
        joint: usize,
        /// Largest torque that is recorded [N·m or N].
        limit: f64,
    },
    /// All columns repeat their value from `start` for `duration` (s).
    Frozen {
        /// When it begins (s).
        start: f64,
        /// How long it lasts (s).
        duration: f64,
    },
    /// So many rows with the time of the row before.
    RepeatedTimes {
        /// Number of rows.
        count: usize,
    },
    /// So many rows with numbers that mean nothing.
    GarbageRows {
        /// Number of rows.
        count: usize,
    },
}

/// Puts a fault into a log. Same seed, same rows.
pub fn corrupt(log: &mut RecordedLog, fault: &LogFault, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let samples = log.time.len();
    match fault {
        LogFault::FlippedTorque { joints } => joints.iter().for_each(|&j| log.tau[j].iter_mut().for_each(|t| *t = -*t)),
        LogFault::Degrees { joints } => joints
            .iter()
            .for_each(|&j| log.q[j].iter_mut().for_each(|q| *q = q.to_degrees())),
        LogFault::SwappedTorques { joints: [a, b] } => log.tau.swap(*a, *b),
        LogFault::SwappedPositions { joints: [a, b] } => log.q.swap(*a, *b),
        LogFault::ConstantTorque { joint } => {
            let stuck = log.tau[*joint][0];
            log.tau[*joint].fill(stuck);
        }
        LogFault::ClippedTorque { joint, limit } => {
            // A limit holds to both sides, whatever its sign.
            let limit = limit.abs();
            log.tau[*joint].iter_mut().for_each(|t| *t = t.clamp(-limit, limit));
        }
        LogFault::Frozen { start, duration } => {
            let held = log.time.iter().position(|t| t >= start).unwrap_or(samples - 1);
            for s in held..samples {
                if log.time[s] < start + duration {
                    log.q
                        .iter_mut()
                        .chain(&mut log.tau)
                        .for_each(|column| column[s] = column[held]);
                }
            }
        }
        LogFault::RepeatedTimes { count } => {
            for _ in 0..*count {
                let s = rng.random_range(1..samples);
                log.time[s] = log.time[s - 1];
            }
        }
        LogFault::GarbageRows { count } => {
            for _ in 0..*count {
                let s = rng.random_range(0..samples);
                log.q
                    .iter_mut()
                    .chain(&mut log.tau)
                    .for_each(|column| column[s] = rng.random_range(-1e4..1e4));
            }
        }
    }
}
