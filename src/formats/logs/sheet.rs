//! Logs that are no text: columns of numbers with names, some beside others.

use super::error::LogError;
use super::names::Named;
use super::places::{Heading, Places};
use super::report::Finding;
use super::table::{MOST_ROWS, Table};

/// A file whose columns are read one by one.
pub(super) trait Sheet: Send {
    fn names(&self) -> &[Named];

    /// Rows of its longest stream.
    fn rows(&self) -> usize;

    /// The values of the columns `wanted`, row by row beside those of the stream `base`. What is no number is NaN.
    fn load(&mut self, wanted: &[usize], base: usize) -> Result<Loaded, LogError>;
}

/// Columns of one length, in the order in which they were asked for.
pub(super) struct Loaded {
    pub columns: Vec<Vec<f64>>,
    pub findings: Vec<Finding>,
}

impl From<Vec<Vec<f64>>> for Loaded {
    fn from(columns: Vec<Vec<f64>>) -> Self {
        Self {
            columns,
            findings: Vec::new(),
        }
    }
}

pub(super) fn heading<'a>(sheet: &'a dyn Sheet, file: &'a str) -> Heading<'a> {
    Heading {
        file,
        names: sheet.names(),
        line: None,
        is_numbered: false,
    }
}

/// The table of the columns that `places` has.
pub(super) fn table_of(file: &str, sheet: &mut dyn Sheet, places: &Places) -> Result<Table, LogError> {
    let wanted: Vec<usize> = places.time.into_iter().chain(places.all()).collect();
    let base = places.q.first().or(wanted.first()).map_or(0, |&at| sheet.names()[at].stream);
    let loaded = sheet.load(&wanted, base)?;
    let mut table = Table::new(file.to_string(), places, 0);
    table.counted = "row";
    table.findings.extend(loaded.findings);
    let rows = loaded.columns.iter().map(Vec::len).min().unwrap_or(0);
    if rows > MOST_ROWS {
        return Err(LogError::TooLong {
            file: file.to_string(),
            limit: MOST_ROWS,
        });
    }
    let mut columns = loaded.columns;
    columns.iter_mut().for_each(|c| c.truncate(rows));
    let time = places.time.is_some().then(|| columns.remove(0));
    // A row need not have what is slow.
    let required = &columns[..columns.len() - places.channels.len()];
    let keep: Vec<bool> = (0..rows)
        .map(|row| is_row(&mut table, row, time.as_deref(), required))
        .collect();
    table.rows = rows;
    (table.numbers, table.lines) = ((1..=rows as u32).collect(), (1..=rows as u32).collect());
    table.time = time.unwrap_or_default();
    table.columns_mut().zip(columns).for_each(|(place, column)| *place = column);
    table.retain(&keep);
    Ok(table)
}

/// Whether all is numbers; what is none is counted.
fn is_row(table: &mut Table, row: usize, time: Option<&[f64]>, columns: &[Vec<f64>]) -> bool {
    let number = row as u64 + 1;
    if let Some(bad) = columns.iter().find(|c| !c[row].is_finite()) {
        table.garbage.add(number, || format!("{} in place of a number", bad[row]));
        return false;
    }
    match time {
        Some(time) if !time[row].is_finite() => {
            table.missing_time.add(number, || format!("{}", time[row]));
            false
        }
        _ => true,
    }
}
