//! Virtual robots on random trajectories, and the tracing of their logs.
#![allow(dead_code)]

use dynident::identification::{Log, PreprocessOptions, prepare};
use dynident::model::{Friction, Joint, JointKind, Mdh, Robot};
use dynident::parameters::{Layout, ParameterKind};
use dynident::residual::{Outcome, Stretch, TraceOptions, trace};
use dynident::simulate::{Experiment, HiddenEffect, Noise, RecordedLog, simulate};
use dynident::spatial::PhysicalInertia;
use dynident::trajectory::{FourierSeries, QuinticWayPoints, Trajectory};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub const RATE: f64 = 200.0;

fn arm(name: &str, table: &[(f64, f64, f64, f64)]) -> Robot {
    let joint = |(i, &(alpha, d, theta, r)): (usize, &(f64, f64, f64, f64))| {
        Joint::from_mdh(format!("J{}", i + 1), JointKind::Revolute, Mdh { alpha, d, theta, r })
    };
    let joints = table.iter().enumerate().map(joint).collect();
    Robot::new(
        name,
        Vector3::new(0.0, 0.0, -9.81),
        joints,
        Friction {
            viscous: true,
            coulomb: true,
        },
    )
    .unwrap()
}

/// The iiwa 14 of the paper's Table 1.
pub fn seven_axes() -> Robot {
    let q = std::f64::consts::FRAC_PI_2;
    arm(
        "iiwa 14",
        &[
            (0.0, 0.0, 0.0, 0.0),
            (q, 0.0, 0.0, 0.0),
            (-q, 0.0, 0.0, 0.42),
            (-q, 0.0, 0.0, 0.0),
            (q, 0.0, 0.0, 0.4),
            (q, 0.0, 0.0, 0.0),
            (-q, 0.0, 0.0, 0.0),
        ],
    )
}

/// Kinematics of a UR10-type arm.
pub fn six_axes() -> Robot {
    let q = std::f64::consts::FRAC_PI_2;
    arm(
        "six axes",
        &[
            (0.0, 0.0, 0.0, 0.128),
            (q, 0.0, 0.0, 0.0),
            (0.0, -0.612, 0.0, 0.0),
            (0.0, -0.572, 0.0, 0.164),
            (q, 0.0, 0.0, 0.116),
            (-q, 0.0, 0.0, 0.092),
        ],
    )
}

/// Four axes: waist, shoulder, elbow and a roll.
pub fn four_axes() -> Robot {
    let q = std::f64::consts::FRAC_PI_2;
    arm(
        "four axes",
        &[
            (0.0, 0.0, 0.0, 0.3),
            (-q, 0.1, 0.0, 0.0),
            (0.0, 0.4, 0.0, 0.0),
            (-q, 0.0, 0.0, 0.35),
        ],
    )
}

pub fn robots() -> Vec<Robot> {
    vec![seven_axes(), six_axes(), four_axes()]
}

/// Plausible bodies: boxes that get lighter towards the tip, friction that goes with them.
pub fn bodies(robot: &Robot, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xb0d1e5);
    let layout = Layout::standard(robot);
    let mut phi = vec![0.0; layout.len()];
    let n = robot.joint_count();
    for link in 0..n {
        let size = 1.0 - 0.8 * link as f64 / n as f64;
        let mass = 5.0 * size * rng.random_range(0.7..1.3);
        let center = Vector3::from_fn(|_, _| rng.random_range(-0.12..0.12) * size);
        let sides = Vector3::from_fn(|_, _| rng.random_range(0.08..0.3) * size);
        let square = sides.component_mul(&sides) * (mass / 12.0);
        let inertia = Matrix3::from_diagonal(&Vector3::new(square.y + square.z, square.x + square.z, square.x + square.y));
        let body = PhysicalInertia {
            mass,
            center_of_mass: center,
            inertia,
        }
        .about_origin()
        .parameters();
        for (at, parameter) in layout.parameters().iter().enumerate().filter(|(_, p)| p.link == link) {
            phi[at] = match parameter.kind {
                ParameterKind::Inertial(i) => body[i as usize],
                ParameterKind::Viscous => 1.5 * size * rng.random_range(0.5..1.5),
                ParameterKind::Coulomb => 1.5 * size * rng.random_range(0.5..1.5),
            };
        }
    }
    phi
}

