//! The header of a file: which column is taken for what, without reading the rest of it.

use super::places::{Places, delimiter};
use super::reader::{broken, open};
use super::unpack::unpacked;
use super::{Columns, LogError};
use crate::model::INPUT_LIMITS;
use csv::{ReaderBuilder, Trim};
use serde::Serialize;
use std::io::{self, BufRead, Read};
use std::path::Path;

/// Headers of the columns that are read, one per joint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct FoundColumns {
    /// Null where the file has no time column.
    pub time: Option<String>,
    pub position: Vec<String>,
    /// Empty where the file has no velocities.
    pub velocity: Vec<String>,
    pub torque: Vec<String>,
    /// Those that nothing is made of.
    pub unused: Vec<String>,
}

/// The columns of the file at `path`, called `file` in errors.
///
/// # Errors
/// [`LogError`]: unreadable, empty, or columns missing.
pub fn found_columns(path: &Path, file: &str, columns: &Columns, joints: &[String]) -> Result<FoundColumns, LogError> {
    let source = open(path).map_err(|e| e.named(file))?;
    let header = Header::read(file, &mut unpacked(file, source.bytes)?)?;
    let names = header.names;
    let places = Places::find(file, &names, columns, joints, &|_| true)?;
    let named = |places: &[usize]| places.iter().map(|&at| names[at].clone()).collect::<Vec<_>>();
    let used: Vec<usize> = places.time.into_iter().chain(places.all()).collect();
    let unused: Vec<usize> = (0..names.len()).filter(|at| !used.contains(at)).collect();
    Ok(FoundColumns {
        time: places.time.map(|at| names[at].clone()),
        position: named(&places.q),
        velocity: named(&places.qd),
        torque: named(&places.tau),
        unused: named(&unused),
    })
}

/// The first line that is neither empty nor a comment.
pub(super) struct Header {
    pub delimiter: u8,
    pub names: Vec<String>,
    /// Lines of the file as far as the header, which is one of them.
    pub lines: u64,
}

/// Longest header that is read (bytes).
const LONGEST_HEADER: usize = INPUT_LIMITS.log_header;

impl Header {
    /// Reads as far as the end of the header.
    pub fn read(file: &str, bytes: &mut impl BufRead) -> Result<Self, LogError> {
        let head = head(bytes).map_err(|e| broken(file, 1, &e))?;
        if head.len() > LONGEST_HEADER {
            return Err(LogError::LongHeader {
                file: file.to_string(),
                limit: LONGEST_HEADER,
            });
        }
        let delimiter = delimiter(&head);
        let mut reader = ReaderBuilder::new()
            .delimiter(delimiter)
            .trim(Trim::All)
            .comment(Some(b'#'))
            .from_reader(head.as_slice());
        let names = reader.byte_headers().map_err(|e| LogError::Unreadable {
            file: file.to_string(),
            detail: format!("line 1: {e}"),
        })?;
        if names.len() > INPUT_LIMITS.log_columns {
            return Err(LogError::TooManyColumns {
                file: file.to_string(),
                columns: names.len(),
                limit: INPUT_LIMITS.log_columns,
            });
        }
        let text = |name: &[u8]| String::from_utf8_lossy(name).trim_start_matches('\u{feff}').to_string();
        Ok(Self {
            delimiter,
            names: names.iter().map(text).collect(),
            lines: memchr::memchr_iter(b'\n', &head).count() as u64,
        })
    }
}

/// The file as far as its header's end, or one byte more than the longest.
fn head(bytes: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    let mut line = 0;
    while head.len() <= LONGEST_HEADER {
        let most = (LONGEST_HEADER + 1 - head.len()) as u64;
        let read = bytes.by_ref().take(most).read_until(b'\n', &mut head)?;
        if read == 0 || !matches!(head[line], b'#' | b'\r' | b'\n') {
            break;
        }
        line = head.len();
    }
    Ok(head)
}
