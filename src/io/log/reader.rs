//! One pass over a CSV file, plain or gzip.

use super::blocks::{Broken, for_each_part};
use super::columns::Columns;
use super::header::Header;
use super::places::{Places, Wanted};
use super::rows::{Part, RowShape};
use super::table::Table;
use super::unpack::unpacked;
use super::{LogError, LogReport, time_base};
use crate::identification::Log;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Where the bytes come from, with the name that messages use.
pub struct Source<R> {
    pub name: String,
    pub bytes: R,
}

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
    let mut table = table_of(open(path)?, size(path), columns, joints, &|q| q.of(columns).file.is_none())?;
    for name in columns.files() {
        let Some((_, other)) = others.iter().find(|(known, _)| known == name) else {
            return Err(LogError::MissingFile {
                file: table.file,
                other: name.to_string(),
            });
        };
        let part = table_of(open(other)?, size(other), columns, joints, &|q| {
            q.of(columns).file.as_deref() == Some(name)
        })?;
        table.join(part)?;
    }
    time_base::uniform(table, columns)
}

/// Bytes of the file, packed or not, as a hint: zero where they are not told.
fn size(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |about| about.len())
}

pub(super) fn open(path: &Path) -> Result<Source<File>, LogError> {
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
pub fn read_log<R: Read + Send>(source: Source<R>, columns: &Columns, joints: &[String]) -> Result<(Log, LogReport), LogError> {
    time_base::uniform(table_of(source, 0, columns, joints, &|_| true)?, columns)
}

/// The columns of the quantities that are wanted of one file of so many bytes; zero where nobody knows.
fn table_of<R: Read + Send>(
    source: Source<R>,
    size: u64,
    columns: &Columns,
    joints: &[String],
    wanted: &Wanted,
) -> Result<Table, LogError> {
    let Source { name: file, bytes } = source;
    let mut bytes = unpacked(&file, bytes)?;
    let header = Header::read(&file, &mut bytes)?;
    let places = Places::find(&file, &header.names, columns, joints, wanted)?;
    let shape = RowShape::new(header.delimiter, header.names.len(), &places);
    let mut table = Table::new(file.clone(), &places, size);
    let take = |part: &mut Part, before: u64| table.append(part, header.lines + before);
    for_each_part(&mut bytes, &shape, take, |end| {
        let at = header.lines + end.lines;
        match end.reason {
            Broken::Io(e) => broken(&file, at, &e),
            Broken::LongLine => LogError::LongLine {
                file: file.clone(),
                line: at + 1,
            },
        }
    })?;
    table.check()?;
    Ok(table)
}

pub(super) fn broken(file: &str, line: u64, e: &io::Error) -> LogError {
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
