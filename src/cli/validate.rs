//! `dynident validate`.

use super::excite::cancel_on_interrupt;
use super::known::EffectArguments;
use super::{Ending, files, render};
use crate::app::{Error, validate};
use crate::documents::{NoExcitations, read_validate_request};
use crate::formats::{Parsed, robot_file};
use crate::model::FieldProblem;
use serde_json::json;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model: the JSON or URDF model of an identification, or any robot with parameters for every link.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    #[command(flatten)]
    chain: files::ChainArguments,
    #[command(flatten)]
    effects: EffectArguments,
    /// Log to predict (CSV, NPZ, MATLAB, Parquet, MCAP, rosbag2; gzip and Zstandard as they are, folders of rosbag2); may be
    /// given several times.
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    log: Vec<PathBuf>,
    /// Request: a JSON file with `columns`, `preprocess`, `period_s`; all defaults if left out.
    #[arg(long, value_name = "FILE")]
    request: Option<PathBuf>,
    /// Where the result goes; standard output if left out.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments, json: bool) -> Result<Ending, Error> {
    let mut parsed = match &arguments.request {
        Some(path) => files::parse_json(path)?,
        None => Parsed {
            value: json!({}),
            problems: Vec::new(),
        },
    };
    let mut model = robot_file(&files::read(&arguments.model)?).map_err(|e| files::in_file(&arguments.model, e.into()))?;
    arguments.chain.put(&mut model.value)?;
    if let Some(fields) = parsed.value.as_object_mut() {
        fields.insert("model".into(), model.value);
    }
    let placed = |p: FieldProblem| FieldProblem {
        pointer: format!("/model{}", p.pointer),
        ..p
    };
    parsed.problems.extend(model.problems.into_iter().map(placed));
    let request = read_validate_request(&parsed, &arguments.effects.read()?, &NoExcitations)
        .map_err(|errors| files::in_file(&arguments.model, Error::invalid("the validation request", errors)))?;
    files::print_notes(&request.notes);
    let logs = files::logs(&arguments.log)?;
    let mut found = validate(&request, &logs, &cancel_on_interrupt()?)?;
    // The errors are safe before anything is made for pictures.
    files::write_early(arguments.out.as_deref(), &found.document)?;
    let predicted = found.predictions(&request);
    let document = &mut found.document;
    document.predictions_error = predicted.as_ref().err().map(|e| e.detail.clone());
    document.predictions = predicted.unwrap_or_default();
    let text = files::pretty(document);
    match &arguments.out {
        Some(out) => files::write(out, &text)?,
        None if json => return files::print(&text).map(|()| Ending::Done),
        None => {}
    }
    files::print(&if json { text } else { render::validation(document) })?;
    Ok(Ending::Done)
}
