//! One pass over a CSV file, plain or gzip.

use super::columns::{Columns, Quantity, candidates};
use super::report::Tally;
use super::{LogError, LogReport, time_base};
use crate::identification::Log;
use csv::{ByteRecord, Position, ReaderBuilder, Trim};
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// Where the bytes come from, with the name that messages use.
pub struct Source<R> {
    pub name: String,
    pub bytes: R,
}

/// Columns as read, before anything is laid onto a time grid. All columns have one entry per accepted row.
pub(super) struct Table {
    pub file: String,
    /// Line of the file that every row came from.
    pub lines: Vec<u32>,
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

/// Most rows of one log: at 1 kHz more than two hours. A bound on memory, 2.6 GB for seven joints being out of anybody's reach.
const MOST_ROWS: usize = 8_000_000;
/// One bad row in twenty is a broken export, not a glitch.
const GARBAGE_LIMIT: usize = 20;

/// Reads the log in the file at `path`. See [`read_log`].
///
/// # Errors
/// As [`read_log`], and a file that cannot be opened.
pub fn read_log_file(path: &Path, columns: &Columns, joints: &[String]) -> Result<(Log, LogReport), LogError> {
    let name = path
        .file_name()
        .map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
    let bytes = File::open(path).map_err(|e| LogError::Unreadable {
        file: name.clone(),
        detail: e.to_string(),
    })?;
    read_log(Source { name, bytes }, columns, joints)
}

/// Reads a log of the robot whose joints are called `joints`.
///
/// Rows are streamed: nothing is held but the columns that are used. gzip is recognised by its first two bytes.
///
/// # Errors
/// [`LogError`]: unreadable, empty or cut off, columns missing, too much garbage, time running backwards, too many gaps.
pub fn read_log<R: Read>(source: Source<R>, columns: &Columns, joints: &[String]) -> Result<(Log, LogReport), LogError> {
    let Source { name: file, bytes } = source;
    let mut bytes = BufReader::with_capacity(1 << 16, bytes);
    let unreadable = |e: io::Error| LogError::Unreadable {
        file: file.clone(),
        detail: e.to_string(),
    };
    let start = bytes.fill_buf().map_err(unreadable)?;
    if start.is_empty() {
        return Err(LogError::Empty { file });
    }
    let table = if start.starts_with(&[0x1f, 0x8b]) {
        read_table(
            file,
            BufReader::with_capacity(1 << 16, MultiGzDecoder::new(bytes)),
            columns,
            joints,
        )?
    } else {
        read_table(file, bytes, columns, joints)?
    };
    time_base::uniform(table, columns)
}

fn read_table(file: String, mut bytes: impl BufRead, columns: &Columns, joints: &[String]) -> Result<Table, LogError> {
    let delimiter = match bytes.fill_buf() {
        Ok(start) => delimiter(start),
        Err(e) => return Err(broken(&file, 1, &e)),
    };
    let mut reader = ReaderBuilder::new()
        .delimiter(delimiter)
        .flexible(true)
        .trim(Trim::All)
        .comment(Some(b'#'))
        .from_reader(bytes);
    let header = match reader.byte_headers() {
        Ok(header) => header.clone(),
        Err(e) => return Err(csv_error(&file, 1, e)),
    };
    let header: Vec<String> = header
        .iter()
        .map(|h| String::from_utf8_lossy(h).trim_start_matches('\u{feff}').to_string())
        .collect();
    let places = Places::find(&file, &header, columns, joints)?;
    let n = joints.len();
    let mut table = Table {
        file,
        lines: Vec::new(),
        time: Vec::new(),
        q: vec![Vec::new(); n],
        qd: vec![Vec::new(); places.qd.len()],
        tau: vec![Vec::new(); n],
        rows: 0,
        garbage: Tally::default(),
        missing_time: Tally::default(),
    };
    let mut record = ByteRecord::new();
    let mut values = vec![0.0; 1 + 3 * n];
    loop {
        let line = reader.position().line();
        match reader.read_byte_record(&mut record) {
            Ok(true) => table.take(&record, header.len(), &places, &mut values)?,
            Ok(false) => break,
            Err(e) => return Err(csv_error(&table.file, line, e)),
        }
    }
    table.check()?;
    Ok(table)
}

/// The delimiter that the header line has most of.
pub(super) fn delimiter(start: &[u8]) -> u8 {
    let line = start.split(|&b| b == b'\n').find(|l| !l.starts_with(b"#")).unwrap_or(start);
    let count = |d: u8| line.iter().filter(|&&b| b == d).count();
    [b',', b';', b'\t', b' ']
        .into_iter()
        .rev()
        .max_by_key(|&d| count(d))
        .unwrap_or(b',')
}

fn broken(file: &str, line: u64, e: &io::Error) -> LogError {
    match e.kind() {
        io::ErrorKind::UnexpectedEof => LogError::CutOff {
            file: file.to_string(),
            line,
        },
        _ => LogError::Unreadable {
            file: file.to_string(),
            detail: format!("after line {line}: {e}"),
        },
    }
}

fn csv_error(file: &str, line: u64, e: csv::Error) -> LogError {
    match e.into_kind() {
        csv::ErrorKind::Io(e) => broken(file, line, &e),
        other => LogError::Unreadable {
            file: file.to_string(),
            detail: format!("line {line}: {other:?}"),
        },
    }
}

/// Field numbers of everything that is read.
pub(super) struct Places {
    pub time: Option<usize>,
    pub q: Vec<usize>,
    /// Empty when the file has no velocities.
    pub qd: Vec<usize>,
    pub tau: Vec<usize>,
}

impl Places {
    pub fn find(file: &str, header: &[String], columns: &Columns, joints: &[String]) -> Result<Self, LogError> {
        let n = joints.len();
        let example = format!("`time,q1,…,q{n},tau1,…,tau{n}`");
        if header.is_empty() || header.iter().all(String::is_empty) {
            return Err(LogError::Empty { file: file.to_string() });
        }
        if header.iter().all(|h| h.parse::<f64>().is_ok()) {
            return Err(LogError::NoHeader {
                file: file.to_string(),
                example,
            });
        }
        let mut missing = Vec::new();
        let mut find = |quantity: Quantity, optional: bool| {
            let wanted = &quantity.of(columns).headers;
            let mut found = Vec::new();
            let mut absent = Vec::new();
            for (j, joint) in joints.iter().enumerate() {
                let names = match wanted.get(j) {
                    Some(header) => vec![header.clone()],
                    None => candidates(quantity, j + 1, joint),
                };
                match names.iter().find_map(|name| header.iter().position(|h| h == name)) {
                    Some(at) => found.push(at),
                    None => absent.push(format!("`{}` (joint {joint})", names[0])),
                }
            }
            if absent.is_empty() {
                return found;
            }
            if !(optional && wanted.is_empty()) {
                missing.extend(absent);
            }
            Vec::new()
        };
        let q = find(Quantity::Position, false);
        let qd = find(Quantity::Velocity, true);
        let tau = find(Quantity::Torque, false);
        let time = match &columns.time {
            Some(name) => header.iter().position(|h| h == name).or_else(|| {
                missing.push(format!("`{name}` (time)"));
                None
            }),
            None => ["time", "t", "timestamp", "time_s"]
                .iter()
                .find_map(|name| header.iter().position(|h| h.eq_ignore_ascii_case(name))),
        };
        if !missing.is_empty() {
            let found = header.iter().map(|h| format!("`{h}`")).collect();
            return Err(LogError::MissingColumns {
                file: file.to_string(),
                missing,
                found,
                example,
            });
        }
        for &at in time.iter().chain(&q).chain(&qd).chain(&tau) {
            let times = header.iter().filter(|h| **h == header[at]).count();
            if times > 1 {
                return Err(LogError::RepeatedColumn {
                    file: file.to_string(),
                    column: header[at].clone(),
                    times,
                });
            }
        }
        if time.is_none() && columns.sample_rate_hz.is_none() {
            return Err(LogError::NoTimeBase { file: file.to_string() });
        }
        Ok(Self { time, q, qd, tau })
    }

