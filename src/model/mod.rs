//! The robot: kinematics, limits and declared friction of a serial arm, immutable once built.
//!
//! A robot is a chain of joints. Joint `j` moves about (revolute) or along (prismatic) the z axis of its own frame, which sits
//! at a fixed [`Transform`](crate::spatial::Transform) from the frame before it. Modified DH parameters ([`Mdh`]) are one way to
//! fill that transform, a URDF file ([`from_urdf`]) another.

mod capsule;
mod error;
mod joint;
mod limits;
mod robot;
mod urdf;
mod urdf_elements;

pub use capsule::Capsule;
pub use error::{FieldProblem, ModelError};
pub use joint::{Axis, Joint, JointKind, LinkBounds, LinkPrior, Mdh};
pub use limits::Limits;
pub use robot::{Friction, Robot};
pub use urdf::{UrdfRobot, from_urdf};
