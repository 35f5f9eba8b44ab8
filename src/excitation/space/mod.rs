//! Where the arm may be: off the floor, the table, the wall, and off itself.
//!
//! Links are capsules. Every pair of a link's capsule and an obstacle, or of two links' capsules, has a distance whose derivative
//! by the joint positions is exact; the search keeps it above the clearance like a torque below its limit ([`super::path`]), and
//! a finished trajectory is proven to keep it at all times ([`certify`]).

mod certify;
mod distance;
mod pairs;

pub use certify::Clearance;
pub(super) use certify::certified_clearances;
pub(super) use pairs::SpaceSet;

use nalgebra::Vector3;

/// Obstacles and self-collision to avoid, in the base frame.
#[derive(Debug, Clone, PartialEq)]
pub struct SpaceLimits {
    /// Least distance kept from everything (m).
    pub clearance: f64,
    /// Planes that the arm stays on one side of.
    pub half_spaces: Vec<HalfSpace>,
    /// Boxes that the arm avoids.
    pub boxes: Vec<Obstacle>,
    /// Whether collisions of the arm with itself are avoided, and how.
    pub self_collision: Option<SelfCollision>,
}

/// The arm stays where `normal · p ≥ offset`: a floor has the normal (0, 0, 1) and its height as offset.
#[derive(Debug, Clone, PartialEq)]
pub struct HalfSpace {
    /// Name in documents and reports.
    pub name: String,
    /// Unit vector out of the plane, in the base frame.
    pub normal: Vector3<f64>,
    /// Distance of the plane from the origin along the normal (m).
    pub offset: f64,
}

/// A box with edges along the axes of the base frame that the arm stays out of.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// Name in documents and reports.
    pub name: String,
    /// (m)
    pub center: Vector3<f64>,
    /// Lengths of the edges (m).
    pub size: Vector3<f64>,
}

/// Links avoid each other, except neighbours and the pairs named here (joint numbers from 0, the smaller first).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SelfCollision {
    /// Pairs of links that are not looked at, beside neighbours.
    pub ignored: Vec<(usize, usize)>,
}

/// Clearance where none is asked for (m): what paths of real arms deviate from commanded ones at full speed, and play in a
/// model's shapes.
pub const DEFAULT_CLEARANCE_M: f64 = 0.02;
