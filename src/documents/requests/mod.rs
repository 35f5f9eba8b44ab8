//! Requests as they are written: one type per object, which is its schema in the OpenAPI document and the list of its fields.
//!
//! Readers beside this folder go through a document field by field ([`Cursor`](super::Cursor)), so that all that is wrong with it
//! is said at once.

mod excitation;
mod feasible;
mod identify;
mod knowledge;
mod model;
mod motion;
mod own_effect;
mod robot;
mod words;

pub use excitation::*;
pub use feasible::*;
pub use identify::*;
pub use knowledge::*;
pub use model::*;
pub use motion::*;
pub use own_effect::*;
pub use robot::*;
