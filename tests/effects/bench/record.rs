//! From a motion to a traced log.

use super::{bodies, excitation, validation, wide_excitation, wide_validation};
use dynident::identification::{Log, PreprocessOptions, prepare};
use dynident::model::Robot;
use dynident::residual::{Outcome, Stretch, TraceOptions, trace};
use dynident::simulate::{Experiment, HiddenEffect, Noise, RecordedLog, simulate};
use dynident::trajectory::Trajectory;

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
    let log = Log {
        name: name.into(),
        rate_hz: RATE,
        start_s: 0.0,
        q: log.q.clone(),
        qd: None,
        tau: log.tau.clone(),
        usable: vec![true; log.time.len()],
    };
    Stretch::new(&prepare(&log, joints, &PreprocessOptions::default()).unwrap(), &log)
}

/// Six periods of excitation, and three of the validation motion, of a robot with these effects.
pub fn logs(robot: &Robot, effects: &[HiddenEffect], noise: &Noise, seed: u64) -> [RecordedLog; 2] {
    let n = robot.joint_count();
    let (phi, excitation, validation) = (bodies(robot, seed), excitation(n, seed), validation(n, seed));
    let run = |trajectory: &dyn Trajectory, periods: f64, seed: u64| {
        simulate(&Experiment {
            robot,
            parameters: &phi,
            trajectory,
            periods,
            rate_hz: RATE,
            effects,
            noise,
            seed,
        })
    };
    [run(&excitation, 6.0, seed), run(&validation, 3.0, seed + 1_000_000)]
}

/// The tracing of an identification log.
pub fn traced(robot: &Robot, effects: &[HiddenEffect], noise: &Noise, seed: u64) -> Outcome {
    let [identify, validate] = logs(robot, effects, noise, seed);
    trace(
        robot,
        &[stretch(&identify, "identify")],
        &[stretch(&validate, "validate")],
        &TraceOptions::default(),
    )
}

/// The published arm on a motion as wide as its limits allow: six periods with the first `effects`, and three of the validation motion with the second.
pub fn published_logs(robot: &Robot, phi: &[f64], effects: [&[HiddenEffect]; 2], noise: &Noise, seed: u64) -> [RecordedLog; 2] {
    let (excitation, validation) = (wide_excitation(robot, seed), wide_validation(robot, seed));
    let run = |trajectory: &dyn Trajectory, periods: f64, effects: &[HiddenEffect], seed: u64| {
        simulate(&Experiment {
            robot,
            parameters: phi,
            trajectory,
            periods,
            rate_hz: RATE,
            effects,
            noise,
            seed,
        })
    };
    [
        run(&excitation, 6.0, effects[0], seed),
        run(&validation, 3.0, effects[1], seed + 1_000_000),
    ]
}
