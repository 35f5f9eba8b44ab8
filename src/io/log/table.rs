//! The columns of a file as they are read.

use super::LogError;
use super::places::Places;
use super::report::Tally;
use super::rows::Part;

/// Most rows of one log: at 1 kHz more than two hours. A bound on memory, 2.6 GB for seven joints being out of anybody's reach.
const MOST_ROWS: usize = 8_000_000;
/// One bad row in twenty is a broken export, not a glitch.
const GARBAGE_LIMIT: usize = 20;

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
    pub rows: usize,
    pub garbage: Tally,
    /// Rows without a number in the time column alone.
    pub missing_time: Tally,
}

impl Table {
    pub fn new(file: String, places: &Places) -> Self {
        let empty = |places: &[usize]| vec![Vec::new(); places.len()];
        Self {
            file,
            lines: Vec::new(),
            numbers: Vec::new(),
            time: Vec::new(),
            q: empty(&places.q),
            qd: empty(&places.qd),
            tau: empty(&places.tau),
            rows: 0,
            garbage: Tally::default(),
            missing_time: Tally::default(),
        }
    }

    /// Appends the rows of the part that follows line `line`.
    pub fn append(&mut self, part: Part, line: u64) -> Result<(), LogError> {
        if self.rows + part.rows > MOST_ROWS {
            return Err(LogError::TooLong {
                file: self.file.clone(),
                limit: MOST_ROWS,
            });
        }
        let after = |count: u64, n: u32| (count + u64::from(n)).min(u64::from(u32::MAX)) as u32;
        self.lines.extend(part.lines.iter().map(|&l| after(line, l)));
        self.numbers.extend(part.numbers.iter().map(|&n| after(self.rows as u64, n)));
        self.time.extend_from_slice(&part.time);
        let columns = self.q.iter_mut().chain(&mut self.qd).chain(&mut self.tau);
        columns
            .zip(&part.columns)
            .for_each(|(column, more)| column.extend_from_slice(more));
        self.garbage.append(part.garbage, line);
        self.missing_time.append(part.missing_time, line);
        self.rows += part.rows;
        Ok(())
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
        for (mine, found) in [(&mut self.q, other.q), (&mut self.qd, other.qd), (&mut self.tau, other.tau)] {
            if mine.is_empty() {
                *mine = found;
            }
        }
        Ok(())
    }

    pub fn check(&self) -> Result<(), LogError> {
        if self.rows == 0 {
            return Err(LogError::Empty { file: self.file.clone() });
        }
        let garbage = self.garbage.count + self.missing_time.count;
        if garbage * GARBAGE_LIMIT > self.rows.max(GARBAGE_LIMIT) {
            let tally = if self.garbage.count > 0 {
                &self.garbage
            } else {
                &self.missing_time
            };
            return Err(LogError::TooMuchGarbage {
                file: self.file.clone(),
                garbage,
                rows: self.rows,
                line: tally.lines[0],
                what: tally.first.clone().unwrap_or_default(),
                limit: GARBAGE_LIMIT,
            });
        }
        Ok(())
    }
}
