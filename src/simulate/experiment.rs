//! From a trajectory to a log.

use super::elastic::ElasticArm;
use super::friction::{dahl, direction};
use super::noise::{correlated, normal, quantised};
use super::torque::{Along, add_torque, disturb_reading};
use super::{HiddenEffect, Noise};
use crate::dynamics::{Chain, Coulomb, Motion, inverse_dynamics_batch};
use crate::model::Robot;
use crate::parameters::{Inertial, Layout, ParameterKind};
use crate::spatial::PhysicalInertia;
use crate::trajectory::Trajectory;
use nalgebra::{Matrix3, Rotation3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A virtual robot on a trajectory.
pub struct Experiment<'a> {
    /// As declared to the identification.
    pub robot: &'a Robot,
    /// True standard parameters, in the order of [`Layout::standard`].
    pub parameters: &'a [f64],
    /// The motion that is commanded, and followed exactly.
    pub trajectory: &'a dyn Trajectory,
    /// How often the trajectory is run through; may end within a period.
    pub periods: f64,
    /// Sampling rate (Hz).
    pub rate_hz: f64,
    /// What the declared model lacks.
    pub effects: &'a [HiddenEffect],
    /// Noise of the sensors.
    pub noise: &'a Noise,
    /// Of the noise: the same seed gives the same log.
    pub seed: u64,
}

/// A log as a recorder writes it: one row per sample.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedLog {
    /// (s)
    pub time: Vec<f64>,
    /// Per joint [rad or m].
    pub q: Vec<Vec<f64>>,
    /// Per joint [N·m or N].
    pub tau: Vec<Vec<f64>>,
}

/// Runs the experiment. Same seed, same log.
///
/// # Panics
/// When parameters, noise or trajectory do not fit the robot, or an effect names a joint that is not there.
pub fn simulate(experiment: &Experiment) -> RecordedLog {
    let n = experiment.robot.joint_count();
    assert_eq!(experiment.trajectory.joints(), n, "the trajectory moves every joint");
    assert_eq!(experiment.noise.torque.len(), n, "one noise level per joint");
    let mut rng = ChaCha8Rng::seed_from_u64(experiment.seed);
    let samples = (experiment.periods * experiment.trajectory.duration() * experiment.rate_hz).round() as usize;
    let time: Vec<f64> = (0..samples).map(|s| s as f64 / experiment.rate_hz).collect();
    let actual: Vec<f64> = time.iter().map(|t| t + experiment.noise.jitter * normal(&mut rng)).collect();
    let late = delay(experiment.effects);
    let torque_times: Vec<f64> = actual.iter().map(|t| t - late).collect();
    let mut tau = true_torque(experiment, &torque_times);
    for (j, row) in tau.iter_mut().enumerate() {
        let noise = correlated(
            &mut rng,
            samples,
            experiment.noise.torque[j],
            experiment.noise.torque_correlation,
        );
        row.iter_mut()
            .zip(noise)
            .for_each(|(t, e)| *t = quantised(*t + e, experiment.noise.torque_step));
    }
    let reading = |j: usize, t: f64, e: f64| quantised(position_at(experiment, j, t) + e, experiment.noise.position_step);
    let q = (0..n)
        .map(|j| {
            actual
                .iter()
                .map(|&t| reading(j, t, experiment.noise.position * normal(&mut rng)))
                .collect()
        })
        .collect();
    RecordedLog { time, q, tau }
}

fn delay(effects: &[HiddenEffect]) -> f64 {
    effects
        .iter()
        .map(|e| {
            if let HiddenEffect::TorqueDelay { seconds } = e {
                *seconds
            } else {
                0.0
            }
        })
        .sum()
}

/// Time within the trajectory, which repeats.
fn phase(experiment: &Experiment, t: f64) -> f64 {
    t.rem_euclid(experiment.trajectory.duration())
}

fn position_at(experiment: &Experiment, joint: usize, t: f64) -> f64 {
    experiment.trajectory.state(joint, phase(experiment, t))[0]
}

