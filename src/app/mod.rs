//! Use cases as plain functions: progress and cancellation are handed in, errors carry stable codes.

mod detectable;
mod diagnose;
mod error;
mod excite;
mod identify;
mod inspect;
mod motion;
mod own_effects;
mod problem;
mod provenance;
mod report;
mod series;
mod tell;
mod validate;

pub use crate::cancel::CancelFlag;
pub use error::{Code, Error};
pub use excite::{Exchange, Excited, Runs, excite, excite_beside, runs};
pub use identify::{Identified, LogFile, ModelFiles, Step, UsedLog, identify};
pub use inspect::inspect;
pub use motion::motion;
pub use problem::{FieldError, ProblemDetails};
pub use series::drawn;
pub use validate::{Validated, validate};
