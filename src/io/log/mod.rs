//! Reading logs: CSV, plain or gzip, in one pass.
//!
//! [`read_log`] streams the rows into columns of doubles (`blocks`: several threads parse while another reads), `time_base` lays them onto a uniform grid in time, and whatever was
//! found on the way (garbage, repeats, gaps, jitter) is told in the [`LogReport`] with the line numbers and what was done.

mod blocks;
mod columns;
mod error;
mod fields;
mod header;
mod places;
mod reader;
mod report;
mod rows;
mod table;
mod time_base;
mod time_unit;
mod unpack;

pub use columns::{Columns, JointColumns, TimeUnit, Transformation};
pub use error::LogError;
pub use header::{FoundColumns, found_columns};
pub use reader::{Source, read_joined_log, read_log, read_log_file};
pub use report::{Finding, FindingKind, LogReport};
pub use time_unit::PLAUSIBLE_HZ;
