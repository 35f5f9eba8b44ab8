//! Which column of a file is taken for what, without reading the rest of it.

use super::reader::{Places, delimiter};
use super::{Columns, LogError};
use csv::{ReaderBuilder, Trim};
use flate2::read::MultiGzDecoder;
use serde::Serialize;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
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
    let unreadable = |e: io::Error| LogError::Unreadable {
        file: file.to_string(),
        detail: e.to_string(),
    };
    let mut plain = BufReader::new(File::open(path).map_err(unreadable)?);
    let packed = plain.fill_buf().map_err(unreadable)?.starts_with(&[0x1f, 0x8b]);
    let mut bytes: Box<dyn BufRead> = match packed {
        true => Box::new(BufReader::new(MultiGzDecoder::new(plain))),
        false => Box::new(plain),
    };
    let delimiter = delimiter(bytes.fill_buf().map_err(unreadable)?);
    let mut reader = ReaderBuilder::new()
        .delimiter(delimiter)
        .trim(Trim::All)
        .comment(Some(b'#'))
        .from_reader(bytes);
    let header = reader.byte_headers().map_err(|e| LogError::Unreadable {
        file: file.to_string(),
        detail: e.to_string(),
    })?;
    let header: Vec<String> = header
        .iter()
        .map(|h| String::from_utf8_lossy(h).trim_start_matches('\u{feff}').to_string())
        .collect();
    let places = Places::find(file, &header, columns, joints, &|_| true)?;
    let named = |places: &[usize]| places.iter().map(|&at| header[at].clone()).collect::<Vec<_>>();
    let used: Vec<usize> = places.time.into_iter().chain(places.all()).collect();
    let unused: Vec<usize> = (0..header.len()).filter(|at| !used.contains(at)).collect();
    Ok(FoundColumns {
        time: places.time.map(|at| header[at].clone()),
        position: named(&places.q),
        velocity: named(&places.qd),
        torque: named(&places.tau),
        unused: named(&unused),
    })
}