/// What the trajectory says the encoders read, at these times.
fn encoder_motion(experiment: &Experiment, times: &[f64]) -> Motion {
    Motion::from_fn(experiment.robot.joint_count(), times.len(), |j, s| {
        experiment.trajectory.state(j, phase(experiment, times[s]))
    })
}

/// Samples that torques are computed for at a time: motion and torques on the way take many times the memory of what is recorded.
const BLOCK: usize = 8192;

/// Torque readings without noise, n × N.
fn true_torque(experiment: &Experiment, times: &[f64]) -> Vec<Vec<f64>> {
    let robot = tilted(experiment);
    let layout = Layout::standard(&robot);
    let (rigid_phi, friction) = bodies(experiment, &layout);
    let links = Links::new(experiment, &robot, &layout, &rigid_phi, times);
    let memories: Vec<Option<Vec<f64>>> = experiment.effects.iter().map(|e| hysteresis(e, experiment, times)).collect();
    let chain = Chain::new(&robot);
    let mut tau: Vec<Vec<f64>> = (0..robot.joint_count()).map(|_| Vec::with_capacity(times.len())).collect();
    for first in (0..times.len()).step_by(BLOCK) {
        let range = first..times.len().min(first + BLOCK);
        let times = &times[range.clone()];
        let motor = encoder_motion(experiment, times);
        let link = links.motion(&motor, times);
        let flat = inverse_dynamics_batch(&chain, &layout, &rigid_phi, &link, Coulomb::Sign);
        let rigid: Vec<&[f64]> = (0..robot.joint_count())
            .map(|j| &flat[j * link.stride()..j * link.stride() + link.samples()])
            .collect();
        let mut block: Vec<Vec<f64>> = rigid.iter().map(|row| row.to_vec()).collect();
        for (j, row) in block.iter_mut().enumerate() {
            let [viscous, coulomb] = friction[j];
            row.iter_mut()
                .zip(motor.velocities(j))
                .for_each(|(t, &v)| *t += viscous * v + coulomb * direction(v));
        }
        for (effect, memory) in experiment.effects.iter().zip(&memories) {
            let along = Along {
                robot: &robot,
                interval: 1.0 / experiment.rate_hz,
                times,
                motor: &motor,
                rigid: &rigid,
                memory: memory.as_ref().map_or(&[], |z| &z[range.clone()]),
            };
            add_torque(effect, &along, &mut block);
        }
        for effect in experiment.effects {
            disturb_reading(effect, &mut block);
        }
        tau.iter_mut().zip(&block).for_each(|(whole, part)| whole.extend(part));
    }
    tau
}

/// State over all samples of an effect that remembers; `None` of all others.
fn hysteresis(effect: &HiddenEffect, experiment: &Experiment, times: &[f64]) -> Option<Vec<f64>> {
    let HiddenEffect::PreslidingHysteresis { joint, width, .. } = effect else {
        return None;
    };
    let velocity = |&t: &f64| experiment.trajectory.state(*joint, phase(experiment, t))[1];
    let velocities: Vec<f64> = times.iter().map(velocity).collect();
    Some(dahl(&velocities, 1.0 / experiment.rate_hz, *width))
}

/// The robot as it really stands.
fn tilted(experiment: &Experiment) -> Robot {
    let mut gravity = experiment.robot.gravity();
    for effect in experiment.effects {
        if let HiddenEffect::BaseTilt { roll, pitch } = effect {
            let stand = Rotation3::from_axis_angle(&nalgebra::Vector3::y_axis(), *pitch)
                * Rotation3::from_axis_angle(&nalgebra::Vector3::x_axis(), *roll);
            gravity = stand.inverse() * gravity;
        }
    }
    experiment.robot.with_gravity(gravity)
}

