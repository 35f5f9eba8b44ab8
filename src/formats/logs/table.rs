//! The columns of a file as they are read.

use super::columns::{Quantity, TimeUnit};
use super::places::Places;
use super::report::Tally;
use super::rows::Part;
use super::{Finding, LogError};
use crate::model::INPUT_LIMITS;

/// Most rows of one log: a bound on memory.
pub(super) const MOST_ROWS: usize = INPUT_LIMITS.log_rows;
/// One bad row in twenty is a broken export, not a glitch.
pub(super) const GARBAGE_LIMIT: usize = 20;

/// A quantity, its columns and their names.
type Measured<'a> = (Quantity, &'a [Vec<f64>], &'a [String]);

/// Columns as read, before anything is laid onto a time grid. All columns have one entry per accepted row.
pub(super) struct Table {
    pub file: String,
    /// Line of the file that every row came from.
    pub lines: Vec<u32>,
    /// Number of every row among all of the file, from 1.
    pub numbers: Vec<u32>,
    /// In the file's unit; empty when there is no time column.
    pub time: Vec<f64>,
    pub q: Vec<Vec<f64>>,
    pub qd: Vec<Vec<f64>>,
    pub tau: Vec<Vec<f64>>,
    /// Names of the columns of positions, velocities and torques, as the file has them.
    pub names: [Vec<String>; 3],
    /// Nanoseconds beside whole seconds: one column, or none.
    pub nanos: Vec<Vec<f64>>,
    /// Further quantities; NaN in rows that have none.
    pub channels: Vec<Vec<f64>>,
    pub rows: usize,
    /// What the rows are counted by: lines of text, or rows.
    pub counted: &'static str,
    /// What the file itself says of its stamps.
    pub time_unit: Option<TimeUnit>,
    /// What was found while the columns were made.
    pub findings: Vec<Finding>,
    /// Whether the file has a time column.
    pub has_time: bool,
    /// Of the file, as far as is known: an estimate of the rows to come.
    bytes_left: u64,
    pub garbage: Tally,
    /// Rows without a number in the time column alone.
    pub missing_time: Tally,
}

impl Table {
    pub fn new(file: String, places: &Places, bytes: u64) -> Self {
        let empty = |places: &[usize]| vec![Vec::new(); places.len()];
        Self {
            file,
            lines: Vec::new(),
            numbers: Vec::new(),
            time: Vec::new(),
            q: empty(&places.q),
            qd: empty(&places.qd),
            tau: empty(&places.tau),
            names: Default::default(),
            nanos: vec![Vec::new(); places.nanos.iter().count()],
            channels: empty(&places.channels),
            rows: 0,
            counted: "line",
            time_unit: places.time_unit,
            findings: Vec::new(),
            has_time: places.time.is_some(),
            bytes_left: bytes,
            garbage: Tally::default(),
            missing_time: Tally::default(),
        }
    }

    /// Appends the rows of the part that follows line `line`, and takes what it counted.
    pub fn append(&mut self, part: &mut Part, line: u64) -> Result<(), LogError> {
        if self.rows + part.rows > MOST_ROWS {
            return Err(LogError::TooLong {
                file: self.file.clone(),
                limit: MOST_ROWS,
            });
        }
        self.reserve(part);
        let after = |count: u64, n: u32| (count + u64::from(n)).min(u64::from(u32::MAX)) as u32;
        self.lines.extend(part.lines.iter().map(|&l| after(line, l)));
        self.numbers.extend(part.numbers.iter().map(|&n| after(self.rows as u64, n)));
        self.time.extend_from_slice(&part.time);
        self.columns_mut()
            .zip(&part.columns)
            .for_each(|(column, more)| column.extend_from_slice(more));
        self.garbage.append(std::mem::take(&mut part.garbage), line);
        self.missing_time.append(std::mem::take(&mut part.missing_time), line);
        self.rows += part.rows;
        Ok(())
    }

    /// Makes room for as many rows as the file has left if they go on as in `part`: columns that grow by and by are copied every
    /// time.
    fn reserve(&mut self, part: &Part) {
        self.bytes_left = self.bytes_left.saturating_sub(part.bytes as u64);
        if self.lines.capacity() - self.lines.len() >= part.lines.len() {
            return;
        }
        // A twentieth more: lines need not stay as long as they are.
        let blocks = 1.0 + 1.05 * self.bytes_left as f64 / part.bytes.max(1) as f64;
        let more = ((part.lines.len() as f64 * blocks) as usize).min(MOST_ROWS);
        self.lines.reserve(more);
        self.numbers.reserve(more);
        self.time.reserve(if part.time.is_empty() { 0 } else { more });
        self.columns_mut().for_each(|column| column.reserve(more));
    }

    /// Takes over the columns of a file beside this one: row by row, those rows left out that are no numbers in either.
    pub fn join(&mut self, mut other: Table) -> Result<(), LogError> {
        if self.rows != other.rows {
            return Err(LogError::RowsDiffer {
                file: self.file.clone(),
                rows: self.rows,
                other: other.file,
                other_rows: other.rows,
            });
        }
        let own: Vec<bool> = self.numbers.iter().map(|n| other.numbers.binary_search(n).is_ok()).collect();
        let theirs: Vec<bool> = other.numbers.iter().map(|n| self.numbers.binary_search(n).is_ok()).collect();
        self.retain(&own);
        other.retain(&theirs);
        self.garbage.count += own.iter().filter(|kept| !**kept).count();
        let own = [&mut self.q, &mut self.qd, &mut self.tau].into_iter().zip(&mut self.names);
        for ((mine, names), (found, called)) in own.zip([other.q, other.qd, other.tau].into_iter().zip(other.names)) {
            if mine.is_empty() {
                (*mine, *names) = (found, called);
            }
        }
        Ok(())
    }

    /// Every quantity with its columns and their names.
    pub fn quantities(&self) -> [Measured<'_>; 3] {
        let [q, qd, tau] = &self.names;
        [
            (Quantity::Position, &self.q, q),
            (Quantity::Velocity, &self.qd, qd),
            (Quantity::Torque, &self.tau, tau),
        ]
    }

    pub fn check(&self) -> Result<(), LogError> {
        if self.rows == 0 {
            return Err(LogError::Empty { file: self.file.clone() });
        }
        let garbage = self.garbage.count + self.missing_time.count;
        // Of a few rows one may be garbage, but not all.
        if garbage * GARBAGE_LIMIT > self.rows.max(GARBAGE_LIMIT) || garbage >= self.rows {
            let tally = if self.garbage.count > 0 {
                &self.garbage
            } else {
                &self.missing_time
            };
            return Err(LogError::TooMuchGarbage {
                file: self.file.clone(),
                garbage,
                rows: self.rows,
                counted: self.counted,
                line: tally.lines[0],
                what: tally.first.clone().unwrap_or_default(),
                limit: GARBAGE_LIMIT,
            });
        }
        Ok(())
    }
}
