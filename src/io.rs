//! Files and documents to and from the types of the core, and the use cases on them. The crate `dynident` hands all of it on and
//! documents it.

#![warn(missing_docs)]

pub mod app;
pub mod documents;
pub mod formats;

// The core, under the names that it has everywhere.
#[doc(hidden)]
pub use dynident_core::{
    cancel, diagnosis, dynamics, effects, excitation, identification, model, parameters, preparation, regression, simulate,
    solver, spatial, trajectory,
};
