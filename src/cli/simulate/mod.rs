//! `dynident simulate`: a virtual robot writes a log.

mod check;

use self::check::{check, not_finite};
use super::known::EffectArguments;
use super::{Ending, files};
use crate::app::Error;
use crate::documents::RobotDocument;
use crate::formats::shortest;
use crate::model::{FieldProblem, Robot};
use crate::parameters::Layout;
use crate::simulate::{Experiment, HiddenEffect, LogFault, Noise, RecordedLog, corrupt, simulate};
use crate::trajectory::{FourierSeries, QuinticWayPoints, SineSeries, Trajectory};
use nalgebra::DMatrix;
use serde::Deserialize;
use serde_json::Value;
use serde_path_to_error::Segment;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Robot: a JSON or URDF file, or the name of one that comes with the program.
    #[arg(long, value_name = "FILE|NAME")]
    robot: String,
    #[command(flatten)]
    chain: files::ChainArguments,
    #[command(flatten)]
    effects: EffectArguments,
    /// Request: a JSON file with `trajectory`, and as wanted `parameters`, `periods`, `sample_rate_hz`, `noise`, `effects`,
    /// `faults`, `seed`.
    #[arg(long, value_name = "FILE")]
    request: PathBuf,
    /// Where the log goes (CSV); standard output if left out.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Request {
    /// Standard parameters; the robot's prior link parameters if left out.
    parameters: Option<Vec<f64>>,
    trajectory: Path,
    #[serde(default = "one")]
    periods: f64,
    #[serde(default = "usual_rate")]
    sample_rate_hz: f64,
    noise: Option<Noise>,
    #[serde(default)]
    effects: Vec<HiddenEffect>,
    #[serde(default)]
    faults: Vec<LogFault>,
    #[serde(default)]
    seed: u64,
}

fn one() -> f64 {
    1.0
}

fn usual_rate() -> f64 {
    200.0
}

/// A trajectory as documents have it.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Path {
    Fourier {
        fundamental_hz: f64,
        a: Vec<Vec<f64>>,
        b: Vec<Vec<f64>>,
        offset: Option<Vec<f64>>,
    },
    WayPoints {
        positions: Vec<Vec<f64>>,
        durations: Vec<f64>,
    },
    Sines {
        terms: Vec<Vec<(f64, f64)>>,
        duration: f64,
    },
}

pub fn run(arguments: &Arguments, json: bool) -> Result<Ending, Error> {
    let RobotDocument { robot, notes, .. } = files::read_robot(&arguments.robot, &arguments.chain, &arguments.effects.read()?)?;
    files::print_notes(&notes);
    let crate::formats::Parsed {
        value: mut document,
        mut problems,
    } = files::parse_json(&arguments.request)?;
    number_joints(&mut document, &robot, "", &mut problems);
    if problems.is_empty() {
        readable::<HiddenEffect>(&document, "effects", &mut problems);
        readable::<LogFault>(&document, "faults", &mut problems);
    }
    let invalid = |problems| files::in_file(&arguments.request, Error::invalid("the simulation request", problems));
    if !problems.is_empty() {
        return Err(invalid(problems));
    }
    let request: Request = read(&document).map_err(|problem| invalid(vec![problem]))?;
    check(&request, &robot, &mut problems);
    if !problems.is_empty() {
        return Err(invalid(problems));
    }
    let log = record(&request, &robot).ok_or_else(|| {
        invalid(vec![FieldProblem::new(
            "/parameters",
            "is missing, and the robot has no prior parameters for every link",
        )])
    })?;
    if let Some(problem) = not_finite(&log, &robot) {
        return Err(invalid(vec![problem]));
    }
    match &arguments.out {
        Some(out) => files::write_parts(out, csv(&log))?,
        None => return csv(&log).try_for_each(|part| files::print(&part)).map(|()| Ending::Done),
    }
    let done = serde_json::json!({"rows": log.time.len(), "joints": log.q.len()});
    files::print(&if json {
        files::pretty(&done)
    } else {
        format!("{} rows of {} joints\n", log.time.len(), log.q.len())
    })?;
    Ok(Ending::Done)
}

/// A value as its type, or where in it the type is not met.
fn read<T: serde::de::DeserializeOwned>(value: &Value) -> Result<T, FieldProblem> {
    serde_path_to_error::deserialize(value).map_err(|e| FieldProblem::new(pointer(e.path()), e.inner().to_string()))
}

fn pointer(path: &serde_path_to_error::Path) -> String {
    let step = |segment: &Segment| match segment {
        Segment::Seq { index } => format!("/{index}"),
        Segment::Map { key } | Segment::Enum { variant: key } => format!("/{}", key.replace('~', "~0").replace('/', "~1")),
        Segment::Unknown => String::new(),
    };
    path.iter().map(step).collect()
}

