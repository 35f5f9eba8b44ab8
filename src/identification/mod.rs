//! From an estimate to what is handed out of it: physically consistent bodies, and whether the log was good enough for the model.
//!
//! The pipeline from logs to a validated model is `app::identify`; preparing logs is [`crate::preparation`], estimating is
//! [`crate::regression`].

#[cfg(feature = "semidefinite")]
pub mod physical;
mod quality;

pub use quality::{Quality, QualityVerdict, quality};
