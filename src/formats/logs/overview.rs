//! The columns of a file as they are, before any is taken for anything.

use super::LogError;
use super::fields::{Row, number_of};
use super::names::Named;
use super::reader::{Opened, open};
use super::text::TextLog;
use crate::model::INPUT_LIMITS;
use serde::{Deserialize, Serialize};
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// Rows of a text that are looked at: some thousand of any robot.
const BYTES: u64 = 1 << 20;
/// First values that are handed out as they are: enough to see their steps.
const FIRST: usize = 200;
/// Values of a small picture.
const POINTS: usize = 160;

/// What a file holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct LogOverview {
    /// Rows that were looked at: of a text those of its first megabyte, else all of the longest topic.
    pub rows: usize,
    /// Whether these are all rows of the file.
    pub whole: bool,
    /// The columns in the order of the file.
    pub columns: Vec<LogColumn>,
}

/// One column of a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct LogColumn {
    /// As `columns` of a request names it.
    pub name: String,
    /// As the name or a line below it has it.
    pub unit: Option<String>,
    /// Whether most of its rows are numbers.
    pub numeric: bool,
    /// Largest absolute value.
    pub largest: Option<f64>,
    /// The first 200 values; null where there is no number.
    pub first: Vec<Option<f64>>,
    /// At most 160 values, evenly from all rows.
    pub points: Vec<Option<f64>>,
}

/// The columns of the file at `path`, called `file` in errors.
///
/// # Errors
/// [`LogError`]: unreadable, empty, or no log at all.
pub fn log_overview(path: &Path, file: &str) -> Result<LogOverview, LogError> {
    let source = open(path).map_err(|e| e.named(file))?;
    match Opened::new(file, source.bytes)? {
        Opened::Text(text) => Ok(of_text(text)),
        Opened::Sheet(mut sheet) => {
            let names = sheet.names().to_vec();
            let mut columns = Vec::with_capacity(names.len());
            // One by one: all of them may be more than memory holds.
            for (at, name) in names.iter().enumerate() {
                let loaded = sheet.load(&[at], name.stream)?;
                columns.push(LogColumn::from_values(name, &loaded.columns[0]));
            }
            let rows = sheet.rows();
            Ok(LogOverview {
                rows,
                whole: true,
                columns,
            })
        }
    }
}

fn of_text(text: TextLog) -> LogOverview {
    let TextLog { dialect, names, rows } = text;
    let mut lines = BufReader::new(rows.take(BYTES));
    let mut values: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    let (mut line, mut row, mut read) = (Vec::new(), Row::default(), 0);
    let mut count = 0;
    loop {
        line.clear();
        let longest = INPUT_LIMITS.log_line as u64;
        match lines.by_ref().take(longest).read_until(b'\n', &mut line) {
            // The last line may be cut off in the middle.
            Ok(size) if size > 0 && (line.ends_with(b"\n") || read + (size as u64) < BYTES) => read += size as u64,
            _ => break,
        }
        if !dialect.is_row(&line) {
            continue;
        }
        dialect.split(&line, &mut row);
        count += 1;
        for (at, column) in values.iter_mut().enumerate() {
            let number = (at < row.len())
                .then(|| number_of(row.field(at), dialect.decimal_comma))
                .flatten();
            column.push(number.unwrap_or(f64::NAN));
        }
    }
    LogOverview {
        rows: count,
        whole: read < BYTES,
        columns: names
            .iter()
            .zip(&values)
            .map(|(name, values)| LogColumn::from_values(name, values))
            .collect(),
    }
}

impl LogColumn {
    fn from_values(name: &Named, values: &[f64]) -> Self {
        let number = |v: &f64| v.is_finite().then_some(*v);
        let count = values.iter().filter(|v| v.is_finite()).count();
        let step = values.len().div_ceil(POINTS).max(1);
        Self {
            name: name.name.clone(),
            unit: name.unit.clone(),
            numeric: 2 * count > values.len(),
            largest: values.iter().filter(|v| v.is_finite()).map(|v| v.abs()).reduce(f64::max),
            first: values.iter().take(FIRST).map(number).collect(),
            points: values.iter().step_by(step).map(number).collect(),
        }
    }
}
