//! Effects that a virtual robot can have and nobody declares.

use super::ListedEffect;
use serde::Deserialize;

/// One physical effect with its true values; joints count from 0.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "effect", rename_all = "snake_case", deny_unknown_fields)]
pub enum HiddenEffect {
    /// A constant torque [N·m or N].
    TorqueOffset {
        /// Number of the joint, from 0.
        joint: usize,
        /// The torque [N·m or N].
        offset: f64,
    },
    /// `amplitude · exp(−(|qd|/velocity)^exponent) sign qd`.
    StribeckFriction {
        /// Number of the joint, from 0.
        joint: usize,
        /// Friction at the onset of motion above Coulomb friction [N·m or N].
        amplitude: f64,
        /// Speed at which it has fallen to 1/e [rad/s or m/s].
        velocity: f64,
        /// How it falls: 1 as an exponential, 2 as a Gaussian.
        exponent: f64,
    },
    /// `coefficient · |qd|^exponent sign qd`.
    NonlinearViscousFriction {
        /// Number of the joint, from 0.
        joint: usize,
        /// Torque at unit speed [N·m or N].
        coefficient: f64,
        /// Power of the speed.
        exponent: f64,
    },
    /// `coefficient · |qd|`.
    AsymmetricViscousFriction {
        /// Number of the joint, from 0.
        joint: usize,
        /// Half the difference of viscous friction forwards and backwards [N·m s/rad or N s/m].
        coefficient: f64,
    },
    /// `coefficient · |rigid torque| sign qd`.
    LoadDependentFriction {
        /// Number of the joint, from 0.
        joint: usize,
        /// Friction per unit of torque.
        coefficient: f64,
    },
    /// Dahl's friction of this level in addition to an equally lower Coulomb friction; `width` in rad or m.
    PreslidingHysteresis {
        /// Number of the joint, from 0.
        joint: usize,
        /// Level of the friction [N·m or N].
        amplitude: f64,
        /// Way after a reversal over which it builds up [rad or m].
        width: f64,
    },
    /// Coulomb friction of this level that goes through zero as `tanh(qd/velocity)`, in addition to an equally lower one that
    /// jumps.
    SmoothCoulombFriction {
        /// Number of the joint, from 0.
        joint: usize,
        /// Level of the friction [N·m or N].
        amplitude: f64,
        /// Speed at which it has reached 76 % of its level [rad/s or m/s].
        velocity: f64,
    },
    /// `inertia · qdd` [kg m² or kg].
    RotorInertia {
        /// Number of the joint, from 0.
        joint: usize,
        /// Inertia of the rotor on the side of the link [kg m² or kg].
        inertia: f64,
    },
    /// A rotor that turns with `qd_first + ratio · qd_second`.
    TransmissionCoupling {
        /// The two joints, from 0.
        joints: [usize; 2],
        /// Turns of the rotor per turn of the second joint.
        ratio: f64,
        /// Viscous friction of the rotor [N·m s/rad].
        viscous: f64,
        /// Coulomb friction of the rotor [N·m].
        coulomb: f64,
        /// Inertia of the rotor [kg m²].
        inertia: f64,
    },
    /// `stiffness · (q − rest)`.
    JointSpring {
        /// Number of the joint, from 0.
        joint: usize,
        /// Stiffness [N·m/rad or N/m].
        stiffness: f64,
        /// Position without torque [rad or m].
        rest: f64,
    },
    /// `amplitude · sin(cycles · q + phase)`.
    PositionRipple {
        /// Number of the joint, from 0.
        joint: usize,
        /// Amplitude [N·m or N].
        amplitude: f64,
        /// Waves over 2π of the position (2π rad or 2π m).
        cycles: f64,
        /// Phase at position zero (rad).
        phase: f64,
    },
    /// Encoder on the motor side of a spring [N·m/rad].
    JointElasticity {
        /// Number of the joint, from 0.
        joint: usize,
        /// Stiffness between motor and link [N·m/rad or N/m].
        stiffness: f64,
    },
    /// True position = reading + offset.
    EncoderOffset {
        /// Number of the joint, from 0.
        joint: usize,
        /// True position less the reading [rad or m].
        offset: f64,
    },
    /// Base turned by roll about x, then pitch about y (rad).
    BaseTilt {
        /// Angle about x (rad).
        roll: f64,
        /// Angle about y, after roll (rad).
        pitch: f64,
    },
    /// A body in the last link's frame; inertia about its centre of mass.
    Payload {
        /// Mass (kg).
        mass: f64,
        /// Centre of mass in the last link's frame (m).
        center_of_mass: [f64; 3],
        /// Inertia about the centre of mass [kg m²].
        inertia: [[f64; 3]; 3],
    },
    /// Torque stream late by so many seconds.
    TorqueDelay {
        /// The delay (s).
        seconds: f64,
    },
    /// Torque reading of a joint multiplied.
    TorqueGain {
        /// Number of the joint, from 0.
        joint: usize,
        /// Reading over true torque.
        gain: f64,
    },
    /// A part of one joint's torque in another's reading.
    TorqueCrosstalk {
        /// Joint whose reading is off, from 0.
        joint: usize,
        /// Joint whose torque is in it, from 0.
        from: usize,
        /// Part of that torque.
        coefficient: f64,
    },
    /// Extra friction that dies out, `exp(−t/time_constant)`, as a cold gear warms up.
    FrictionDrift {
        /// Number of the joint, from 0.
        joint: usize,
        /// Extra viscous friction at the beginning [N·m s/rad or N s/m].
        viscous: f64,
        /// Extra Coulomb friction at the beginning [N·m or N].
        coulomb: f64,
        /// Time in which it falls to 1/e (s).
        time_constant: f64,
    },
    /// Constant torques on all joints between two times.
    ExternalContact {
        /// When it begins (s).
        start: f64,
        /// When it ends (s).
        end: f64,
        /// Torque on every joint [N·m or N].
        torque: Vec<f64>,
    },
    /// A torque that dies out whatever the robot does, `torque · exp(−t/time_constant)`, as a sensor's zero that drifts while it
    /// warms up [N·m or N].
    TorqueDrift {
        /// Number of the joint, from 0.
        joint: usize,
        /// Torque at the beginning [N·m or N].
        torque: f64,
        /// Time in which it falls to 1/e (s).
        time_constant: f64,
    },
    /// Any other effect of the list, by its columns.
    Listed(ListedEffect),
    /// Something nobody has a model of: `amplitude · sin(2 q_a) cos(3 q_b)` on joint a.
    Unmodelled {
        /// Joints a and b, from 0.
        joints: [usize; 2],
        /// Amplitude [N·m or N].
        amplitude: f64,
    },
}
