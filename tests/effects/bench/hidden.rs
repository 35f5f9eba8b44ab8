//! Effects to hide in a log, at any size.

use super::noise_levels;
use dynident::effects::{Effect, all, by_code};
use dynident::model::Robot;
use dynident::simulate::{HiddenEffect, ListedEffect};
use rand::{Rng, RngExt};
use std::f64::consts::TAU;

/// A kind of effect on a joint, everything settled but its size.
#[derive(Debug, Clone)]
pub struct Hidden {
    pub code: &'static str,
    pub joint: usize,
    /// Where the effect has a second joint.
    pub other: usize,
    pub sign: f64,
    /// Where between its ends every shape parameter lies, 0 to 1.
    pub shape: [f64; 3],
    /// Noise of the joint over 0.2: sizes of torques go with it.
    level: f64,
    joints: usize,
    robot: Robot,
}

/// Torque that a joint of the bench carries, over its noise.
const TORQUE_OVER_NOISE: f64 = 50.0;

impl Hidden {
    /// In the middle of all shapes.
    pub fn plain(code: &'static str, joint: usize, robot: &Robot) -> Self {
        let joints = robot.joint_count();
        Self {
            code,
            joint,
            other: if joint + 1 < joints { joint + 1 } else { joint - 1 },
            sign: 1.0,
            shape: [0.5; 3],
            level: noise_levels(joints)[joint] / 0.2,
            joints,
            robot: robot.clone(),
        }
    }

    /// Any joint on which the effect can be seen, any sign, any shape.
    pub fn random(code: &'static str, robot: &Robot, rng: &mut impl Rng) -> Self {
        let joints = robot.joint_count();
        // Gravity does not see where the first joint's encoder begins. The base inertias of the first two joints hold their
        // rotors'.
        let first = match code {
            "encoder_offset" => 1,
            "rotor_inertia" => 2,
            _ => 0,
        };
        let joint = rng.random_range(first..joints);
        let apart = rng.random_range(1..joints);
        let other = match code {
            "transmission_coupling" if joint + 1 < joints => joint + 1,
            "transmission_coupling" => joint - 1,
            _ => (joint + apart) % joints,
        };
        Self {
            other,
            sign: if rng.random_range(0..2) == 0 { 1.0 } else { -1.0 },
            shape: std::array::from_fn(|_| rng.random_range(0.0..1.0)),
            ..Self::plain(code, joint, robot)
        }
    }

    /// Size beyond which nobody would speak of a small effect: a third of a gain, 30 ms, 6 degrees, a joint that
    /// springs in less than 7 Hz.
    pub fn largest(&self) -> f64 {
        match self.code {
            "torque_gain" => 6.0,
            "torque_delay" => 3.0,
            "base_tilt" => 4.0,
            "encoder_offset" => 5.0,
            "joint_elasticity" => [0.3, 0.3, 0.3, 0.5, 1.0, 1.0, 5.0][self.joint],
            "torque_crosstalk" | "load_dependent_friction" => 10.0,
            "payload" => 2.0,
            _ => 30.0,
        }
    }

    /// One of three, by a shape.
    fn of_three(&self, i: usize, values: [f64; 3]) -> f64 {
        values[((self.shape[i] * 3.0) as usize).min(2)]
    }

    /// An effect without a simulation of its own, in its simplest form.
    fn listed(&self, code: &str, size: f64) -> ListedEffect {
        let noise = noise_levels(self.robot.joint_count())[self.joint];
        let example = ListedEffect::example(code, &self.robot, self.joint, [noise, TORQUE_OVER_NOISE * noise]);
        let mut effect = example.unwrap_or_else(|| panic!("no effect `{code}` on joint {}", self.joint));
        let one_sided = by_code(code).is_some_and(|e| !e.positive(0).is_empty());
        let sign = if one_sided { 1.0 } else { self.sign };
        effect.coefficients.iter_mut().for_each(|c| *c *= sign * size);
        effect
    }

