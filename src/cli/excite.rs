//! `dynident excite`.

use super::known::EffectArguments;
use super::plots::{PictureKind, write_picture};
use super::{Ending, files, render};
use crate::app::{CancelFlag, Code, Error, Excited, Runs, excite, runs};
use crate::documents::{ExcitationRequest, read_excitation_request};
use crate::excitation::{Backoff, LONGEST_RUN_IN_S, Problem, Progress, first_run};
use crate::formats::{Parsed, TrajectoryFile, TrajectoryFormat};
use crate::model::FieldProblem;
use crate::trajectory::FourierSeries;
use crate::web::figures::design_figure;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Robot: a JSON or URDF file, or the name of one that comes with the program; replaces the one in the request.
    #[arg(long, value_name = "FILE|NAME")]
    robot: Option<String>,
    #[command(flatten)]
    chain: files::ChainArguments,
    #[command(flatten)]
    effects: EffectArguments,
    /// Request: a JSON file as for POST /excitation.
    #[arg(long, value_name = "FILE")]
    request: PathBuf,
    /// Where the result goes; standard output if left out.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Model with effects to design for: JSON as `identify --model` writes it; replaces the one in the request.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// What there is already and the new trajectory complements: JSON models or results of designs; adds to `given` of the
    /// request.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    given: Vec<PathBuf>,
    /// Also write the sampled motion, in the format of the name's ending: .csv (time, q1…, qd1…, qdd1…), .json (JointTrajectory
    /// of ROS 2), .yaml (FollowJointTrajectory goal), .script (URScript servoj), .mcap (JointState messages), .npz (NumPy).
    #[arg(long, value_name = "FILE")]
    trajectory: Option<PathBuf>,
    /// Samples per second of that file; the rate of the request if left out.
    #[arg(long, value_name = "HZ", requires = "trajectory", value_parser = positive)]
    rate_hz: Option<f64>,
    /// Periods of that file.
    #[arg(long, value_name = "NUMBER", requires = "trajectory", default_value_t = 1)]
    periods: usize,
    /// Pose at rest that the trajectory file begins and ends at: positions of the joints (rad or m), comma-separated. The ways
    /// into the motion and out of it keep every limit of the design.
    #[arg(
        long,
        value_name = "Q1,Q2,…",
        requires = "trajectory",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    from: Option<Vec<f64>>,
    /// Duration of the way into the motion (s); 0 for none. With --from chosen if left out.
    #[arg(long, value_name = "S", requires = "trajectory", value_parser = run_duration)]
    run_in_s: Option<f64>,
    /// Duration of the way out of the motion (s); 0 for none. With --from chosen if left out.
    #[arg(long, value_name = "S", requires = "trajectory", value_parser = run_duration)]
    run_out_s: Option<f64>,
    /// Also write a first run, in the format of the name's ending: smaller amplitudes around where the motion starts.
    #[arg(long, value_name = "FILE", requires = "backoff")]
    first_run: Option<PathBuf>,
    /// Factor on the amplitudes of the first run, above 0 to 1; replaces the one in the request.
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    backoff: Option<f64>,
    /// Factor on the time that the first run takes, 1 to 100.
    #[arg(long, value_name = "FACTOR", requires = "first_run", value_parser = slowness)]
    slow: Option<f64>,
    /// Also draw positions, velocities and accelerations: SVG, or PNG if the name ends so.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

fn positive(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err("must be above zero".into())
    }
}

fn run_duration(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    match (0.0..=LONGEST_RUN_IN_S).contains(&value) {
        true => Ok(value),
        false => Err(format!("must be from 0 to {LONGEST_RUN_IN_S}")),
    }
}

fn slowness(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if (1.0..=100.0).contains(&value) {
        Ok(value)
    } else {
        Err("must be from 1 to 100".into())
    }
}

pub fn run(arguments: &Arguments, json: bool) -> Result<Ending, Error> {
    let request = read_request(arguments)?;
    let cancel = cancel_on_interrupt()?;
    let bar = progress_bar(&request);
    let excited = excite(&request, &cancel, &|p| show(&bar, p));
    bar.finish_and_clear();
    if let (Some(path), Some(series)) = (&arguments.plot, &excited.series) {
        write_picture(
            path,
            PictureKind::from_path(path),
            &design_figure(request.problem.robot(), series),
        )?;
    }
    write_results(arguments, json, &excited, &request.problem)?;
    Ok(match excited.document.status {
        "Infeasible" => Ending::Infeasible,
        "Cancelled" => Ending::Cancelled,
        _ => Ending::Done,
    })
}

fn read_request(arguments: &Arguments) -> Result<ExcitationRequest, Error> {
    let mut parsed = files::parse_json(&arguments.request)?;
    match &arguments.robot {
        Some(robot) => put_robot(&mut parsed, files::robot(robot, &arguments.chain)?),
        None => arguments
            .chain
            .put(parsed.value.get_mut("robot").unwrap_or(&mut Value::Null))?,
    }
    put_data(&mut parsed, arguments)?;
    let invalid = |errors| files::in_file(&arguments.request, Error::invalid("the excitation request", errors));
    read_excitation_request(&parsed, &arguments.effects.read()?).map_err(invalid)
}

