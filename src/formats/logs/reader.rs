//! One pass over a log, whatever its format.

#[cfg(feature = "formats")]
use super::binary;
use super::blocks::{Broken, for_each_part};
use super::columns::{Columns, Quantity};
#[cfg(not(feature = "formats"))]
use super::kind::Foreign;
use super::kind::Kind;
use super::places::{Heading, Places, Wanted};
use super::rows::{Part, RowShape};
use super::sheet::{self, Sheet};
use super::table::Table;
use super::text::TextLog;
use super::unpack::unpacked;
use super::{LogError, LogReport, time_base};
use crate::cancel::CancelFlag;
use crate::preparation::Log;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Where the bytes come from, with the name that messages use.
pub struct Source<R> {
    /// Name of the file in messages.
    pub name: String,
    /// The content, compressed or not.
    pub bytes: R,
}

/// Reads the log in the file at `path`. See [`read_log`].
///
/// # Errors
/// As [`read_log`], and a file that cannot be opened.
pub fn read_log_file(path: &Path, columns: &Columns, joints: &[String]) -> Result<(Log, LogReport), LogError> {
    read_joined_log(path, &[], columns, joints)
}

/// Reads the log in the file at `path`, with the quantities that `columns` places in other files, row by row: `others` has the
/// name and the path of every file there is.
///
/// # Errors
/// As [`read_log`]; a file that cannot be opened or is not among `others`, or that has another number of rows.
pub fn read_joined_log(
    path: &Path,
    others: &[(String, PathBuf)],
    columns: &Columns,
    joints: &[String],
) -> Result<(Log, LogReport), LogError> {
    read_joined_log_until(path, others, columns, joints, &CancelFlag::default())
}

/// The same, left when `cancel` is set, as by [`CancelFlag::leave_if_set`]: within [`CancelFlag::run`].
///
/// # Errors
/// As [`read_joined_log`].
pub fn read_joined_log_until(
    path: &Path,
    others: &[(String, PathBuf)],
    columns: &Columns,
    joints: &[String],
    cancel: &CancelFlag,
) -> Result<(Log, LogReport), LogError> {
    let own = |q: Quantity| q.of(columns).file.is_none();
    let mut table = table_of(open_until(path, cancel)?, size(path), columns, joints, &own)?;
    for name in columns.files() {
        let Some((_, other)) = others.iter().find(|(known, _)| known == name) else {
            return Err(LogError::MissingFile {
                file: table.file,
                other: name.to_string(),
            });
        };
        let part = table_of(open_until(other, cancel)?, size(other), columns, joints, &|q| {
            q.of(columns).file.as_deref() == Some(name)
        })?;
        table.join(part)?;
    }
    cancel.leave_if_set();
    time_base::uniform(table, columns, cancel)
}

/// Bytes of the file, packed or not, as a hint: zero if unknown.
fn size(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |about| about.len())
}

/// A file that is read until `cancel` is set: every format comes through it, piece by piece.
struct Until<'a> {
    file: File,
    cancel: &'a CancelFlag,
}

impl Read for Until<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.cancel.leave_if_set();
        self.file.read(buffer)
    }
}

fn open_until<'a>(path: &Path, cancel: &'a CancelFlag) -> Result<Source<Until<'a>>, LogError> {
    let Source { name, bytes: file } = open(path)?;
    let bytes = Until { file, cancel };
    Ok(Source { name, bytes })
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
/// Rows of text are streamed: nothing is held but the columns that are used. What the file is, and whether it is packed, its
/// first bytes say.
///
/// # Errors
/// [`LogError`]: unreadable, empty or cut off, columns missing, too much garbage, time running backwards, too many gaps.
pub fn read_log<R: Read + Send>(source: Source<R>, columns: &Columns, joints: &[String]) -> Result<(Log, LogReport), LogError> {
    time_base::uniform(
        table_of(source, 0, columns, joints, &|_| true)?,
        columns,
        &CancelFlag::default(),
    )
}

