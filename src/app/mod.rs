//! Use cases as plain functions: progress and cancellation are handed in, errors carry stable codes.

mod error;
mod excite;
mod problem;

pub use error::{Code, Error};
pub use excite::{CancelFlag, Excited, excite};
pub use problem::{FieldError, Problem};