/// Standard parameters with payload and without friction, and friction `[viscous, Coulomb]` per joint.
fn bodies(experiment: &Experiment, layout: &Layout) -> (Vec<f64>, Vec<[f64; 2]>) {
    let mut phi = experiment.parameters.to_vec();
    assert_eq!(phi.len(), layout.len(), "one value per standard parameter");
    let mut friction = vec![[0.0; 2]; experiment.robot.joint_count()];
    for (at, parameter) in layout.parameters().iter().enumerate() {
        let kind = match parameter.kind {
            ParameterKind::Viscous => 0,
            ParameterKind::Coulomb => 1,
            ParameterKind::Inertial(_) => continue,
        };
        friction[parameter.link][kind] = std::mem::take(&mut phi[at]);
    }
    let last = experiment.robot.joint_count() - 1;
    for effect in experiment.effects {
        if let HiddenEffect::Payload {
            mass,
            center_of_mass,
            inertia,
        } = effect
        {
            let body = PhysicalInertia {
                mass: *mass,
                center_of_mass: (*center_of_mass).into(),
                inertia: Matrix3::from_fn(|r, c| inertia[r][c]),
            }
            .about_origin();
            Inertial::ALL
                .iter()
                .zip(body.parameters())
                .for_each(|(&i, p)| phi[layout.inertial(last, i)] += p);
        }
    }
    (phi, friction)
}

/// Motion of the links: encoder offsets and elastic gears between.
struct Links {
    offsets: Vec<f64>,
    /// Time that `elastic` begins at (s).
    from: f64,
    /// Elastic joints with their states on the grid.
    elastic: Vec<(usize, Vec<[f64; 3]>)>,
}

impl Links {
    fn new(experiment: &Experiment, robot: &Robot, layout: &Layout, phi: &[f64], times: &[f64]) -> Self {
        let n = robot.joint_count();
        let (mut offsets, mut compliance) = (vec![0.0; n], vec![0.0; n]);
        for effect in experiment.effects {
            match effect {
                HiddenEffect::EncoderOffset { joint, offset } => offsets[*joint] += offset,
                HiddenEffect::JointElasticity { joint, stiffness } => compliance[*joint] += 1.0 / stiffness,
                _ => {}
            }
        }
        // A millisecond grid over all the time needed.
        let (first, last) = (
            times.iter().copied().fold(f64::INFINITY, f64::min),
            times.iter().copied().fold(0.0, f64::max),
        );
        let from = first - 0.01;
        let mut elastic = Vec::new();
        if compliance.iter().any(|c| *c != 0.0) {
            let arm = ElasticArm {
                robot,
                layout,
                phi,
                compliance: &compliance,
            };
            let state = |j: usize, t: f64| {
                let [q, qd, qdd] = experiment.trajectory.state(j, phase(experiment, t));
                [q + offsets[j], qd, qdd]
            };
            // Motors at half steps too.
            let motor = |k: usize| (0..n).map(|j| state(j, from + 0.5 * k as f64 * GRID)).collect();
            elastic = arm.links(&motor, ((last - from) / GRID) as usize + 12, GRID);
        }
        Self { offsets, from, elastic }
    }

    /// What the links do at these times, where the motors do `motor`.
    fn motion(&self, motor: &Motion, times: &[f64]) -> Motion {
        let mut links = Motion::from_fn(motor.joints(), motor.samples(), |j, s| {
            let [q, qd, qdd] = motor.get(j, s);
            [q + self.offsets[j], qd, qdd]
        });
        for (j, states) in &self.elastic {
            for (s, t) in times.iter().enumerate() {
                links.set(*j, s, between(states, (t - self.from) / GRID));
            }
        }
        links
    }
}

const GRID: f64 = 1e-3;

/// Linear between grid points a millisecond apart: second differences of joint motion over that are 1e-6 of its size.
fn between(states: &[[f64; 3]], at: f64) -> [f64; 3] {
    let (low, u) = (at.floor() as usize, at - at.floor());
    let (a, b) = (states[low], states[low + 1]);
    std::array::from_fn(|i| a[i] + u * (b[i] - a[i]))
}
