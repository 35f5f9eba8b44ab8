//! `dynident identify`.

use super::excite::{cancel_on_interrupt, put_robot};
use super::{Ending, files, render};
use crate::app::{Error, Identified, LogFile, identify};
use crate::io::shipped::Shipped;
use crate::io::{IdentifyRequest, NoExcitations, Parsed, read_identify_request};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Robot: a JSON or URDF file, or the name of one that comes with the program; replaces the one in the request.
    #[arg(long, value_name = "FILE|NAME")]
    robot: Option<String>,
    /// Log to identify from (CSV, plain or gzip); may be given several times.
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    log: Vec<PathBuf>,
    /// Log to validate with, which the fit does not see; may be given several times.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    validation: Vec<PathBuf>,
    /// Request: a JSON file as the `request` part of POST /identify; all defaults if left out.
    #[arg(long, value_name = "FILE")]
    request: Option<PathBuf>,
    /// Where the result goes; standard output if left out.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Where the identified model goes as JSON, for `validate`.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Where the identified model goes as URDF.
    #[arg(long, value_name = "FILE")]
    urdf: Option<PathBuf>,
}

pub fn run(arguments: &Arguments, json: bool) -> Result<Ending, Error> {
    let request = read_request(arguments)?;
    let cancel = cancel_on_interrupt()?;
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}").expect("a valid template");
    let bar = ProgressBar::new(1).with_style(style);
    let logs = |paths: &[PathBuf]| paths.iter().map(|p| LogFile::at(p)).collect::<Vec<_>>();
    let found = identify(
        &request,
        &logs(&arguments.log),
        &logs(&arguments.validation),
        &cancel,
        &|step| {
            bar.set_length(step.of as u64);
            bar.set_position(step.done as u64);
            bar.set_message(step.what);
        },
    );
    bar.finish_and_clear();
    write_results(arguments, json, &found?)?;
    Ok(Ending::Done)
}

fn read_request(arguments: &Arguments) -> Result<IdentifyRequest, Error> {
    let mut parsed = match &arguments.request {
        Some(path) => files::parse_json(path)?,
        None => Parsed {
            value: json!({}),
            problems: Vec::new(),
        },
    };
    if let Some(robot) = &arguments.robot {
        put_robot(&mut parsed, files::robot(robot)?);
    }
    read_identify_request(&parsed, &Shipped, &NoExcitations).map_err(|errors| {
        let error = Error::invalid("the identification request", errors);
        arguments
            .request
            .as_ref()
            .map_or(error.clone(), |path| files::in_file(path, error))
    })
}

fn write_results(arguments: &Arguments, json: bool, found: &Identified) -> Result<(), Error> {
    let document = files::pretty(&found.document);
    match &arguments.out {
        Some(out) => files::write(out, &document)?,
        None if json => files::print(&document)?,
        None => {}
    }
    if arguments.model.is_some() || arguments.urdf.is_some() {
        let model = found.model()?;
        if let Some(path) = &arguments.model {
            files::write(path, &files::pretty(&model.json))?;
        }
        if let Some(path) = &arguments.urdf {
            files::write(path, &model.urdf)?;
        }
    }
    if !json {
        files::print(&render::identification(&found.document))?;
    }
    Ok(())
}
