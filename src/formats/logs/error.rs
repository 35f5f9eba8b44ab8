//! Why a file is not a log.

use crate::formats::shortest;
use crate::model::scientific;
use thiserror::Error;

/// A log that cannot be used. Every variant names the file, the place and the remedy.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LogError {
    #[error("{file}: cannot be read: {detail}")]
    Unreadable { file: String, detail: String },
    #[error("{file}: is empty; a log has a header line and one row per sample")]
    Empty { file: String },
    #[error(
        "{file}: the compressed data end in the middle, after line {line}: the upload or copy was cut off; send the file again"
    )]
    CutOff { file: String, line: u64 },
    #[error("{file} is {what}; {remedy}")]
    Foreign {
        file: String,
        what: &'static str,
        remedy: &'static str,
    },
    #[error(
        "{file}, line 1: has no header but numbers; put a header line first, such as {example}, or name its columns in `columns`: they are called \
         column1 to column{columns}"
    )]
    NoHeader { file: String, example: String, columns: usize },
    #[error(
        "{}: no column for {}; found {}; {remedy}",
        place(.file, .line), .missing.join(", "), .found.join(", ")
    )]
    MissingColumns {
        file: String,
        /// Of the header; `None` where it is no text.
        line: Option<u64>,
        missing: Vec<String>,
        found: Vec<String>,
        remedy: String,
    },
    #[error("{file}: the column `{column}` is in {unit:?}, which is no unit of {quantity}; {remedy}")]
    ForeignUnit {
        file: String,
        column: String,
        unit: String,
        quantity: &'static str,
        remedy: &'static str,
    },
    #[error("{file}: is damaged, or no {format} that can be read: {detail}; {remedy}")]
    Damaged {
        file: String,
        format: &'static str,
        detail: String,
        remedy: &'static str,
    },
    #[error("{file}: holds no columns of numbers: {detail}")]
    NoSeries { file: String, detail: String },
    #[error("{file}: has more than {limit} numbers of {what}; leave out what is not needed, or split the log")]
    TooLarge { file: String, what: &'static str, limit: u64 },
    #[error("{file}, line 1: the header is longer than {limit} bytes; a log is text with one line per sample")]
    LongHeader { file: String, limit: usize },
    #[error("{file}: has {columns} columns, the most accepted is {limit}; leave out what is not needed")]
    TooManyColumns { file: String, columns: usize, limit: usize },
    #[error("{file}, line {line}: is longer than any row of numbers; a log is text with one line per sample")]
    LongLine { file: String, line: u64 },
    #[error("{file}: `columns` places a quantity in the file `{other}`, which is not among the logs; give it as one more log")]
    MissingFile { file: String, other: String },
    #[error(
        "{file} has {rows} rows and {other}, which `columns` puts beside it, {other_rows}; files are joined row by row: give files of one recording"
    )]
    RowsDiffer {
        file: String,
        rows: usize,
        other: String,
        other_rows: usize,
    },
    #[error("{file}: the column `{column}` appears {times} times; rename all but one")]
    RepeatedColumn { file: String, column: String, times: usize },
    #[error("{file}: has no time column and `columns` gives no sample_rate_hz; give one of them")]
    NoTimeBase { file: String },
    #[error("{file}: has {rows} usable rows, fewer than the {least} that a motion needs")]
    TooShort { file: String, rows: usize, least: usize },
    #[error(
        "{file}: {garbage} of {rows} rows are not rows of numbers, first at {counted} {line} ({what}); more than one in {limit} is refused: \
         check delimiter, decimal sign and export"
    )]
    TooMuchGarbage {
        file: String,
        garbage: usize,
        rows: usize,
        counted: &'static str,
        line: u64,
        what: String,
        limit: usize,
    },
    #[error(
        "{file}, {counted} {line}: time goes back from {from:?} s to {to:?} s, and {count} of {rows} rows come out of order; one log holds one \
         recording: split the file there, or sort it"
    )]
    TimeGoesBack {
        file: String,
        counted: &'static str,
        line: u64,
        from: f64,
        to: f64,
        count: usize,
        rows: usize,
    },
    #[error(
        "{file}: {} s of {} s are missing between time stamps, the longest gap after {counted} {line}, from {} s to {} s: \
         correct the stamp in the {counted} after it, or record again without losing samples",
        thousandths(.missing_s), thousandths(.total_s), thousandths(.from), thousandths(.to)
    )]
    TooManyGaps {
        file: String,
        missing_s: f64,
        total_s: f64,
        counted: &'static str,
        line: u64,
        /// Ends of the longest gap.
        from: f64,
        to: f64,
    },
    #[error(
        "{file}: the time stamps give a sample rate of {} Hz; a motion is sampled between 5 Hz and 100 kHz: state the unit of the stamps \
         in `columns` as `time_unit` (s, ms, us or ns), or their rate as `sample_rate_hz` without a time column",
        hertz(.rate_hz)
    )]
    ImplausibleRate { file: String, rate_hz: f64 },
    #[error(
        "{file}: the time stamps give a sample rate of {} Hz, and `columns` states {stated_hz} Hz: correct `sample_rate_hz`, or state \
         the unit of the stamps as `time_unit` (s, ms, us or ns)",
        hertz(.rate_hz)
    )]
    RateDiffers { file: String, rate_hz: f64, stated_hz: f64 },
    #[error(
        "{file}, {counted} {line}: the column `{column}` has {} in SI, and in more than one row of twenty values that are no {quantity} of an arm (beyond \
         {limit:e} in SI): choose the right column, or state its `unit` or `scale`, in `columns`",
        beyond(*.value)
    )]
    Implausible {
        file: String,
        counted: &'static str,
        line: u64,
        column: String,
        /// In SI.
        value: f64,
        quantity: &'static str,
        limit: f64,
    },
    #[error(
        "{file}, {counted} {line}: the time stamp {} s is no time of a recording: correct or remove the row, or state the unit of the stamps as \
         `time_unit`",
        beyond(*.value)
    )]
    ImplausibleTime {
        file: String,
        counted: &'static str,
        line: u64,
        value: f64,
    },
    #[error("{file}: has more than {limit} rows; lower the sample rate or split the log")]
    TooLong { file: String, limit: usize },
}

