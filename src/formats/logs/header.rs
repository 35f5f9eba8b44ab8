//! The columns of a file: which is taken for what, without reading the rest of it.

use super::places::{Heading, Places, Wanted};
use super::reader::{Opened, open};
use super::{Columns, LogError};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Headers of the columns that are read, one per joint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct FoundColumns {
    /// Null where the file has no time column.
    pub time: Option<String>,
    /// Headers of the position columns, in the order of the joints.
    pub position: Vec<String>,
    /// Empty where the file has no velocities.
    pub velocity: Vec<String>,
    /// Headers of the torque columns, in the order of the joints.
    pub torque: Vec<String>,
    /// Those that nothing is made of.
    pub unused: Vec<String>,
}

/// The columns of the file at `path`, called `file` in errors, and of the files that `columns` puts beside it: names and paths in
/// `others`.
///
/// # Errors
/// [`LogError`]: unreadable, empty, columns or a file missing.
pub fn found_columns(
    path: &Path,
    file: &str,
    others: &[(String, PathBuf)],
    columns: &Columns,
    joints: &[String],
) -> Result<FoundColumns, LogError> {
    let mut found = of_file(path, file, columns, joints, &|q| q.of(columns).file.is_none())?;
    for name in columns.files() {
        let Some((_, other)) = others.iter().find(|(known, _)| known == name) else {
            return Err(LogError::MissingFile {
                file: file.to_string(),
                other: name.to_string(),
            });
        };
        let part = of_file(other, name, columns, joints, &|q| q.of(columns).file.as_deref() == Some(name))?;
        found.velocity.extend(part.velocity);
        found.torque.extend(part.torque);
        found.unused.extend(part.unused);
    }
    Ok(found)
}

fn of_file(path: &Path, file: &str, columns: &Columns, joints: &[String], wanted: &Wanted) -> Result<FoundColumns, LogError> {
    let source = open(path).map_err(|e| e.named(file))?;
    let opened = Opened::new(file, source.bytes)?;
    let heading = opened.heading(file);
    let places = Places::find(&heading, columns, joints, wanted)?;
    Ok(FoundColumns::from_heading(&heading, &places))
}

impl FoundColumns {
    fn from_heading(heading: &Heading, places: &Places) -> Self {
        let names = heading.names;
        let named = |places: &[usize]| places.iter().map(|&at| names[at].name.clone()).collect::<Vec<_>>();
        let used: Vec<usize> = places.time.into_iter().chain(places.all()).collect();
        let unused: Vec<usize> = (0..names.len()).filter(|at| !used.contains(at)).collect();
        Self {
            time: places.time.map(|at| names[at].name.clone()),
            position: named(&places.q),
            velocity: named(&places.qd),
            torque: named(&places.tau),
            unused: named(&unused),
        }
    }
}
