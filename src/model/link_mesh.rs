//! A mesh that describes the shape of a link.

use crate::spatial::Transform;
use nalgebra::Vector3;

/// A mesh file and its place on a link.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkMesh {
    /// Name of the link.
    pub link: String,
    /// As the robot's file has it: `package://…`, `file://…`, or a path relative to that file.
    pub file: String,
    /// Pose in the file of the frame that the mesh is meant in; the identity but for MJCF's `refpos` and `refquat`.
    pub reference: Transform,
    /// Factors along the axes of that frame.
    pub scale: Vector3<f64>,
    /// Of that frame in the link's.
    pub pose: Transform,
}

impl LinkMesh {
    /// A point of the mesh file in the link's frame (m): `R S Rrᵀ (p − pr) + t`, with `R, t` of `pose`, `S` of `scale` and
    /// `Rr, pr` of `reference`.
    pub fn placed(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let meant = self.reference.rotation.transpose() * (point - self.reference.translation);
        self.pose.rotation * self.scale.component_mul(&meant) + self.pose.translation
    }
}