fn hertz(rate: &f64) -> String {
    scientific(*rate, 4)
}

/// A value that no arm has.
pub(super) fn beyond(value: f64) -> String {
    match value.is_finite() {
        true => scientific(value, 4),
        false => "a value beyond 1e308".into(),
    }
}

/// To a thousandth, where that is a number of digits that anybody reads.
fn thousandths(value: &f64) -> String {
    let rounded = (value * 1e3).round() / 1e3;
    shortest(if rounded.is_finite() { rounded } else { *value })
}

fn place(file: &str, line: &Option<u64>) -> String {
    line.map_or_else(|| file.to_string(), |line| format!("{file}, line {line}"))
}

impl LogError {
    pub fn file(&self) -> &str {
        match self {
            Self::Unreadable { file, .. }
            | Self::Empty { file }
            | Self::CutOff { file, .. }
            | Self::NoHeader { file, .. }
            | Self::MissingColumns { file, .. }
            | Self::RepeatedColumn { file, .. }
            | Self::LongHeader { file, .. }
            | Self::Foreign { file, .. }
            | Self::ForeignUnit { file, .. }
            | Self::Damaged { file, .. }
            | Self::NoSeries { file, .. }
            | Self::TooLarge { file, .. }
            | Self::TooManyColumns { file, .. }
            | Self::RateDiffers { file, .. }
            | Self::LongLine { file, .. }
            | Self::MissingFile { file, .. }
            | Self::RowsDiffer { file, .. }
            | Self::NoTimeBase { file }
            | Self::TooShort { file, .. }
            | Self::TooMuchGarbage { file, .. }
            | Self::TimeGoesBack { file, .. }
            | Self::TooManyGaps { file, .. }
            | Self::ImplausibleRate { file, .. }
            | Self::Implausible { file, .. }
            | Self::ImplausibleTime { file, .. }
            | Self::TooLong { file, .. } => file,
        }
    }

    /// The same error about the file under another name (an upload is a temporary file with a name of its own).
    pub fn named(mut self, name: &str) -> Self {
        *self.file_mut() = name.to_string();
        self
    }

    fn file_mut(&mut self) -> &mut String {
        match self {
            Self::Unreadable { file, .. }
            | Self::Empty { file }
            | Self::CutOff { file, .. }
            | Self::NoHeader { file, .. }
            | Self::MissingColumns { file, .. }
            | Self::RepeatedColumn { file, .. }
            | Self::LongHeader { file, .. }
            | Self::Foreign { file, .. }
            | Self::ForeignUnit { file, .. }
            | Self::Damaged { file, .. }
            | Self::NoSeries { file, .. }
            | Self::TooLarge { file, .. }
            | Self::TooManyColumns { file, .. }
            | Self::RateDiffers { file, .. }
            | Self::LongLine { file, .. }
            | Self::MissingFile { file, .. }
            | Self::RowsDiffer { file, .. }
            | Self::NoTimeBase { file }
            | Self::TooShort { file, .. }
            | Self::TooMuchGarbage { file, .. }
            | Self::TimeGoesBack { file, .. }
            | Self::TooManyGaps { file, .. }
            | Self::ImplausibleRate { file, .. }
            | Self::Implausible { file, .. }
            | Self::ImplausibleTime { file, .. }
            | Self::TooLong { file, .. } => file,
        }
    }
}
