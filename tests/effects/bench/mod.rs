//! Virtual robots on random trajectories, and the tracing of their logs.
#![allow(dead_code, unused_imports)]

mod calibration;
mod hidden;
mod motion;
mod record;
mod robots;

pub use calibration::*;
pub use hidden::*;
pub use motion::*;
pub use record::*;
pub use robots::*;
