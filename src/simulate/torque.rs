//! Torques that hidden effects add, and what the torque channel makes of them.

use super::HiddenEffect;
use super::friction::direction;
use super::listed::Part;
use crate::dynamics::Motion;
use crate::model::Robot;

/// A part of an experiment.
pub(super) struct Along<'a> {
    pub robot: &'a Robot,
    pub times: &'a [f64],
    /// Between samples (s).
    pub interval: f64,
    pub motor: &'a Motion,
    /// Torque of the bodies alone, per joint.
    pub rigid: &'a [&'a [f64]],
    /// State of an effect that remembers.
    pub memory: &'a [f64],
}

pub(super) fn add_torque(effect: &HiddenEffect, along: &Along, tau: &mut [Vec<f64>]) {
    use HiddenEffect::*;
    let Along {
        times,
        motor,
        rigid,
        memory,
        ..
    } = along;
    let mut add = |joint: usize, value: &dyn Fn(usize, [f64; 3]) -> f64| {
        tau[joint]
            .iter_mut()
            .enumerate()
            .for_each(|(s, t)| *t += value(s, motor.get(joint, s)));
    };
    match effect {
        TorqueOffset { joint, offset } => add(*joint, &|_, _| *offset),
        StribeckFriction {
            joint,
            amplitude,
            velocity,
            exponent,
        } => {
            add(*joint, &|_, [_, v, _]| {
                amplitude * (-(v.abs() / velocity).powf(*exponent)).exp() * direction(v)
            });
        }
        NonlinearViscousFriction {
            joint,
            coefficient,
            exponent,
        } => {
            add(*joint, &|_, [_, v, _]| coefficient * v.abs().powf(*exponent) * direction(v));
        }
        AsymmetricViscousFriction { joint, coefficient } => add(*joint, &|_, [_, v, _]| coefficient * v.abs()),
        LoadDependentFriction { joint, coefficient } => {
            add(*joint, &|s, [_, v, _]| coefficient * rigid[*joint][s].abs() * direction(v));
        }
        PreslidingHysteresis { joint, amplitude, .. } => {
            add(*joint, &|s, [_, v, _]| amplitude * (memory[s] - direction(v)));
        }
        SmoothCoulombFriction {
            joint,
            amplitude,
            velocity,
        } => add(*joint, &|_, [_, v, _]| amplitude * ((v / velocity).tanh() - direction(v))),
        RotorInertia { joint, inertia } => add(*joint, &|_, [_, _, a]| inertia * a),
        TransmissionCoupling {
            joints,
            ratio,
            viscous,
            coulomb,
            inertia,
        } => {
            let [first, second] = *joints;
            let load = |s: usize| {
                let ([_, v, a], [_, w, b]) = (motor.get(first, s), motor.get(second, s));
                let speed = v + ratio * w;
                viscous * speed + coulomb * direction(speed) + inertia * (a + ratio * b)
            };
            add(first, &|s, _| load(s));
            add(second, &|s, _| ratio * load(s));
        }
        JointSpring { joint, stiffness, rest } => add(*joint, &|_, [q, _, _]| stiffness * (q - rest)),
        PositionRipple {
            joint,
            amplitude,
            cycles,
            phase,
        } => add(*joint, &|_, [q, _, _]| amplitude * (cycles * q + phase).sin()),
        FrictionDrift {
            joint,
            viscous,
            coulomb,
            time_constant,
        } => {
            add(*joint, &|s, [_, v, _]| {
                (viscous * v + coulomb * direction(v)) * (-times[s] / time_constant).exp()
            });
        }
        ExternalContact { start, end, torque } => {
            for (joint, level) in torque.iter().enumerate() {
                add(joint, &|s, _| {
                    if times[s] >= *start && times[s] < *end { *level } else { 0.0 }
                });
            }
        }
        TorqueDrift {
            joint,
            torque,
            time_constant,
        } => add(*joint, &|s, _| torque * (-times[s] / time_constant).exp()),
        Unmodelled { joints, amplitude } => {
            let other = joints[1];
            add(joints[0], &|s, [q, _, _]| {
                amplitude * (2.0 * q).sin() * (3.0 * motor.get(other, s)[0]).cos()
            });
        }
        Listed(effect) => effect.add(
            &Part {
                robot: along.robot,
                motor: along.motor,
                rigid: along.rigid,
                interval: along.interval,
            },
            tau,
        ),
        JointElasticity { .. }
        | EncoderOffset { .. }
        | BaseTilt { .. }
        | Payload { .. }
        | TorqueDelay { .. }
        | TorqueGain { .. }
        | TorqueCrosstalk { .. } => {}
    }
}

/// Effects of the torque channel, after everything physical.
pub(super) fn disturb_reading(effect: &HiddenEffect, tau: &mut [Vec<f64>]) {
    match effect {
        HiddenEffect::TorqueGain { joint, gain } => tau[*joint].iter_mut().for_each(|t| *t *= gain),
        HiddenEffect::TorqueCrosstalk {
            joint,
            from,
            coefficient,
        } => {
            let source = tau[*from].clone();
            tau[*joint]
                .iter_mut()
                .zip(source)
                .for_each(|(t, other)| *t += coefficient * other);
        }
        _ => {}
    }
}