/// How many rows a file has, as far as it says so by itself.
pub enum Rows {
    /// A line each, of this text.
    Lines(Box<dyn Read + Send>),
    /// A number of rows that the header of the file states.
    Counted(usize),
}

/// The rows of the file at `path`, before any is made a number.
///
/// # Errors
/// [`LogError`]: unreadable, empty, or no log at all.
pub fn rows_of(path: &Path) -> Result<Rows, LogError> {
    let Source { name, bytes } = open(path)?;
    let (kind, bytes) = unpacked(&name, bytes)?;
    match kind {
        Kind::Text => Ok(Rows::Lines(bytes)),
        #[cfg(feature = "formats")]
        kind => Ok(Rows::Counted(binary::open(&name, kind, bytes)?.rows())),
        #[cfg(not(feature = "formats"))]
        kind => Err(not_built(&name, kind)),
    }
}

#[cfg(not(feature = "formats"))]
fn not_built(file: &str, kind: Kind) -> LogError {
    let Foreign { what, remedy } = kind.as_not_built();
    let file = file.to_string();
    LogError::Foreign { file, what, remedy }
}

/// A file, opened as what it is.
pub(super) enum Opened<'a> {
    Text(TextLog<'a>),
    // Readers of such files are part of the feature.
    #[cfg_attr(not(feature = "formats"), expect(dead_code))]
    Sheet(Box<dyn Sheet + 'a>),
}

impl<'a> Opened<'a> {
    pub fn new<R: Read + Send + 'a>(file: &str, bytes: R) -> Result<Self, LogError> {
        let (kind, bytes) = unpacked(file, bytes)?;
        match kind {
            #[cfg(feature = "formats")]
            kind if kind != Kind::Text => Ok(Self::Sheet(binary::open(file, kind, bytes)?)),
            #[cfg(not(feature = "formats"))]
            kind if kind != Kind::Text => Err(not_built(file, kind)),
            _ => Ok(Self::Text(TextLog::open(file, bytes)?)),
        }
    }

    pub fn heading<'b>(&'b self, file: &'b str) -> Heading<'b> {
        match self {
            Self::Text(text) => text.heading(file),
            Self::Sheet(sheet) => sheet::heading(sheet.as_ref(), file),
        }
    }

    /// The columns that `places` has; `size` are the bytes of the file, as a hint.
    fn table(self, file: &str, size: u64, places: &Places) -> Result<Table, LogError> {
        let mut table = match self {
            Self::Text(text) => text_table(file, text, size, places)?,
            Self::Sheet(mut sheet) => sheet::table_of(file, sheet.as_mut(), places)?,
        };
        for (column, factor) in table.columns_mut().zip(&places.factors).filter(|(_, f)| **f != 1.0) {
            column.iter_mut().for_each(|v| *v *= factor);
        }
        Ok(table)
    }
}

fn text_table(file: &str, mut text: TextLog, size: u64, places: &Places) -> Result<Table, LogError> {
    let shape = RowShape::new(&text.dialect, places);
    let skipped = text.dialect.skipped as u64;
    let mut table = Table::new(file.to_string(), places, size);
    let take = |part: &mut Part, before: u64| table.append(part, skipped + before);
    for_each_part(&mut text.rows, &shape, take, |end| {
        let at = skipped + end.lines;
        match end.reason {
            Broken::Io(e) => broken(file, at, &e),
            Broken::LongLine => LogError::LongLine {
                file: file.to_string(),
                line: at + 1,
            },
        }
    })?;
    Ok(table)
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
    let opened = Opened::new(&file, bytes)?;
    let places = Places::find(&opened.heading(&file), columns, joints, wanted)?;
    let names = places.names(opened.heading(&file).names);
    let mut table = opened.table(&file, size, &places)?;
    table.names = names;
    table.findings.extend(places.findings);
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
