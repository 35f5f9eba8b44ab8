//! Which way gravity points: a hypothesis over the whole sphere, tested before signs and order of the torque columns.
//!
//! The regressor is linear in gravity, so that sums of squares for all directions come from one quadratic form (`form`). Fourteen
//! directions (axes and space diagonals) are starting points; those that leave least are refined. On slow motions the opposite
//! direction fits nearly as well, with all first moments turned round: then it decides that masses are positive and lie along the
//! arm (`vote`).

mod direction;
mod evidence;
mod form;
mod refine;
mod search;
mod vote;

pub use refine::{Gravity, diagnose_mounted};
pub use search::{Mounting, mounting, mounting_until};
