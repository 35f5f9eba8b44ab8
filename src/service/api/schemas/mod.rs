//! What requests look like, for the documentation. Requests are read by [`crate::io`]; a test holds the two together.
#![allow(dead_code)]

mod excitation;
mod feasible;
mod identify;
mod knowledge;
mod model;
mod robot;

pub use excitation::*;
pub use feasible::*;
pub use identify::*;
pub use knowledge::*;
pub use model::*;
pub use robot::*;
