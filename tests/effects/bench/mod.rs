//! Virtual robots on random trajectories, and the tracing of their logs.
#![allow(dead_code, unused_imports)]

mod hidden;
mod motion;
mod record;
mod robots;

pub use hidden::*;
pub use motion::*;
pub use record::*;
pub use robots::*;
