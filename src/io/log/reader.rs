//! One pass over a CSV file, plain or gzip.

use super::columns::{Columns, Quantity, candidates};
use super::report::Tally;
use super::{LogError, LogReport, time_base};
use crate::identification::Log;
use csv::{ByteRecord, Position, ReaderBuilder, Trim};
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

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
    /// Number of every row among all of the file; empty once files are joined.
    numbers: Vec<u32>,
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
    read_joined_log(path, &[], columns, joints)
}

/// Reads the log in the file at `path`, with the quantities that `columns` places in other files, row by row: `others` has the name and
/// the path of every file there is.
///
/// # Errors
/// As [`read_log`]; a file that cannot be opened or is not among `others`, or that has another number of rows.
pub fn read_joined_log(
    path: &Path,
    others: &[(String, PathBuf)],
    columns: &Columns,
    joints: &[String],
) -> Result<(Log, LogReport), LogError> {
    let mut table = table_of(open(path)?, columns, joints, &|q| q.of(columns).file.is_none())?;
    for name in columns.files() {
        let Some((_, other)) = others.iter().find(|(known, _)| known == name) else {
            return Err(LogError::MissingFile {
                file: table.file,
                other: name.to_string(),
            });
        };
        let part = table_of(open(other)?, columns, joints, &|q| {
            q.of(columns).file.as_deref() == Some(name)
        })?;
        table.join(part)?;
    }
    time_base::uniform(table, columns)
}

fn open(path: &Path) -> Result<Source<File>, LogError> {
    let name = path
        .file_name()
        .map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
    match File::open(path) {
        Ok(bytes) => Ok(Source { name, bytes }),
        Err(e) => Err(LogError::Unreadable {
            file: name,
            detail: e.to_string(),
        }),
    }
}

/// Reads the log of the robot whose joints are called `joints`, all of it in one file.
///
/// Rows are streamed: nothing is held but the columns that are used. gzip is recognised by its first two bytes.
///
/// # Errors
/// [`LogError`]: unreadable, empty or cut off, columns missing, too much garbage, time running backwards, too many gaps.
pub fn read_log<R: Read>(source: Source<R>, columns: &Columns, joints: &[String]) -> Result<(Log, LogReport), LogError> {
    time_base::uniform(table_of(source, columns, joints, &|_| true)?, columns)
}

/// The columns of the quantities that are wanted of one file.
fn table_of<R: Read>(source: Source<R>, columns: &Columns, joints: &[String], wanted: &Wanted) -> Result<Table, LogError> {
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
    if start.starts_with(&[0x1f, 0x8b]) {
        let bytes = BufReader::with_capacity(1 << 16, MultiGzDecoder::new(bytes));
        return read_table(file, bytes, columns, joints, wanted);
    }
    read_table(file, bytes, columns, joints, wanted)
}

type Wanted<'a> = dyn Fn(Quantity) -> bool + 'a;

/// Longest header line that is read: a thousand columns with names of a hundred letters. A file without line ends would fill the memory.
const LONGEST_HEADER: usize = 100_000;

