//! Reading logs: tables of text in any dialect, NPZ, MATLAB, Parquet, MCAP and rosbag2, plain or packed by gzip or Zstandard.
//!
//! What a file is, its first bytes say (`kind`). Of a text, `dialect` finds separator, decimal sign and header; `names` knows the
//! columns of well-known programs. [`read_log`] streams the rows into columns of doubles (`blocks`: several threads parse while
//! another reads), `time_base` lays them onto a uniform grid in time, and whatever was found on the way (garbage, repeats, gaps,
//! jitter) is reported in the [`LogReport`] with the line numbers and what was done.

#[cfg(feature = "formats")]
mod binary;
mod blocks;
mod columns;
mod dialect;
mod error;
mod fields;
mod header;
mod kind;
mod lists;
mod names;
mod overview;
mod places;
mod plausible;
mod reader;
mod report;
mod rows;
mod sheet;
mod table;
mod text;
mod time_base;
mod time_unit;
mod unpack;

pub use columns::{ChannelColumn, Columns, JointColumns, TimeUnit, Transformation};
pub use error::LogError;
pub use header::{FoundColumns, found_columns};
pub use overview::{LogColumn, LogOverview, log_overview};
pub use reader::{Rows, Source, read_joined_log, read_joined_log_until, read_log, read_log_file, rows_of};
pub use report::{Finding, FindingKind, LogReport};
pub use time_unit::PLAUSIBLE_HZ;
