//! From a motion to a traced log.

use super::{bodies, excitation, published, validation, wide_excitation, wide_validation};
use dynident::diagnosis::{Diagnosis, DiagnosisOptions, diagnose, diagnose_mounted, mounting};
use dynident::model::Robot;
use dynident::preparation::{Log, PreprocessOptions, prepare};
use dynident::regression::Stretch;
use dynident::simulate::{Experiment, HiddenEffect, Noise, RecordedLog, simulate};
use dynident::trajectory::{QuinticWayPoints, Trajectory};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub const RATE: f64 = 200.0;

pub fn noise_levels(joints: usize) -> Vec<f64> {
    [0.3, 0.3, 0.2, 0.2, 0.12, 0.12, 0.06][..joints].to_vec()
}

pub fn sensor_noise(joints: usize) -> Noise {
    Noise {
        position: 2.5e-5,
        position_step: 1e-7,
        torque_step: 1e-5,
        ..Noise::white(noise_levels(joints))
    }
}

pub fn stretch(log: &RecordedLog, name: &str) -> Stretch {
    let joints = log.q.len();
    let log = as_log(log, name, RATE);
    Stretch::new(&prepare(&log, joints, &PreprocessOptions::default()).unwrap(), &log)
}

/// Six periods of the first motion with the first effects, and three of the second with the second.
fn recorded(
    robot: &Robot,
    parameters: &[f64],
    motions: [&dyn Trajectory; 2],
    effects: [&[HiddenEffect]; 2],
    noise: &Noise,
    seed: u64,
) -> [RecordedLog; 2] {
    let run = |which: usize, periods: f64, seed: u64| {
        simulate(&Experiment {
            robot,
            parameters,
            trajectory: motions[which],
            periods,
            rate_hz: RATE,
            effects: effects[which],
            noise,
            seed,
        })
    };
    [run(0, 6.0, seed), run(1, 3.0, seed + 1_000_000)]
}

/// Excitation and validation motion of a robot with these effects.
pub fn logs(robot: &Robot, effects: &[HiddenEffect], noise: &Noise, seed: u64) -> [RecordedLog; 2] {
    let n = robot.joint_count();
    let (excitation, validation) = (excitation(n, seed), validation(n, seed));
    recorded(
        robot,
        &bodies(robot, seed),
        [&excitation, &validation],
        [effects, effects],
        noise,
        seed,
    )
}

/// The tracing of an identification log.
pub fn traced(robot: &Robot, effects: &[HiddenEffect], noise: &Noise, seed: u64) -> Diagnosis {
    let [identify, validate] = logs(robot, effects, noise, seed);
    diagnose(
        robot,
        &[stretch(&identify, "identify")],
        &[stretch(&validate, "validate")],
        &DiagnosisOptions::default(),
    )
}

/// The published arm on motions as wide as its limits allow, each with its own effects.
pub fn published_logs(robot: &Robot, phi: &[f64], effects: [&[HiddenEffect]; 2], noise: &Noise, seed: u64) -> [RecordedLog; 2] {
    let (excitation, validation) = (wide_excitation(robot, seed), wide_validation(robot, seed));
    recorded(robot, phi, [&excitation, &validation], effects, noise, seed)
}

/// The published arm on its first motion, as often and as finely sampled as asked, with a spring of 1.8 N·m/rad on the fourth
/// joint.
pub fn long_log(name: &str, periods: f64, rate_hz: f64) -> (Robot, Log) {
    let (robot, phi) = published();
    let spring = HiddenEffect::JointSpring {
        joint: 3,
        stiffness: 1.8,
        rest: 0.2,
    };
    let recorded = simulate(&Experiment {
        robot: &robot,
        parameters: &phi,
        trajectory: &wide_excitation(&robot, 1),
        periods,
        rate_hz,
        effects: &[spring],
        noise: &sensor_noise(7),
        seed: 1,
    });
    let log = as_log(&recorded, name, rate_hz);
    (robot, log)
}

pub fn as_log(recorded: &RecordedLog, name: &str, rate_hz: f64) -> Log {
    Log {
        name: name.into(),
        rate_hz,
        start_s: 0.0,
        q: recorded.q.clone(),
        qd: None,
        tau: recorded.tau.clone(),
        usable: vec![true; recorded.time.len()],
        channels: Vec::new(),
    }
}

/// Gravity as found, if it is not as declared, and the tracing with it, of a log of `robot` under gravity along `direction`.
pub fn traced_mounted(
    robot: &Robot,
    direction: Vector3<f64>,
    effects: &[HiddenEffect],
    seed: u64,
) -> (Option<Vector3<f64>>, Diagnosis) {
    let n = robot.joint_count();
    let there = robot.with_gravity(direction.normalize() * robot.gravity().norm());
    let [identify, validate] = logs(&there, effects, &sensor_noise(n), seed);
    let prepared = prepare(&as_log(&identify, "identify", RATE), n, &PreprocessOptions::default()).unwrap();
    let stretches = [stretch(&identify, "identify")];
    let held_out = [stretch(&validate, "validate")];
    let options = DiagnosisOptions::default();
    match mounting(robot, &[(&prepared.motion, &prepared.torque)]) {
        None => (None, diagnose(robot, &stretches, &held_out, &options)),
        Some(found) => {
            let (outcome, gravity) = diagnose_mounted(&robot.with_gravity(found.gravity), &stretches, &held_out, &options);
            (Some(gravity.value), outcome)
        }
    }
}

/// A minute of random way-points that never come back.
pub fn single_run(joints: usize, seed: u64) -> QuinticWayPoints {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x3a7);
    let points = (0..31)
        .map(|_| (0..joints).map(|_| rng.random_range(-1.0..1.0)).collect())
        .collect();
    QuinticWayPoints::new(points, &[2.0; 30])
}

/// The log of [`single_run`].
pub fn recorded_once(robot: &Robot, hidden: &[HiddenEffect], noise: &Noise, seed: u64) -> RecordedLog {
    simulate(&Experiment {
        robot,
        parameters: &bodies(robot, seed),
        trajectory: &single_run(robot.joint_count(), seed),
        periods: 1.0,
        rate_hz: RATE,
        effects: hidden,
        noise,
        seed,
    })
}

/// The same, traced.
pub fn once(robot: &Robot, hidden: &[HiddenEffect], noise: &Noise, seed: u64) -> Diagnosis {
    let log = recorded_once(robot, hidden, noise, seed);
    diagnose(robot, &[stretch(&log, "once")], &[], &DiagnosisOptions::default())
}
