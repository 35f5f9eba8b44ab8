//! Log files, and how they become rows.

use crate::app::{CancelFlag, Code, Error};
use crate::diagnosis::{DataFault, RawLog, leave_out, lost_rows, sample_faults};
use crate::formats::logs::{Columns, LogError, LogReport, read_joined_log_until};
use crate::model::Robot;
use crate::preparation::{Log, PreparedLog, PreprocessOptions, prepare_until};
use crate::regression::Stretch;
use std::path::{Path, PathBuf};

/// A log file and the name that the answer calls it by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogFile {
    /// Name in messages and answers.
    pub name: String,
    /// Path of the content, which may have another name.
    pub path: PathBuf,
}

impl LogFile {
    /// Called by its file name.
    pub fn at(path: &Path) -> Self {
        let name = path
            .file_name()
            .map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
        Self {
            name,
            path: path.to_path_buf(),
        }
    }
}

/// One log on its way: what was found in the file, and what became of it.
#[derive(Debug, Clone)]
pub struct UsedLog {
    /// What was found in the file.
    pub report: LogReport,
    /// Motion and torque on one grid, ready for a regression.
    pub prepared: PreparedLog,
    /// Constant, clipped or frozen columns.
    pub sample_faults: Vec<DataFault>,
}

/// How log files become rows.
#[derive(Clone, Copy)]
pub(in super::super) struct Reading<'a> {
    pub robot: &'a Robot,
    pub columns: &'a Columns,
    pub preprocess: &'a PreprocessOptions,
    pub trace: bool,
    /// Leaves the reading when it is set.
    pub cancel: &'a CancelFlag,
}

/// Files beside a log: name and path.
pub(in super::super) type Companions = Vec<(String, PathBuf)>;

/// The logs among `files`, and the files that `columns` puts beside one, by name.
pub(in super::super) fn split_companions<'a>(
    columns: &Columns,
    files: &'a [LogFile],
) -> Result<(Vec<&'a LogFile>, Companions), Error> {
    let named = columns.files();
    let (beside, logs): (Vec<&LogFile>, Vec<&LogFile>) = files.iter().partition(|f| named.contains(&f.name.as_str()));
    if !named.is_empty() && logs.len() > 1 {
        let names: Vec<&str> = logs.iter().map(|l| l.name.as_str()).collect();
        return Err(Error::new(
            Code::InvalidLog,
            format!(
                "`columns` puts {} beside one log, and there are {}: {}",
                named.join(" and "),
                logs.len(),
                names.join(", ")
            ),
        )
        .with_hint("join the files of each recording into one, or identify from one recording at a time"));
    }
    if !beside.is_empty() && logs.is_empty() {
        let detail = format!("{} is given without the log that it stands beside", named.join(" and "));
        return Err(Error::new(Code::InvalidLog, detail).with_hint("give the file with the positions as a log too"));
    }
    Ok((logs, beside.into_iter().map(|f| (f.name.clone(), f.path.clone())).collect()))
}

/// A log as it was read, before anything is made of it.
pub(in super::super) struct RawFile {
    pub log: Log,
    report: LogReport,
    sample_faults: Vec<DataFault>,
}

/// Reads and prepares one log; its rows come beside it.
pub(in super::super) fn use_log(
    reading: &Reading,
    file: &LogFile,
    beside: &[(String, PathBuf)],
) -> Result<(UsedLog, Stretch), Error> {
    prepared(reading, raw_log(reading, file, beside)?)
}

/// Reads one log.
pub(in super::super) fn raw_log(reading: &Reading, file: &LogFile, beside: &[(String, PathBuf)]) -> Result<RawFile, Error> {
    reading.cancel.leave_if_set();
    let names: Vec<String> = reading.robot.joints().iter().map(|j| j.name.clone()).collect();
    let invalid = |e: String| Error::new(Code::InvalidLog, e);
    let (mut log, mut report) = read_joined_log_until(&file.path, beside, reading.columns, &names, reading.cancel)
        .map_err(|e| invalid(called(e, file, beside).to_string()))?;
    reading.cancel.leave_if_set();
    log.name.clone_from(&file.name);
    report.file.clone_from(&file.name);
    let sample_faults = if reading.trace {
        left_out(reading.robot, &mut log)
    } else {
        Vec::new()
    };
    reading.cancel.leave_if_set();
    Ok(RawFile {
        log,
        report,
        sample_faults,
    })
}

/// Makes rows of a log.
pub(in super::super) fn prepared(reading: &Reading, raw: RawFile) -> Result<(UsedLog, Stretch), Error> {
    let joints = reading.robot.joint_count();
    let prepared = prepare_until(&raw.log, joints, reading.preprocess, reading.cancel)
        .map_err(|e| Error::new(Code::InvalidLog, e.to_string()))?;
    reading.cancel.leave_if_set();
    let stretch = Stretch::new(&prepared, &raw.log);
    let used = UsedLog {
        report: raw.report,
        prepared,
        sample_faults: raw.sample_faults,
    };
    Ok((used, stretch))
}

/// Faults of the log's samples; the rows that they have spoiled are left out of it.
fn left_out(robot: &Robot, log: &mut Log) -> Vec<DataFault> {
    let raw = RawLog {
        time: Vec::new(),
        q: log.q.clone(),
        tau: log.tau.clone(),
    };
    let faults = sample_faults(robot, &raw);
    if !faults.is_empty() {
        leave_out(log, &lost_rows(&raw));
    }
    faults
}

/// The error with the names that the user knows: an upload is a temporary file with a name of its own.
fn called(error: LogError, file: &LogFile, beside: &[(String, PathBuf)]) -> LogError {
    let on_disk = |path: &Path| path.file_name().is_some_and(|n| n.to_string_lossy() == error.file());
    let name = beside
        .iter()
        .find(|(_, path)| on_disk(path))
        .map_or(&file.name, |(name, _)| name);
    let name = name.clone();
    error.named(&name)
}