/// Puts model, data and back-off of the command line into the request.
fn put_data(request: &mut Parsed, arguments: &Arguments) -> Result<(), Error> {
    let Some(fields) = request.value.as_object_mut() else {
        return Ok(());
    };
    if let Some(path) = &arguments.model {
        fields.insert("model".into(), files::parse_json(path)?.value);
    }
    if let Some(factor) = arguments.backoff {
        fields.insert("backoff".into(), factor.into());
    }
    for path in &arguments.given {
        let read = files::parse_json(path)?.value;
        // Of the result of a design, what makes its motion.
        let motion = ["coefficients", "offset", "fundamental_hz", "periods"];
        let part = |name: &str| Some((name.to_string(), read.get(name)?.clone()));
        let entry = match read.get("coefficients") {
            Some(_) => Value::Object(motion.into_iter().filter_map(part).collect()),
            None => read,
        };
        let given = fields.entry("given").or_insert_with(|| Value::Array(Vec::new()));
        if let Some(list) = given.as_array_mut() {
            list.push(entry);
        }
    }
    Ok(())
}

/// Puts the robot of the command line into the request, with what was wrong with its numbers.
pub(super) fn put_robot(request: &mut Parsed, robot: Parsed) {
    let Some(fields) = request.value.as_object_mut() else { return };
    fields.insert("robot".into(), robot.value);
    request.problems.retain(|p| !p.pointer.starts_with("/robot"));
    let placed = |p: FieldProblem| FieldProblem {
        pointer: format!("/robot{}", p.pointer),
        ..p
    };
    request.problems.extend(robot.problems.into_iter().map(placed));
}

/// The first Ctrl-C (or SIGTERM) ends the search and keeps the best found, the second ends the program.
pub(super) fn cancel_on_interrupt() -> Result<CancelFlag, Error> {
    // A process has one handler, also where it runs several commands.
    static SET: OnceLock<CancelFlag> = OnceLock::new();
    if let Some(cancel) = SET.get() {
        return Ok(cancel.clone());
    }
    let cancel = SET.get_or_init(CancelFlag::default).clone();
    let flag = cancel.clone();
    let set = ctrlc::set_handler(move || {
        if flag.is_cancelled() {
            // 128 + SIGINT, as shells expect of a program that was interrupted.
            std::process::exit(130);
        }
        flag.cancel();
    });
    set.map_err(|e| Error::new(Code::Internal, format!("cannot listen for Ctrl-C: {e}")))?;
    Ok(cancel)
}

/// A bar over the time limit; hidden by itself where standard error is no terminal.
fn progress_bar(request: &ExcitationRequest) -> ProgressBar {
    let milliseconds = (request.search.time_limit_s * 1e3) as u64;
    let style = ProgressStyle::with_template("{bar:30} {elapsed} {msg}").expect("a valid template");
    let bar = ProgressBar::new(milliseconds.max(1)).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

fn show(bar: &ProgressBar, p: &Progress) {
    bar.set_position(bar.elapsed().as_millis() as u64);
    bar.set_message(format!(
        "best {:.3}, {}/{} starts, {} evaluations",
        p.best, p.starts_finished, p.starts, p.evaluations
    ));
}

/// Writes `periods` of a motion in the format of the file's ending.
fn write_motion(
    arguments: &Arguments,
    excited: &Excited,
    series: &FourierSeries,
    path: &Path,
    periods: usize,
    [run_in, run_out]: [Option<FourierSeries>; 2],
) -> Result<(), Error> {
    let file = TrajectoryFile {
        run_in,
        run_out,
        joints: &excited.document.joints,
        series,
        rate_hz: rate(arguments, excited),
        periods: periods.max(1),
    };
    let parts = file.parts(TrajectoryFormat::of_file(path));
    let parts = parts.map_err(|why| Error::new(Code::FileUnwritable, format!("{}: the format {why}", path.display())))?;
    files::write_parts(path, parts)
}

fn rate(arguments: &Arguments, excited: &Excited) -> f64 {
    arguments.rate_hz.unwrap_or(excited.document.sample_rate_hz)
}

/// The first run, smaller and as much slower as was asked for.
fn first_run_of(arguments: &Arguments, excited: &Excited, problem: &Problem) -> Result<Option<FourierSeries>, Error> {
    let (Some(slowness), Some(amplitude), Some(series)) = (
        arguments.slow,
        excited.first_run.as_ref().and(arguments.backoff),
        &excited.series,
    ) else {
        return Ok(excited.first_run.clone());
    };
    let run = first_run(problem, series, Backoff { amplitude, slowness });
    let none = || Error::new(Code::NoTrajectory, "no part of this motion keeps every limit along the path");
    Ok(Some(run.ok_or_else(none)?.series))
}

fn write_results(arguments: &Arguments, json: bool, excited: &Excited, problem: &Problem) -> Result<(), Error> {
    let document = files::pretty(&excited.document);
    match &arguments.out {
        Some(out) => files::write(out, &document)?,
        None => files::print(&document)?,
    }
    if let (Some(path), Some(series)) = (&arguments.trajectory, &excited.series) {
        let asked = Runs {
            from: arguments.from.clone(),
            run_in_s: arguments.run_in_s,
            run_out_s: arguments.run_out_s,
        };
        let ways = runs(problem, series, &asked, rate(arguments, excited))?;
        write_motion(arguments, excited, series, path, arguments.periods, ways)?;
    }
    if let (Some(path), Some(series)) = (&arguments.first_run, first_run_of(arguments, excited, problem)?) {
        write_motion(arguments, excited, &series, path, 1, [None, None])?;
    }
    if arguments.out.is_none() {
        return Ok(());
    }
    match json {
        true => files::print(&document),
        false => files::print(&render::summary(&excited.document)),
    }
}
