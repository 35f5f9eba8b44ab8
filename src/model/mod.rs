//! The robot: kinematics, limits and declared friction of a serial arm, immutable once built.
//!
//! A robot is a chain of joints. Joint `j` moves about (revolute) or along (prismatic) the z axis of its own frame, which sits
//! at a fixed [`Transform`](crate::spatial::Transform) from the frame before it. Modified DH parameters ([`Mdh`]) are one way to
//! fill that transform, URDF and MJCF files ([`from_urdf`], [`from_mjcf`]) are others.

mod angles;
mod capsule;
mod error;
mod input_limits;
mod joint;
mod limits;
mod link_mesh;
mod link_tree;
mod mjcf;
mod notes;
mod robot;
mod shape;
mod urdf;
mod words;
mod xml;

pub use angles::Rounding;
pub use capsule::{Ball, Capsule};
pub use error::{FieldProblem, ModelError};
pub use input_limits::{INPUT_LIMITS, InputLimits};
pub use joint::{Axis, Joint, JointKind, LinkBounds, LinkPrior, Mdh};
pub use limits::Limits;
pub use link_mesh::LinkMesh;
pub use link_tree::{CarriedLinks, ChainEnds};
pub use mjcf::{from_mjcf, from_mjcf_shaped, mjcf_meshes};
pub use notes::Notes;
pub use robot::{Friction, Robot};
pub use urdf::INERTIA_ENTRIES;
pub use urdf::{
    NewBody, UrdfRobot, body_complaint, from_urdf, from_urdf_rounded, from_urdf_shaped, urdf_carried, urdf_meshes,
    urdf_with_bodies,
};
pub use words::{counted, decimals, readable, scientific, shortest, three_digits};
pub use xml::XmlText;
