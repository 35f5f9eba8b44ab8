//! `dynident identify`.

use super::excite::{cancel_on_interrupt, put_robot};
use super::known::EffectArguments;
use super::model::OwnUrdf;
use super::plots::{PictureKind, pictures, write_picture};
use super::{Ending, files, model, render};
use crate::app::{Code, Error, Identified, drawn, identify};
use crate::documents::{IdentifyDocument, IdentifyRequest, NoExcitations, read_identify_request};
use crate::formats::{ModelFormat, Parsed};
use crate::web::figures::Figure;
use crate::web::{Circumstances, report};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Robot: a JSON or URDF file, or the name of one that comes with the program; replaces the one in the request.
    #[arg(long, value_name = "FILE|NAME")]
    robot: Option<String>,
    #[command(flatten)]
    chain: files::ChainArguments,
    #[command(flatten)]
    effects: EffectArguments,
    /// Log to identify from (CSV, NPZ, MATLAB, Parquet, MCAP, rosbag2; gzip and Zstandard as they are, folders of rosbag2); may
    /// be given several times.
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
    /// Where the identified model goes, in the format of the file's ending: .json (for `validate`), .urdf, .xml (MJCF), .sdf,
    /// .csv, .c, .py; may be given several times.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    model: Vec<PathBuf>,
    /// Where the identified model goes as URDF.
    #[arg(long, value_name = "FILE")]
    urdf: Option<PathBuf>,
    /// URDF file of your own: the models that are written as URDF are this file with the identified bodies put in, all else as it
    /// is.
    #[arg(long, value_name = "FILE")]
    patch_urdf: Option<PathBuf>,
    /// Where the report goes: one HTML file that stands alone and prints.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Folder for pictures of torques, parameters and errors.
    #[arg(long, value_name = "FOLDER")]
    plots: Option<PathBuf>,
    /// Kind of those pictures.
    #[arg(long, value_enum, default_value_t = PictureKind::Svg, requires = "plots")]
    plot_format: PictureKind,
}

/// Points of every drawn series, where the request has fewer: more than a page shows.
const DRAWN_POINTS: usize = 2000;

pub fn run(arguments: &Arguments, json: bool) -> Result<Ending, Error> {
    let request = read_request(arguments)?;
    files::print_notes(&request.notes);
    let cancel = cancel_on_interrupt()?;
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}").expect("a valid template");
    let bar = ProgressBar::new(1).with_style(style);
    let found = identify(
        &request,
        &files::logs(&arguments.log)?,
        &files::logs(&arguments.validation)?,
        &cancel,
        &|step| {
            bar.set_length(step.of as u64);
            bar.set_position(step.done as u64);
            bar.set_message(step.what);
        },
    );
    bar.finish_and_clear();
    write_results(arguments, json, found?, &request)?;
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
    match &arguments.robot {
        Some(robot) => put_robot(&mut parsed, files::robot(robot, &arguments.chain)?),
        None => arguments
            .chain
            .put(parsed.value.get_mut("robot").unwrap_or(&mut Value::Null))?,
    }
    let mut request = read_identify_request(&parsed, &arguments.effects.read()?, &NoExcitations).map_err(|errors| {
        let error = Error::invalid("the identification request", errors);
        arguments
            .request
            .as_ref()
            .map_or(error.clone(), |path| files::in_file(path, error))
    })?;
    if arguments.report.is_some() || arguments.plots.is_some() {
        request.prediction_points = request.prediction_points.max(DRAWN_POINTS);
    }
    Ok(request)
}

/// Files first: what fails after that is a picture, and costs nothing but itself.
fn write_results(arguments: &Arguments, json: bool, mut found: Identified, request: &IdentifyRequest) -> Result<(), Error> {
    files::write_early(arguments.out.as_deref(), &found.document)?;
    let model = write_model(arguments, &found);
    let predicted = found.predictions(request);
    found.document.predictions_error = predicted.as_ref().err().map(|e| e.detail.clone());
    let failed = predicted.map(|series| found.document.predictions = series).err();
    let document = files::pretty(&found.document);
    match &arguments.out {
        Some(out) => files::write(out, &document)?,
        None if json => files::print(&document)?,
        None => {}
    }
    let pictures = draw(arguments, &found);
    if !json {
        files::print(&render::identification(&found.document))?;
    }
    model.and(failed.map_or(Ok(()), Err)).and(pictures)
}

fn write_model(arguments: &Arguments, found: &Identified) -> Result<(), Error> {
    let by_ending = arguments.model.iter().map(|path| (path, ModelFormat::of_file(path)));
    let as_urdf = arguments.urdf.iter().map(|path| (path, ModelFormat::Urdf));
    let targets: Vec<(&PathBuf, ModelFormat)> = by_ending.chain(as_urdf).collect();
    if targets.is_empty() {
        return Ok(());
    }
    let files = found.model()?;
    let own = OwnUrdf {
        file: arguments.patch_urdf.as_deref(),
        chain: &arguments.chain,
    };
    targets
        .into_iter()
        .try_for_each(|(path, format)| model::write(path, format, files, &own))
}

/// The report and the pictures that were asked for. One that fails does not keep the others from being made; the first error is
/// reported.
fn draw(arguments: &Arguments, found: &Identified) -> Result<(), Error> {
    let report = match &arguments.report {
        Some(path) => write_report(path, &found.document),
        None => Ok(()),
    };
    let plots = match &arguments.plots {
        Some(folder) => write_pictures(folder, arguments.plot_format, &found.document),
        None => Ok(()),
    };
    report.and(plots)
}

fn write_report(path: &Path, document: &IdentifyDocument) -> Result<(), Error> {
    let executed = document.provenance.as_ref().and_then(|p| p.request.get("excitation"));
    let circumstances = Circumstances {
        design: executed.filter(|e| e.is_object()).cloned(),
        ..Circumstances::default()
    };
    files::write(path, drawn("the report", || report(document, &circumstances))?)
}

fn write_pictures(folder: &Path, kind: PictureKind, document: &IdentifyDocument) -> Result<(), Error> {
    let unwritable = |e: std::io::Error| {
        Error::new(
            Code::FileUnwritable,
            format!("cannot make the folder {}: {e}", folder.display()),
        )
    };
    std::fs::create_dir_all(folder).map_err(unwritable)?;
    let write = |(name, figure): (String, Figure)| {
        drawn(&format!("the picture {name}"), || {
            write_picture(&folder.join(&name), kind, &figure)
        })?
    };
    let all = drawn("the pictures", || pictures(document))?;
    all.into_iter().map(write).fold(Ok(()), Result::and)
}
