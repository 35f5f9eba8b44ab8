//! Rigid transforms and rigid-body inertia: the geometry everything else is written in.

mod inertia;
mod transform;

pub use inertia::{LinkInertia, PhysicalInertia};
pub use transform::Transform;