/// A random Fourier series at rest at zero at its start, scaled to 1.2 rad/s and 1.4 rad.
pub fn excitation(joints: usize, seed: u64) -> FourierSeries {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xe8c17e);
    let order = 5;
    let mut series = FourierSeries::at_rest(vec![0.0; joints], order, 0.1);
    series.a = DMatrix::from_fn(joints, order, |_, _| rng.random_range(-1.0..1.0));
    series.b = DMatrix::from_fn(joints, order, |_, _| rng.random_range(-1.0..1.0));
    for j in 0..joints {
        // Position, velocity and acceleration zero at t = 0: Σ b/l = 0, Σ a = 0, Σ l b = 0.
        let mean = series.a.row(j).sum() / order as f64;
        series.a.row_mut(j).iter_mut().for_each(|a| *a -= mean);
        let (b1, b2) = {
            let (s, t) = (2..order).fold((0.0, 0.0), |(s, t), l| {
                let b = series.b[(j, l)];
                (s + b / (l + 1) as f64, t + b * (l + 1) as f64)
            });
            // b1 + b2/2 = −s, b1 + 2 b2 = −t.
            let b2 = (s - t) / 1.5;
            (-s - 0.5 * b2, b2)
        };
        (series.b[(j, 0)], series.b[(j, 1)]) = (b1, b2);
        let (mut speed, mut travel) = (0.0f64, 0.0f64);
        for k in 0..400 {
            let [q, v, _] = series.state(j, k as f64 * 0.025);
            (speed, travel) = (speed.max(v.abs()), travel.max(q.abs()));
        }
        let scale = (1.2 / speed).min(1.4 / travel);
        series.a.row_mut(j).iter_mut().for_each(|v| *v *= scale);
        series.b.row_mut(j).iter_mut().for_each(|v| *v *= scale);
    }
    series
}

/// Random way-points, 10 s.
pub fn validation(joints: usize, seed: u64) -> QuinticWayPoints {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x9a11d);
    let mut points: Vec<Vec<f64>> = (0..6)
        .map(|_| (0..joints).map(|_| rng.random_range(-1.0..1.0)).collect())
        .collect();
    points[0] = vec![0.0; joints];
    points[5] = vec![0.0; joints];
    QuinticWayPoints::new(points, &[2.0; 5])
}

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

/// Every effect on `joint` at `size` (1 is well visible), with the code it should be found under.
pub fn effect(code: &str, joint: usize, size: f64, robot: &Robot) -> HiddenEffect {
    use HiddenEffect::*;
    let n = robot.joint_count();
    let level = noise_levels(n)[joint] / 0.2 * size;
    let other = if joint + 1 < n { joint + 1 } else { joint - 1 };
    match code {
        "torque_offset" => TorqueOffset {
            joint,
            offset: 0.3 * level,
        },
        "stribeck_friction" => StribeckFriction {
            joint,
            amplitude: 0.8 * level,
            velocity: 0.1,
            exponent: 2.0,
        },
        "nonlinear_viscous_friction" => NonlinearViscousFriction {
            joint,
            coefficient: 0.8 * level,
            exponent: 2.0,
        },
        "asymmetric_viscous_friction" => AsymmetricViscousFriction {
            joint,
            coefficient: 0.5 * level,
        },
        "load_dependent_friction" => LoadDependentFriction {
            joint,
            coefficient: 0.04 * size,
        },
        "presliding_hysteresis" => PreslidingHysteresis {
            joint,
            amplitude: 1.0 * level,
            width: 0.02,
        },
        "rotor_inertia" => RotorInertia {
            joint,
            inertia: 0.3 * level,
        },
        "transmission_coupling" => {
            let (a, b) = (joint.min(other), joint.max(other));
            TransmissionCoupling {
                joints: [a, b],
                ratio: 1.0,
                viscous: 0.4 * level,
                coulomb: 0.4 * level,
                inertia: 0.1 * level,
            }
        }
        "joint_spring" => JointSpring {
            joint,
            stiffness: 1.5 * level,
            rest: 0.2,
        },
        "position_ripple" => PositionRipple {
            joint,
            amplitude: 0.2 * level,
            cycles: 23.4,
            phase: 0.5,
        },
        "joint_elasticity" => JointElasticity {
            joint,
            stiffness: 4000.0 / size,
        },
        "encoder_offset" => EncoderOffset {
            joint,
            offset: 0.03 * size,
        },
        "base_tilt" => BaseTilt {
            roll: 0.02 * size,
            pitch: -0.015 * size,
        },
        "torque_delay" => TorqueDelay { seconds: 0.01 * size },
        "torque_gain" => TorqueGain {
            joint,
            gain: 1.0 + 0.05 * size,
        },
        "torque_crosstalk" => TorqueCrosstalk {
            joint,
            from: other,
            coefficient: 0.05 * size,
        },
        "friction_drift" => FrictionDrift {
            joint,
            viscous: 0.5 * level,
            coulomb: 0.5 * level,
            time_constant: 20.0,
        },
        "external_contact" => ExternalContact {
            start: 23.0,
            end: 24.0,
            torque: (0..n).map(|j| if j == joint { 2.0 * level } else { 0.0 }).collect(),
        },
        "unexplained" => Unmodelled {
            joints: [joint, other],
            amplitude: 1.5 * level,
        },
        _ => panic!("no such effect: {code}"),
    }
}

pub const CODES: [&str; 19] = [
    "torque_offset",
    "stribeck_friction",
    "nonlinear_viscous_friction",
    "asymmetric_viscous_friction",
    "load_dependent_friction",
    "presliding_hysteresis",
    "rotor_inertia",
    "transmission_coupling",
    "joint_spring",
    "position_ripple",
    "joint_elasticity",
    "encoder_offset",
    "base_tilt",
    "torque_delay",
    "torque_gain",
    "torque_crosstalk",
    "friction_drift",
    "external_contact",
    "unexplained",
];
