//! Ranges that parameters of effects have on robots, with their sources.
//!
//! Least squares finds a value for anything: on measured logs presliding widths of 3 rad and springs that rest 40 rad away have
//! come out, each an imitation of something that was not in the model. What the data put at an end of its range, or beyond, is
//! not named. Lengths and angles are those of the joint's side of the gear. Ranges are wide: values that have been published lie
//! well inside.

use crate::model::{JointKind, Robot};

/// Distance over which friction builds up after a reversal (rad): thousandths to hundredths on the joint's side. Dahl 1968 and
/// Armstrong-Hélouvry, Dupont & Canudas de Wit 1994 give micrometres to tens of them for a contact; gears, belts and seals that
/// wind up add arc minutes (catalogues of strain wave gears: hysteresis of 1 to 3).
pub const PRESLIDING_WIDTH_RAD: [f64; 2] = [1e-5, 0.1];
/// The same of a slide (m), with the wind-up of its screw or belt.
pub const PRESLIDING_WIDTH_M: [f64; 2] = [1e-7, 2e-3];

/// Speed over which the Stribeck peak falls off (rad/s). Bittencourt & Gunnarsson 2012 find hundredths to tenths of a rad/s on
/// the joint's side.
pub const STRIBECK_VELOCITY_RAD: [f64; 2] = [1e-3, 1.0];
/// The same of a slide (m/s): Armstrong-Hélouvry, Dupont & Canudas de Wit 1994, table 4, with a decade to spare.
pub const STRIBECK_VELOCITY_M: [f64; 2] = [1e-5, 0.5];
/// Exponent of the Stribeck peak: 1/2 to 2 are in use (Armstrong-Hélouvry, Dupont & Canudas de Wit 1994), and above 4 it is a
/// step.
pub const STRIBECK_EXPONENT: [f64; 2] = [0.4, 4.0];

/// Speed over which smoothed Coulomb friction grows (rad/s): simulators take 1e-4 to 0.1, creep of greased gears is of the order
/// of the Stribeck velocity.
pub const SMOOTHING_RAD: [f64; 2] = [1e-5, 0.5];
/// The same of a slide (m/s).
pub const SMOOTHING_M: [f64; 2] = [1e-6, 0.1];

/// Time by which the friction of a soft constraint is ahead of the speed (s): half its time constant, 0.02 s in MuJoCo unless
/// set, and never less than two time steps.
pub const FRICTION_LEAD: [f64; 2] = [1e-3, 0.1];

/// Exponent of speed in viscous friction: 0 and 1 are columns of the declared model; turbulent churning has 2, and nothing
/// published is above 3.
pub const VISCOUS_EXPONENT: [f64; 2] = [0.15, 5.0];

/// Part of the load that becomes friction: Hamon, Gautier et al. 2010 find a few per cent, worm gears reach a half.
pub const LOAD_FRICTION: [f64; 2] = [0.0, 0.6];

/// Ratio at which a motor turns with a second joint: wrists are 1 or −1 by their bevel gears (Gautier, Vandanjon & Janot 2011);
/// below a quarter it is hardly one.
pub const COUPLING_RATIO: [f64; 2] = [0.25, 3.0];

/// Compliance of a gear (rad per N m) in either direction of the search: softer than 100 N m/rad no robot's gear is (Spong 1987
/// and De Luca & Book 2016 have thousands to tens of thousands).
pub const COMPLIANCE_RAD: f64 = 1e-2;
/// Of a slide (m per N): softer than 1 N/mm no drive is.
pub const COMPLIANCE_M: f64 = 1e-3;

/// Delay of the torque stream (s), either way: transport takes a few control cycles, a filter of 5 Hz a twentieth of a second.
pub const DELAY: f64 = 0.1;

/// Error of an encoder's zero (rad): a lost mastering is a few degrees off (Khalil & Dombre 2004, chapter 11, calibrate tenths).
/// From 10° on it is another convention for the joint's angle.
pub const ENCODER_OFFSET_RAD: f64 = 0.1745;
/// Of a slide (m).
pub const ENCODER_OFFSET_M: f64 = 0.1;

/// Tilt of a base (rad): 10°. Beyond, the arm is mounted otherwise than described, and that is looked for over the whole sphere.
pub const TILT: f64 = 0.1745;

/// Factor on a torque channel, less one: Gautier & Briot 2014 correct drive gains by up to some ten per cent; half or double is
/// another unit.
pub const GAIN: f64 = 0.5;

/// Part of one torque in another's channel: sensors specify per cent; beyond that the channels are not the joints'.
pub const CROSSTALK: f64 = 0.6;

/// `angular` or `linear`, as the joint moves.
pub(super) fn by_kind<T>(robot: &Robot, joint: usize, angular: T, linear: T) -> T {
    match robot.joints()[joint].kind {
        JointKind::Revolute => angular,
        JointKind::Prismatic => linear,
    }
}
