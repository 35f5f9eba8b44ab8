//! `dynident log`: what is understood of a log's file.

use super::known::EffectArguments;
use super::{Ending, files};
use crate::app::{Code, Error};
use crate::formats::logs::{Columns, FoundColumns, LogColumn, LogError, LogOverview, found_columns, log_overview};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Log: CSV, NPZ, MATLAB, Parquet, MCAP or rosbag2, plain, gzip or Zstandard.
    #[arg(value_name = "FILE")]
    log: PathBuf,
    /// Robot that the log is of, to see which column is taken for which joint: a file, or the name of one that comes with the
    /// program.
    #[arg(long, value_name = "FILE|NAME")]
    robot: Option<String>,
    #[command(flatten)]
    chain: files::ChainArguments,
    #[command(flatten)]
    effects: EffectArguments,
}

/// The columns, and what they are taken for where a robot is given.
#[derive(Serialize)]
struct Understood {
    #[serde(flatten)]
    overview: LogOverview,
    taken: Option<FoundColumns>,
}

pub fn run(arguments: &Arguments, json: bool) -> Result<Ending, Error> {
    let invalid = |e: LogError| Error::new(Code::InvalidLog, e.to_string());
    let log = files::logs(std::slice::from_ref(&arguments.log))?.swap_remove(0);
    let overview = log_overview(&log.path, &log.name).map_err(invalid)?;
    let taken = match &arguments.robot {
        Some(robot) => {
            let robot = files::read_robot(robot, &arguments.chain, &arguments.effects.read()?)?.robot;
            let joints: Vec<String> = robot.joints().iter().map(|j| j.name.clone()).collect();
            Some(found_columns(&log.path, &log.name, &[], &Columns::default(), &joints))
        }
        None => None,
    };
    if json {
        let taken = taken.transpose().map_err(invalid)?;
        files::print(&files::pretty(&Understood { overview, taken }))?;
        return Ok(Ending::Done);
    }
    // The columns are worth seeing also where they are not the robot's.
    files::print(&table(&overview, taken.as_ref().and_then(|t| t.as_ref().ok())))?;
    taken.transpose().map_err(invalid)?;
    Ok(Ending::Done)
}

fn table(overview: &LogOverview, taken: Option<&FoundColumns>) -> String {
    let rows = if overview.whole {
        "rows"
    } else {
        "rows in the first megabyte"
    };
    let width = overview
        .columns
        .iter()
        .map(|c| c.name.chars().count())
        .max()
        .unwrap_or(0)
        .clamp(6, 60);
    let mut text = format!(
        "{} {rows}, {} columns\n{:width$}  {:8} {:16} first values\n",
        overview.rows,
        overview.columns.len(),
        "column",
        "unit",
        "taken for"
    );
    for column in &overview.columns {
        let first = if column.numeric {
            values(column)
        } else {
            "no numbers".to_string()
        };
        let _ = writeln!(
            text,
            "{:width$}  {:8} {:16} {first}",
            column.name,
            column.unit.as_deref().unwrap_or("-"),
            taken.map_or(String::new(), |t| role(t, &column.name))
        );
    }
    text
}

fn values(column: &LogColumn) -> String {
    let number = |v: &Option<f64>| v.map_or("-".to_string(), |v| format!("{v:.6}"));
    column.first.iter().take(3).map(number).collect::<Vec<_>>().join("  ")
}

fn role(taken: &FoundColumns, name: &str) -> String {
    let of = |names: &[String], word: &str| names.iter().position(|n| n == name).map(|j| format!("{word} {}", j + 1));
    let time = taken.time.as_deref().filter(|t| *t == name).map(|_| "time".to_string());
    let joints = of(&taken.position, "position").or_else(|| of(&taken.torque, "torque"));
    time.or(joints)
        .or_else(|| of(&taken.velocity, "velocity"))
        .unwrap_or_default()
}