fn read_table(
    file: String,
    mut bytes: impl BufRead,
    columns: &Columns,
    joints: &[String],
    wanted: &Wanted,
) -> Result<Table, LogError> {
    let delimiter = match bytes.fill_buf() {
        Ok(start) => delimiter(start),
        Err(e) => return Err(broken(&file, 1, &e)),
    };
    let head = header_part(&mut bytes).map_err(|e| broken(&file, 1, &e))?;
    if head.len() > LONGEST_HEADER {
        return Err(LogError::LongHeader {
            file,
            limit: LONGEST_HEADER,
        });
    }
    let bytes = Cursor::new(head).chain(bytes);
    let mut reader = ReaderBuilder::new()
        .delimiter(delimiter)
        .flexible(true)
        .trim(Trim::Headers)
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
    let places = Places::find(&file, &header, columns, joints, wanted)?;
    let n = joints.len();
    let mut table = Table {
        file,
        lines: Vec::new(),
        numbers: Vec::new(),
        time: Vec::new(),
        q: vec![Vec::new(); places.q.len()],
        qd: vec![Vec::new(); places.qd.len()],
        tau: vec![Vec::new(); places.tau.len()],
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

/// The file as far as its first line that is no comment, or one byte more than the longest header.
fn header_part(bytes: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    let mut line = 0;
    while head.len() <= LONGEST_HEADER {
        let most = (LONGEST_HEADER + 1 - head.len()) as u64;
        let read = bytes.by_ref().take(most).read_until(b'\n', &mut head)?;
        if read == 0 || head[line] != b'#' {
            break;
        }
        line = head.len();
    }
    Ok(head)
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
    pub fn find(
        file: &str,
        header: &[String],
        columns: &Columns,
        joints: &[String],
        is_wanted: &Wanted,
    ) -> Result<Self, LogError> {
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
            if !is_wanted(quantity) {
                return Vec::new();
            }
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
        // Time goes with the positions.
        let time = match &columns.time {
            _ if !is_wanted(Quantity::Position) => None,
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
        if time.is_none() && columns.sample_rate_hz.is_none() && is_wanted(Quantity::Position) {
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
        self.numbers.push(self.rows as u32);
        let columns = self.q.iter_mut().chain(&mut self.qd).chain(&mut self.tau);
        columns.zip(values.iter()).for_each(|(column, &v)| column.push(v));
        Ok(())
    }

    /// Takes over the columns of a file beside this one: row by row, those rows left out that are no numbers in either.
    fn join(&mut self, mut other: Table) -> Result<(), LogError> {
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
    let field = field.trim_ascii();
    short_decimal(field).or_else(|| std::str::from_utf8(field).ok()?.parse().ok().filter(|v: &f64| v.is_finite()))
}

/// `-12.345` and the like, exactly: digits that make a whole number below 2⁵³ and a power of ten up to 10²² are doubles, and their quotient
/// is rounded once (Clinger 1990). `None` for anything else, which then takes the long way.
fn short_decimal(field: &[u8]) -> Option<f64> {
    let (negative, digits) = match field {
        [b'-', rest @ ..] => (true, rest),
        rest => (false, rest),
    };
    // Nineteen digits cannot overflow 64 bits; twenty may, and are turned away below.
    if digits.is_empty() || digits.len() > 20 {
        return None;
    }
    let (mut whole, mut decimals, mut point) = (0u64, 0, false);
    for &byte in digits {
        match byte {
            b'0'..=b'9' => {
                whole = whole.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                decimals += usize::from(point);
            }
            b'.' if !point => point = true,
            _ => return None,
        }
    }
    let most = digits.len() - usize::from(point);
    if most == 0 || most > 19 || whole > 1 << 53 || decimals >= POWERS_OF_TEN.len() {
        return None;
    }
    let value = whole as f64 / POWERS_OF_TEN[decimals];
    Some(if negative { -value } else { value })
}

const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21,
    1e22,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_short_decimals_are_the_doubles_that_the_standard_library_reads() {
        let texts = [
            "0",
            "-0.0",
            "3.14159265358979",
            "-12.345",
            ".5",
            "5.",
            "9007199254740992",
            "0.000000000000000000001",
            "123456789.987654321",
        ];
        for text in texts {
            let expected: f64 = text.parse().unwrap();
            assert_eq!(number(text.as_bytes()).map(f64::to_bits), Some(expected.to_bits()), "{text}");
        }
        // A generator of digits: what it makes is read alike, or left to the standard library.
        let mut state = 1u64;
        for _ in 0..20_000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let text = format!("{}.{:09}", (state >> 50) as i64 - 8000, (state >> 20) % 1_000_000_000);
            assert_eq!(short_decimal(text.as_bytes()), text.parse().ok(), "{text}");
        }
        for text in ["", "-", ".", "1e5", "nan", "inf", "1.2.3", "12a", "+-1"] {
            assert_eq!(short_decimal(text.as_bytes()), None, "{text}");
        }
        assert_eq!(
            (number(b" 1.5\r"), number(b"1e3"), number(b"nan"), number(b"")),
            (Some(1.5), Some(1000.0), None, None)
        );
    }
}