    /// At `size`: 1 is well visible.
    pub fn at(&self, size: f64) -> HiddenEffect {
        use HiddenEffect::*;
        let (joint, other, sign) = (self.joint, self.other, self.sign);
        let level = self.level * size;
        let [u, v, _] = self.shape;
        match self.code {
            "torque_offset" => TorqueOffset {
                joint,
                offset: sign * 0.3 * level,
            },
            "stribeck_friction" => StribeckFriction {
                joint,
                amplitude: 0.8 * level,
                velocity: 0.05 * 4f64.powf(u),
                exponent: self.of_three(1, [1.0, 2.0, 2.0]),
            },
            "nonlinear_viscous_friction" => NonlinearViscousFriction {
                joint,
                coefficient: sign * 0.8 * level,
                exponent: self.of_three(0, [0.5, 2.0, 3.0]),
            },
            "asymmetric_viscous_friction" => AsymmetricViscousFriction {
                joint,
                coefficient: sign * 0.5 * level,
            },
            "load_dependent_friction" => LoadDependentFriction {
                joint,
                coefficient: 0.04 * size,
            },
            "presliding_hysteresis" => PreslidingHysteresis {
                joint,
                amplitude: level,
                width: 0.005 * 16f64.powf(u),
            },
            "smooth_coulomb_friction" => SmoothCoulombFriction {
                joint,
                amplitude: level,
                velocity: 0.01 * 10f64.powf(u),
            },
            "rotor_inertia" => RotorInertia {
                joint,
                inertia: 0.3 * level,
            },
            "transmission_coupling" => TransmissionCoupling {
                joints: [joint.min(other), joint.max(other)],
                ratio: if u < 0.6 {
                    1.0
                } else if u < 0.8 {
                    -1.0
                } else {
                    0.5 + v
                },
                viscous: 0.4 * level,
                coulomb: 0.4 * level,
                inertia: 0.1 * level,
            },
            "joint_spring" => JointSpring {
                joint,
                stiffness: 1.5 * level,
                rest: u - 0.3,
            },
            "position_ripple" => PositionRipple {
                joint,
                amplitude: 0.2 * level,
                cycles: 5.0 * 22f64.powf(u),
                phase: 0.5 + (v - 0.5) * TAU,
            },
            "joint_elasticity" => JointElasticity {
                joint,
                stiffness: 4000.0 / size,
            },
            "encoder_offset" => EncoderOffset {
                joint,
                offset: sign * 0.03 * size,
            },
            "base_tilt" => {
                let (pitch, roll) = (
                    0.025 * size * (-0.6435 + (u - 0.5) * TAU).sin(),
                    0.025 * size * (-0.6435 + (u - 0.5) * TAU).cos(),
                );
                BaseTilt { roll, pitch }
            }
            "torque_delay" => TorqueDelay { seconds: 0.01 * size },
            "torque_gain" => TorqueGain {
                joint,
                gain: 1.0 + sign * 0.05 * size,
            },
            "torque_crosstalk" => TorqueCrosstalk {
                joint,
                from: other,
                coefficient: sign * 0.05 * size,
            },
            "friction_drift" => FrictionDrift {
                joint,
                viscous: 0.5 * level,
                coulomb: 0.5 * level,
                time_constant: 20.0 * 4f64.powf(u - 0.5),
            },
            "external_contact" => {
                let start = 23.0 + 20.0 * (u - 0.5);
                let torque = |j: usize| if j == joint { 2.0 * sign * level } else { 0.0 };
                ExternalContact {
                    start,
                    end: start + 4f64.powf(2.0 * (v - 0.5)),
                    torque: (0..self.joints).map(torque).collect(),
                }
            }
            "payload" => Payload {
                mass: 2.3 * size,
                center_of_mass: [0.06 * (u - 0.5), 0.03, 0.05 + 0.1 * v],
                inertia: [[0.005 * size, 0.0, 0.0], [0.0, 0.005 * size, 0.0], [0.0, 0.0, 0.003 * size]],
            },
            "unexplained" => Unmodelled {
                joints: [joint, other],
                amplitude: 1.5 * level,
            },
            code => Listed(self.listed(code, size)),
        }
    }
}

/// An effect on `joint` at `size`, in the middle of all shapes.
pub fn effect(code: &'static str, joint: usize, size: f64, robot: &Robot) -> HiddenEffect {
    Hidden::plain(code, joint, robot).at(size)
}

/// All that can be hidden in a log that no model is held against: the effects of the list, and one that is in no list.
pub fn codes() -> Vec<&'static str> {
    let listed = all().iter().map(|e| e.code()).filter(|code| *code != "payload");
    listed.chain(["unexplained"]).collect()
}
