//! What was found while reading a log, and what was done about it.

/// The answer's account of one log file.
#[derive(Debug, Clone, PartialEq)]
pub struct LogReport {
    /// Name of the file.
    pub file: String,
    /// Data rows in the file, the header not counted.
    pub rows: usize,
    /// Rows whose values went into the record.
    pub rows_used: usize,
    /// Samples of the uniform record.
    pub samples: usize,
    /// Sample rate (Hz).
    pub rate_hz: f64,
    /// Duration (s).
    pub duration_s: f64,
    /// True when the values were interpolated onto the uniform grid.
    pub resampled: bool,
    /// Faults that were found, by kind; empty for a clean file.
    pub findings: Vec<Finding>,
}

/// One kind of irregularity.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Kind of the fault.
    pub kind: FindingKind,
    /// How many rows or places have it.
    pub count: usize,
    /// The first few line numbers (the header is line 1).
    pub lines: Vec<u64>,
    /// What it is and what was done, in words.
    pub detail: String,
}

/// Kinds of faults in a log file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FindingKind {
    /// A row that is not a row of numbers; it is dropped.
    GarbageRow,
    /// A row that repeats the one before; it is dropped.
    RepeatedRow,
    /// A time stamp that repeats the one before.
    RepeatedTime,
    /// A time stamp smaller than the one before.
    TimeOutOfOrder,
    /// A row without a time stamp.
    MissingTime,
    /// Single samples are missing and were bridged by interpolation.
    MissingSample,
    /// Samples are missing for longer; those times are left out of the fit.
    Gap,
    /// Time stamps scatter around a uniform grid.
    Jitter,
    /// The unit of the time stamps was recognised from their size.
    TimeUnit,
    /// Units that the header names, converted.
    HeaderUnit,
    /// A further quantity that is not in every row, interpolated.
    SlowChannel,
    /// Columns of another topic, interpolated.
    Aligned,
    /// Values beyond those of any arm.
    ImplausibleValue,
}

impl FindingKind {
    /// Code of the kind in documents, such as `garbage_row`.
    pub fn code(self) -> &'static str {
        match self {
            Self::GarbageRow => "garbage_row",
            Self::RepeatedRow => "repeated_row",
            Self::RepeatedTime => "repeated_time",
            Self::TimeOutOfOrder => "time_out_of_order",
            Self::MissingTime => "missing_time",
            Self::MissingSample => "missing_sample",
            Self::Gap => "gap",
            Self::Jitter => "jitter",
            Self::TimeUnit => "time_unit",
            Self::HeaderUnit => "header_unit",
            Self::SlowChannel => "slow_channel",
            Self::Aligned => "aligned",
            Self::ImplausibleValue => "implausible_value",
        }
    }
}

/// Counts one kind of irregularity and remembers where it was first seen.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    pub count: usize,
    pub lines: Vec<u64>,
    /// What the first one looked like.
    pub first: Option<String>,
}

impl Tally {
    /// Enough to find them by hand, few enough to read.
    const LINES: usize = 10;

    pub fn add(&mut self, line: u64, what: impl FnOnce() -> String) {
        self.count += 1;
        if self.lines.len() < Self::LINES {
            self.lines.push(line);
        }
        if self.first.is_none() {
            self.first = Some(what());
        }
    }

    /// Keeps what the one in the first line looks like.
    pub fn note(&mut self, line: u64, what: impl FnOnce() -> String) {
        if self.lines.first().is_none_or(|&first| line < first) {
            self.lines = vec![line];
            self.first = Some(what());
        }
    }

    /// Counts `lines`, in their order, instead of what was noted.
    pub fn count_lines(&mut self, lines: impl Iterator<Item = u64>) {
        self.lines.clear();
        for line in lines {
            self.add(line, String::new);
        }
    }

    /// Takes over what was counted in a part of the file that follows line `before`.
    pub fn append(&mut self, part: Self, before: u64) {
        self.count += part.count;
        let room = Self::LINES.saturating_sub(self.lines.len());
        self.lines.extend(part.lines.iter().take(room).map(|line| before + line));
        self.first = self.first.take().or(part.first);
    }

    pub fn finding(&self, kind: FindingKind, detail: impl FnOnce(&str) -> String) -> Option<Finding> {
        (self.count > 0).then(|| Finding {
            kind,
            count: self.count,
            lines: self.lines.clone(),
            detail: detail(self.first.as_deref().unwrap_or("")),
        })
    }
}