    pub fn all(&self) -> impl Iterator<Item = usize> {
        self.q.iter().chain(&self.qd).chain(&self.tau).copied()
    }
}

impl Table {
    /// Appends one row, or counts it as garbage.
    fn take(&mut self, record: &ByteRecord, fields: usize, places: &Places, values: &mut [f64]) -> Result<(), LogError> {
        self.rows += 1;
        if self.rows > MOST_ROWS {
            return Err(LogError::TooLong {
                file: self.file.clone(),
                limit: MOST_ROWS,
            });
        }
        let line = record.position().map_or(0, Position::line);
        if record.len() != fields {
            self.garbage
                .add(line, || format!("{} fields instead of {fields}", record.len()));
            return Ok(());
        }
        for (value, at) in values.iter_mut().zip(places.all()) {
            match number(&record[at]) {
                Some(v) => *value = v,
                None => {
                    self.garbage.add(line, || {
                        format!("`{}` in column {}", String::from_utf8_lossy(&record[at]), at + 1)
                    });
                    return Ok(());
                }
            }
        }
        if let Some(at) = places.time {
            match number(&record[at]) {
                Some(t) => self.time.push(t),
                None => {
                    self.missing_time
                        .add(line, || format!("`{}`", String::from_utf8_lossy(&record[at])));
                    return Ok(());
                }
            }
        }
        self.lines.push(line.min(u64::from(u32::MAX)) as u32);
        let columns = self.q.iter_mut().chain(&mut self.qd).chain(&mut self.tau);
        columns.zip(values.iter()).for_each(|(column, &v)| column.push(v));
        Ok(())
    }

    fn check(&self) -> Result<(), LogError> {
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

/// A finite number, or nothing.
fn number(field: &[u8]) -> Option<f64> {
    std::str::from_utf8(field).ok()?.parse().ok().filter(|v: &f64| v.is_finite())
}
