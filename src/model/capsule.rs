//! Shapes of links, for keeping the arm off its surroundings and off itself.

use nalgebra::Vector3;

/// All points within `radius` of the segment between two points fixed to a link. Chosen generously it contains the link; distances
/// between two of them, and their derivatives, are exact and cheap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule {
    /// Ends of the segment in the link frame of the dynamics (m).
    pub ends: [Vector3<f64>; 2],
    /// (m)
    pub radius: f64,
}
