//! The numerical core of [dynident](https://docs.rs/dynident): everything that is pure. No clock, no environment, no files,
//! nothing asynchronous; seeds, progress and cancellation are handed in. The crate `dynident` hands all of it on and documents
//! it.

#![warn(missing_docs)]

pub mod cancel;
pub mod diagnosis;
pub mod dynamics;
pub mod effects;
pub mod excitation;
pub mod identification;
pub mod model;
pub mod parameters;
pub mod preparation;
pub mod regression;
pub mod simulate;
pub mod solver;
pub mod spatial;
pub mod trajectory;
