//! Data faults: what is checked before any effect is blamed.
//!
//! Faults of single samples (garbage, frozen, clipped, repeated times) are looked for in the columns themselves. Faults of whole
//! columns (sign, order, unit) are hypotheses about the data that the rigid model can weigh: the sum of squares that least
//! squares leaves, for every sign and every exchange of torque columns, is a quadratic form in the columns projected once.

mod clipping;
mod columns;
mod compensated;
mod currents;
mod evidence;
mod fault;
mod frozen;
mod garbage;
mod order;
mod permuted;
mod raw_log;
mod reading;
mod samples;
mod seen;
mod sign;

pub use columns::{column_faults, column_faults_until};
pub use fault::{DataFault, FaultKind, Remedy};
pub use raw_log::RawLog;
pub use samples::{LostRows, leave_out, lost_rows, sample_faults};