/// Entries of a list that cannot be read, each by its place.
fn readable<T: serde::de::DeserializeOwned>(document: &Value, list: &str, problems: &mut Vec<FieldProblem>) {
    let entries = document[list].as_array().into_iter().flatten().enumerate();
    problems.extend(entries.filter_map(|(i, entry)| {
        let problem = T::deserialize(entry).err()?;
        Some(FieldProblem::new(format!("/{list}/{i}"), problem.to_string()))
    }));
}

/// Joints are named in documents and counted inside: `joint`, `from` and `joints` of effects and faults.
fn number_joints(value: &mut Value, robot: &Robot, at: &str, problems: &mut Vec<FieldProblem>) {
    let number = |name: &Value| {
        let wanted = name.as_str()?;
        robot.joints().iter().position(|j| j.name == wanted).map(Value::from)
    };
    let Some(fields) = value.as_object_mut() else { return };
    for list in ["effects", "faults"] {
        let Some(entries) = fields.get_mut(list).and_then(Value::as_array_mut) else {
            continue;
        };
        for (i, entry) in entries
            .iter_mut()
            .enumerate()
            .filter_map(|(i, e)| e.as_object_mut().map(|e| (i, e)))
        {
            for field in ["joint", "from", "joints"] {
                let names: Vec<&mut Value> = match entry.get_mut(field) {
                    Some(Value::Array(names)) => names.iter_mut().collect(),
                    Some(name) => vec![name],
                    None => continue,
                };
                for name in names {
                    match number(name) {
                        Some(index) => *name = index,
                        None => problems.push(
                            FieldProblem::new(
                                format!("{at}/{list}/{i}/{field}"),
                                format!("{name} is not the name of a joint"),
                            )
                            .with_hint(format!(
                                "joints are {}",
                                robot.joints().iter().map(|j| j.name.as_str()).collect::<Vec<_>>().join(", ")
                            )),
                        ),
                    }
                }
            }
        }
    }
}

/// `None` when nobody says the parameters.
fn record(request: &Request, robot: &Robot) -> Option<RecordedLog> {
    let n = robot.joint_count();
    let prior = Layout::standard(robot).prior(robot).map(|p| p.as_slice().to_vec());
    let parameters = request.parameters.clone().or(prior)?;
    let silent = Noise::white(vec![0.0; n]);
    let trajectory = trajectory(&request.trajectory, n);
    let experiment = Experiment {
        robot,
        parameters: &parameters,
        trajectory: trajectory.as_ref(),
        periods: request.periods,
        rate_hz: request.sample_rate_hz,
        effects: &request.effects,
        noise: request.noise.as_ref().unwrap_or(&silent),
        seed: request.seed,
    };
    let mut log = simulate(&experiment);
    request.faults.iter().for_each(|fault| corrupt(&mut log, fault, request.seed));
    Some(log)
}

fn trajectory(path: &Path, joints: usize) -> Box<dyn Trajectory> {
    match path {
        Path::Fourier {
            fundamental_hz,
            a,
            b,
            offset,
        } => {
            let matrix = |rows: &[Vec<f64>]| DMatrix::from_fn(joints, rows[0].len(), |r, c| rows[r][c]);
            let offset = offset.clone().unwrap_or_else(|| vec![0.0; joints]);
            Box::new(FourierSeries {
                fundamental_hz: *fundamental_hz,
                a: matrix(a),
                b: matrix(b),
                offset,
            })
        }
        Path::WayPoints { positions, durations } => Box::new(QuinticWayPoints::new(positions.clone(), durations)),
        Path::Sines { terms, duration } => Box::new(SineSeries {
            terms: terms.clone(),
            duration: *duration,
        }),
    }
}

/// Rows in one part of the table.
const ROWS_OF_A_PART: usize = 1024;

/// `time, q1 … qn, tau1 … taun`, part by part.
fn csv(log: &RecordedLog) -> impl Iterator<Item = String> + '_ {
    let names = |prefix: &str| (1..=log.q.len()).map(|j| format!(",{prefix}{j}")).collect::<String>();
    let head = format!("time{}{}\n", names("q"), names("tau"));
    let rows = log.time.len();
    let part = move |first: usize| (first..rows.min(first + ROWS_OF_A_PART)).map(|s| row(log, s)).collect();
    std::iter::once(head).chain((0..rows).step_by(ROWS_OF_A_PART).map(part))
}

fn row(log: &RecordedLog, s: usize) -> String {
    let mut text = shortest(log.time[s]);
    for column in log.q.iter().chain(&log.tau) {
        let _ = write!(text, ",{}", shortest(column[s]));
    }
    text.push('\n');
    text
}
