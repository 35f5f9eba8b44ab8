//! Why a file is not a log.

use crate::formats::shortest;
use crate::model::scientific;
use thiserror::Error;

/// A log that cannot be used. Every variant names the file, the place and the remedy.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LogError {
    /// The file cannot be opened or read.
    #[error("{file}: cannot be read: {detail}")]
    Unreadable {
        /// Name of the file.
        file: String,
        /// What exactly is wrong.
        detail: String,
    },
    /// The file has no bytes, or no rows.
    #[error("{file}: is empty; a log has a header line and one row per sample")]
    Empty {
        /// Name of the file.
        file: String,
    },
    /// The compressed data end too early.
    #[error(
        "{file}: the compressed data end in the middle, after line {line}: the upload or copy was cut off; send the file again"
    )]
    CutOff {
        /// Name of the file.
        file: String,
        /// Number of the line or row, from 1.
        line: u64,
    },
    /// The file is of another kind, such as a picture or a robot.
    #[error("{file} is {what}; {remedy}")]
    Foreign {
        /// Name of the file.
        file: String,
        /// What was found instead.
        what: &'static str,
        /// What to do about it.
        remedy: &'static str,
    },
    /// The first line of a text log is numbers.
    #[error(
        "{file}, line 1: has no header but numbers; put a header line first, such as {example}, or name its columns in `columns`: they are called \
         column1 to column{columns}"
    )]
    NoHeader {
        /// Name of the file.
        file: String,
        /// A header that would be accepted.
        example: String,
        /// Number of columns.
        columns: usize,
    },
    /// A further quantity has no numbers.
    #[error("{file}: column `{column}` has no numbers; leave it out of `columns.channels`, or name the column that has them")]
    EmptyChannel {
        /// Name of the file.
        file: String,
        /// Its header.
        column: String,
    },
    /// Joints have no column of a quantity.
    #[error(
        "{}: no column for {}; found {}; {remedy}",
        place(.file, .line), .missing.join(", "), .found.join(", ")
    )]
    MissingColumns {
        /// Name of the file.
        file: String,
        /// Of the header; `None` where it is no text.
        line: Option<u64>,
        /// What has no column.
        missing: Vec<String>,
        /// Names of the columns there are.
        found: Vec<String>,
        /// What to do about it.
        remedy: String,
    },
    /// The unit in the name of a column does not fit the quantity.
    #[error("{file}: the column `{column}` is in {unit:?}, which is no unit of {quantity}; {remedy}")]
    ForeignUnit {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
        /// The unit as it is written.
        unit: String,
        /// The quantity that the column is used for.
        quantity: &'static str,
        /// What to do about it.
        remedy: &'static str,
    },
    /// The content contradicts its format.
    #[error("{file}: is damaged, or no {format} that can be read: {detail}; {remedy}")]
    Damaged {
        /// Name of the file.
        file: String,
        /// Name of the format.
        format: &'static str,
        /// What exactly is wrong.
        detail: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// The file has no columns of numbers.
    #[error("{file}: holds no columns of numbers: {detail}")]
    NoSeries {
        /// Name of the file.
        file: String,
        /// What exactly is wrong.
        detail: String,
    },
    /// More numbers than are read into memory.
    #[error("{file}: has more than {limit} numbers of {what}; leave out what is not needed, or split the log")]
    TooLarge {
        /// Name of the file.
        file: String,
        /// What was found instead.
        what: &'static str,
        /// Largest accepted number or size.
        limit: u64,
    },
    /// The header exceeds the longest accepted line.
    #[error("{file}, line 1: the header is longer than {limit} bytes; a log is text with one line per sample")]
    LongHeader {
        /// Name of the file.
        file: String,
        /// Largest accepted number or size.
        limit: usize,
    },
    /// More columns than are accepted.
    #[error("{file}: has {columns} columns, the most accepted is {limit}; leave out what is not needed")]
    TooManyColumns {
        /// Name of the file.
        file: String,
        /// Number of columns.
        columns: usize,
        /// Largest accepted number or size.
        limit: usize,
    },
    /// A row exceeds the longest accepted line.
    #[error("{file}, line {line}: is longer than any row of numbers; a log is text with one line per sample")]
    LongLine {
        /// Name of the file.
        file: String,
        /// Number of the line or row, from 1.
        line: u64,
    },
    /// A quantity is placed in a file that was not given.
    #[error("{file}: `columns` places a quantity in the file `{other}`, which is not among the logs; give it as one more log")]
    MissingFile {
        /// Name of the file.
        file: String,
        /// Name of the other file.
        other: String,
    },
    /// Files that are joined row by row differ in length.
    #[error(
        "{file} has {rows} rows and {other}, which `columns` puts beside it, {other_rows}; files are joined row by row: give files of one recording"
    )]
    RowsDiffer {
        /// Name of the file.
        file: String,
        /// Number of rows.
        rows: usize,
        /// Name of the other file.
        other: String,
        /// Number of rows in the other file.
        other_rows: usize,
    },
    /// Two columns have one name.
    #[error("{file}: the column `{column}` appears {times} times; rename all but one")]
    RepeatedColumn {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
        /// How many columns have the name.
        times: usize,
    },
    /// There are neither time stamps nor a sample rate.
    #[error("{file}: has no time column and `columns` gives no sample_rate_hz; give one of them")]
    NoTimeBase {
        /// Name of the file.
        file: String,
    },
    /// Too few rows are left.
    #[error("{file}: has {rows} usable rows, fewer than the {least} that a motion needs")]
    TooShort {
        /// Name of the file.
        file: String,
        /// Number of rows.
        rows: usize,
        /// Smallest accepted number of rows.
        least: usize,
    },
    /// More rows than the accepted share are not rows of numbers.
    #[error(
        "{file}: {garbage} of {rows} rows are not rows of numbers, first at {counted} {line} ({what}); more than one in {limit} is refused: \
         check delimiter, decimal sign and export"
    )]
    TooMuchGarbage {
        /// Name of the file.
        file: String,
        /// Number of rows that are not rows of numbers.
        garbage: usize,
        /// Number of rows.
        rows: usize,
        /// What `line` counts: `line` of a text or `row` of a table.
        counted: &'static str,
        /// Number of the line or row, from 1.
        line: u64,
        /// What was found instead.
        what: String,
        /// Largest accepted number or size.
        limit: usize,
    },
    /// Too many time stamps are smaller than the one before.
    #[error(
        "{file}, {counted} {line}: time goes back from {from:?} s to {to:?} s, and {count} of {rows} rows come out of order; one log holds one \
         recording: split the file there, or sort it"
    )]
    TimeGoesBack {
        /// Name of the file.
        file: String,
        /// What `line` counts: `line` of a text or `row` of a table.
        counted: &'static str,
        /// Number of the line or row, from 1.
        line: u64,
        /// Time before the step (s).
        from: f64,
        /// Time after the step (s).
        to: f64,
        /// Number of rows out of order.
        count: usize,
        /// Number of rows.
        rows: usize,
    },
    /// Too much time is missing between time stamps.
    #[error(
        "{file}: {} s of {} s are missing between time stamps, the longest gap after {counted} {line}, from {} s to {} s: \
         correct the stamp in the {counted} after it, or record again without losing samples",
        thousandths(.missing_s), thousandths(.total_s), thousandths(.from), thousandths(.to)
    )]
    TooManyGaps {
        /// Name of the file.
        file: String,
        /// Time that is missing in total (s).
        missing_s: f64,
        /// Duration of the recording (s).
        total_s: f64,
        /// What `line` counts: `line` of a text or `row` of a table.
        counted: &'static str,
        /// Number of the line or row, from 1.
        line: u64,
        /// Ends of the longest gap.
        from: f64,
        /// Time after the step (s).
        to: f64,
    },
    /// The sample rate from the time stamps is outside 5 Hz to 100 kHz.
    #[error(
        "{file}: the time stamps give a sample rate of {} Hz; a motion is sampled between 5 Hz and 100 kHz: state the unit of the stamps \
         in `columns` as `time_unit` (s, ms, us or ns), or their rate as `sample_rate_hz` without a time column",
        hertz(.rate_hz)
    )]
    ImplausibleRate {
        /// Name of the file.
        file: String,
        /// Sample rate by the time stamps (Hz).
        rate_hz: f64,
    },
    /// The time stamps contradict the stated sample rate.
    #[error(
        "{file}: the time stamps give a sample rate of {} Hz, and `columns` states {stated_hz} Hz: correct `sample_rate_hz`, or state \
         the unit of the stamps as `time_unit` (s, ms, us or ns)",
        hertz(.rate_hz)
    )]
    RateDiffers {
        /// Name of the file.
        file: String,
        /// Sample rate by the time stamps (Hz).
        rate_hz: f64,
        /// Sample rate in the request (Hz).
        stated_hz: f64,
    },
    /// Values are beyond what an arm can have.
    #[error(
        "{file}, {counted} {line}: the column `{column}` has {} in SI, and in more than one row of twenty values that are no {quantity} of an arm (beyond \
         {limit:e} in SI): choose the right column, or state its `unit` or `scale`, in `columns`",
        beyond(*.value)
    )]
    Implausible {
        /// Name of the file.
        file: String,
        /// What `line` counts: `line` of a text or `row` of a table.
        counted: &'static str,
        /// Number of the line or row, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// In SI.
        value: f64,
        /// The quantity that the column is used for.
        quantity: &'static str,
        /// Largest accepted number or size.
        limit: f64,
    },
    /// A time stamp is beyond what a recording can have.
    #[error(
        "{file}, {counted} {line}: the time stamp {} s is no time of a recording: correct or remove the row, or state the unit of the stamps as \
         `time_unit`",
        beyond(*.value)
    )]
    ImplausibleTime {
        /// Name of the file.
        file: String,
        /// What `line` counts: `line` of a text or `row` of a table.
        counted: &'static str,
        /// Number of the line or row, from 1.
        line: u64,
        /// The value found.
        value: f64,
    },
    /// More rows than are accepted.
    #[error("{file}: has more than {limit} rows; lower the sample rate or split the log")]
    TooLong {
        /// Name of the file.
        file: String,
        /// Largest accepted number or size.
        limit: usize,
    },
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
    /// Name of the file that the error is about.
    pub fn file(&self) -> &str {
        match self {
            Self::Unreadable { file, .. }
            | Self::Empty { file }
            | Self::CutOff { file, .. }
            | Self::NoHeader { file, .. }
            | Self::EmptyChannel { file, .. }
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
            | Self::EmptyChannel { file, .. }
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
