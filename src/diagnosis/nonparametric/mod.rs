//! What no effect explains: smooth functions of one or two variables stand in for the unknown cause, and compete with the effects
//! found.

mod bic;
mod matching_pursuit;
mod remainder;

pub(crate) use bic::{Rivalling, score_of};
pub(crate) use matching_pursuit::{excess, function_columns, function_jobs, pursue};
pub(crate) use remainder::{examine, unaccounted};
