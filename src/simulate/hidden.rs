//! Effects that a virtual robot can have and nobody declares.

use serde::Deserialize;

/// One physical effect with its true values; joints count from 0.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "effect", rename_all = "snake_case", deny_unknown_fields)]
pub enum HiddenEffect {
    /// A constant torque [N·m or N].
    TorqueOffset { joint: usize, offset: f64 },
    /// `amplitude · exp(−(|qd|/velocity)^exponent) sign qd`.
    StribeckFriction {
        joint: usize,
        amplitude: f64,
        velocity: f64,
        exponent: f64,
    },
    /// `coefficient · |qd|^exponent sign qd`.
    NonlinearViscousFriction { joint: usize, coefficient: f64, exponent: f64 },
    /// `coefficient · |qd|`.
    AsymmetricViscousFriction { joint: usize, coefficient: f64 },
    /// `coefficient · |rigid torque| sign qd`.
    LoadDependentFriction { joint: usize, coefficient: f64 },
    /// Dahl's friction of this level in addition to an equally lower Coulomb friction; `width` in rad or m.
    PreslidingHysteresis { joint: usize, amplitude: f64, width: f64 },
    /// Coulomb friction of this level that goes through zero as `tanh(qd/velocity)`, in addition to an equally lower one that jumps.
    SmoothCoulombFriction { joint: usize, amplitude: f64, velocity: f64 },
    /// `inertia · qdd` [kg m² or kg].
    RotorInertia { joint: usize, inertia: f64 },
    /// A rotor that turns with `qd_first + ratio · qd_second`.
    TransmissionCoupling {
        joints: [usize; 2],
        ratio: f64,
        viscous: f64,
        coulomb: f64,
        inertia: f64,
    },
    /// `stiffness · (q − rest)`.
    JointSpring { joint: usize, stiffness: f64, rest: f64 },
    /// `amplitude · sin(cycles · q + phase)`.
    PositionRipple {
        joint: usize,
        amplitude: f64,
        cycles: f64,
        phase: f64,
    },
    /// Encoder on the motor side of a spring [N·m/rad].
    JointElasticity { joint: usize, stiffness: f64 },
    /// True position = reading + offset.
    EncoderOffset { joint: usize, offset: f64 },
    /// Base turned by roll about x, then pitch about y (rad).
    BaseTilt { roll: f64, pitch: f64 },
    /// A body in the last link's frame; inertia about its centre of mass.
    Payload {
        mass: f64,
        center_of_mass: [f64; 3],
        inertia: [[f64; 3]; 3],
    },
    /// Torque stream late by so many seconds.
    TorqueDelay { seconds: f64 },
    /// Torque reading of a joint multiplied.
    TorqueGain { joint: usize, gain: f64 },
    /// A part of one joint's torque in another's reading.
    TorqueCrosstalk { joint: usize, from: usize, coefficient: f64 },
    /// Extra friction that dies out, `exp(−t/time_constant)`, as a cold gear warms up.
    FrictionDrift {
        joint: usize,
        viscous: f64,
        coulomb: f64,
        time_constant: f64,
    },
    /// Constant torques on all joints between two times.
    ExternalContact { start: f64, end: f64, torque: Vec<f64> },
    /// A torque that dies out whatever the robot does, `torque · exp(−t/time_constant)`, as a sensor's zero that drifts while it warms up [N·m or N].
    TorqueDrift { joint: usize, torque: f64, time_constant: f64 },
    /// Something nobody has a model of: `amplitude · sin(2 q_a) cos(3 q_b)` on joint a.
    Unmodelled { joints: [usize; 2], amplitude: f64 },
}
