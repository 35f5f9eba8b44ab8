//! Identify a robot from logs.

use super::provenance::provenance;
use super::report::{document, physical_columns};
use super::series::{Predictors, predictions};
use super::trace::{add_effects, residual};
use super::{CancelFlag, Code, Error};
use crate::dynamics::inverse_dynamics;
use crate::identification::physical::{FeasibleFit, FitObjective, PhysicalFit, fit_feasible};
use crate::identification::{
    Estimate, Log, Observation, PreparedLog, PreprocessOptions, Quality, estimate_from, normal_equations, prepare, quality,
};
use crate::io::log::{Columns, LogError, LogReport, read_joined_log};
use crate::io::{IdentifyDocument, IdentifyRequest, robot_value, urdf};
use crate::model::{LinkPrior, Robot, from_urdf};
use crate::parameters::{BaseParameters, Layout};
use crate::residual::{AugmentedModel, DataFault, RawLog, Stretch, leave_out, lost_rows, sample_faults};
use nalgebra::DVector;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Where an identification stands, for whoever watches.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    pub what: &'static str,
    pub done: usize,
    pub of: usize,
}

/// A log file and the name that the answer calls it by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogFile {
    pub name: String,
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

/// One log on its way: what was found in the file, what became of it, and its rows.
#[derive(Debug, Clone)]
pub struct UsedLog {
    pub report: LogReport,
    pub prepared: PreparedLog,
    pub observation: Observation,
    /// What tracing needs of the record, where it is asked for.
    pub stretch: Option<Stretch>,
    /// Constant, clipped or frozen columns.
    pub sample_faults: Vec<DataFault>,
}

/// A finished identification.
#[derive(Debug, Clone)]
pub struct Identified {
    pub document: IdentifyDocument,
    pub base: BaseParameters,
    pub estimate: Estimate,
    pub physical: Option<FeasibleFit>,
    pub model: Option<ModelFiles>,
    pub identification: Vec<UsedLog>,
    pub validation: Vec<UsedLog>,
    /// The declared model with every effect found, where tracing was asked for.
    pub augmented: Option<AugmentedModel>,
}

/// The identified robot, each form read back and compared with what was identified.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelFiles {
    /// A robot document whose priors are the identified parameters, and the base parameters beside it.
    pub json: Value,
    pub urdf: String,
}

impl Identified {
    /// The model files.
    ///
    /// # Errors
    /// `no_model` when no physical parameters were asked for, or none that are a robot were found.
    pub fn model(&self) -> Result<&ModelFiles, Error> {
        let none = || {
            Error::new(
                Code::NoModel,
                "the identification has no physical parameters that make a robot",
            )
            .with_hint("ask for `feasible`, and see `feasibility` in the result")
        };
        self.model.as_ref().ok_or_else(none)
    }
}

/// Reads the logs, estimates, validates.
///
/// # Errors
/// `invalid_log` with what is wrong with which file; nothing else that the request could have caused.
pub fn identify(
    request: &IdentifyRequest,
    logs: &[LogFile],
    validation: &[LogFile],
    cancel: &CancelFlag,
    observe: &(dyn Fn(&Step) + Sync),
) -> Result<Identified, Error> {
    std::thread::scope(|scope| {
        // Hashing keeps one core busy; beside the rest it costs no time.
        let hashed = scope.spawn(|| provenance(request, logs, validation));
        let mut found = identified(request, logs, validation, cancel, observe)?;
        let origin = hashed.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        found.document.provenance = Some(origin?);
        Ok(found)
    })
}

fn identified(
    request: &IdentifyRequest,
    logs: &[LogFile],
    validation: &[LogFile],
    cancel: &CancelFlag,
    observe: &(dyn Fn(&Step) + Sync),
) -> Result<Identified, Error> {
    if logs.is_empty() {
        return Err(
            Error::new(Code::InvalidLog, "there is no log to identify from").with_hint("send at least one part called `log`")
        );
    }
    let base = BaseParameters::exact(&request.robot);
    let reading = Reading {
        robot: &request.robot,
        base: &base,
        columns: &request.columns,
        preprocess: &request.preprocess,
        offset: request.offset,
        trace: request.trace,
    };
    let ((logs, beside_logs), (validation, beside_validation)) = (
        split_companions(&request.columns, logs)?,
        split_companions(&request.columns, validation)?,
    );
    let total = logs.len() + validation.len() + 3;
    let mut used = Vec::new();
    let files = logs.iter().map(|&f| (f, &beside_logs));
    for (done, (file, beside)) in files.chain(validation.iter().map(|&f| (f, &beside_validation))).enumerate() {
        stop_if_cancelled(cancel)?;
        observe(&Step {
            what: "reading logs",
            done,
            of: total,
        });
        used.push(use_log(&reading, file, beside)?);
    }
    let held_out = used.split_off(logs.len());
    observe(&Step {
        what: "estimating",
        done: total - 3,
        of: total,
    });
    // Rows are the bulk of the memory: they are lent, not copied.
    let observations: Vec<Observation> = used.iter_mut().map(|u| std::mem::take(&mut u.observation)).collect();
    let prepared: Vec<&PreparedLog> = used.iter().map(|u| &u.prepared).collect();
    let normals = normal_equations(&observations);
    let found = estimate_from(&normals, &observations, &prepared, request.estimator);
    let judged = quality(&request.robot, &base, &prepared, &found);
    stop_if_cancelled(cancel)?;
    observe(&Step {
        what: "physical parameters",
        done: total - 2,
        of: total,
    });
    let physical = request.feasible.as_ref().map(|options| {
        let objective = FitObjective::new(&base, &normals, &found);
        fit_feasible(&request.robot, &objective, options, &|| cancel.is_cancelled())
    });
    stop_if_cancelled(cancel)?;
    let model = physical
        .as_ref()
        .map(|fit| model_files(request, &base, &found, fit.model()))
        .transpose()?
        .flatten();
    used.iter_mut().zip(observations).for_each(|(u, rows)| u.observation = rows);
    let mut document = document(request, &base, &found, &judged, physical.as_ref(), &used, &held_out);
    observe(&Step {
        what: "tracing what is left",
        done: total - 1,
        of: total,
    });
    let traced = request.trace.then(|| residual(&request.robot, &used, &held_out, None));
    let (report, traced) = traced.unzip();
    document.residual = report;
    let mut model = model;
    if let (Some(files), Some(traced)) = (&mut model, &traced) {
        add_effects(files, traced);
    }
    if request.prediction_points > 0 {
        let columns = physical.as_ref().map(|fit| physical_columns(&base, fit.model()));
        let by = Predictors {
            base: &found.values,
            physical: columns.as_ref(),
            augmented: traced.as_ref().map(|t| &t.model),
            residual: document.residual.as_ref(),
        };
        document.predictions = predictions(&request.robot, used.iter().chain(&held_out), &by, request.prediction_points);
    }
    Ok(Identified {
        document,
        base,
        estimate: found,
        physical,
        model,
        identification: used,
        validation: held_out,
        augmented: traced.map(|t| t.model),
    })
}

fn stop_if_cancelled(cancel: &CancelFlag) -> Result<(), Error> {
    match cancel.is_cancelled() {
        true => Err(Error::new(
            Code::NoResult,
            "the identification was cancelled before it had a result",
        )),
        false => Ok(()),
    }
}

/// How log files become rows.
pub(super) struct Reading<'a> {
    pub robot: &'a Robot,
    pub base: &'a BaseParameters,
    pub columns: &'a Columns,
    pub preprocess: &'a PreprocessOptions,
    pub offset: bool,
    pub trace: bool,
}

/// Files beside a log: name and path.
pub(super) type Companions = Vec<(String, PathBuf)>;

/// The logs among `files`, and the files that `columns` puts beside one, by name.
pub(super) fn split_companions<'a>(columns: &Columns, files: &'a [LogFile]) -> Result<(Vec<&'a LogFile>, Companions), Error> {
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

/// Reads and prepares one log.
pub(super) fn use_log(reading: &Reading, file: &LogFile, beside: &[(String, PathBuf)]) -> Result<UsedLog, Error> {
    let names: Vec<String> = reading.robot.joints().iter().map(|j| j.name.clone()).collect();
    let invalid = |e: String| Error::new(Code::InvalidLog, e);
    let (mut log, mut report) =
        read_joined_log(&file.path, beside, reading.columns, &names).map_err(|e| invalid(called(e, file, beside).to_string()))?;
    log.name.clone_from(&file.name);
    report.file.clone_from(&file.name);
    let sample_faults = if reading.trace {
        left_out(reading.robot, &mut log)
    } else {
        Vec::new()
    };
    let prepared = prepare(&log, names.len(), reading.preprocess).map_err(|e| invalid(e.to_string()))?;
    let stretch = reading.trace.then(|| Stretch::new(&prepared, &log));
    // The record is done with; rows come next.
    drop(log);
    let mut observation = Observation::new(reading.robot, reading.base, &prepared);
    if reading.offset {
        observation.push_offsets(&prepared);
    }
    Ok(UsedLog {
        report,
        prepared,
        observation,
        stretch,
        sample_faults,
    })
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

/// The robot with the identified parameters as its priors; `None` if they are no bodies.
fn identified_robot(robot: &Robot, fit: &PhysicalFit) -> Option<Robot> {
    let links = fit.links(&Layout::standard(robot))?;
    let joints = robot.joints().iter().zip(links).map(|(joint, link)| {
        // Interior points end within rounding of a bound: friction of −1e-12 is none.
        let prior = LinkPrior {
            inertia: link.inertia,
            viscous: link.viscous.max(0.0),
            coulomb: link.coulomb.max(0.0),
        };
        crate::model::Joint {
            prior: Some(prior),
            ..joint.clone()
        }
    });
    Robot::new(robot.name(), robot.gravity(), joints.collect(), robot.friction()).ok()
}

fn model_files(
    request: &IdentifyRequest,
    base: &BaseParameters,
    found: &Estimate,
    fit: &PhysicalFit,
) -> Result<Option<ModelFiles>, Error> {
    let Some(robot) = identified_robot(&request.robot, fit) else {
        return Ok(None);
    };
    let robot_json = robot_value(&robot);
    let files = ModelFiles {
        json: model_value(&robot_json, base, found, fit),
        urdf: urdf(&robot),
    };
    let internal = |what: &str, e: String| Error::new(Code::Internal, format!("the {what} model does not read back: {e}"));
    let parsed = crate::io::Parsed {
        value: robot_json,
        problems: Vec::new(),
    };
    let from_json = crate::io::robot_document(&parsed)
        .map_err(|e| internal("JSON", format!("{e:?}")))?
        .robot;
    let from_xml = from_urdf(&files.urdf, robot.gravity(), robot.friction(), None)
        .map_err(|e| internal("URDF", e.to_string()))?
        .robot;
    for (what, read) in [("JSON", from_json), ("URDF", from_xml)] {
        let error = torque_difference(&robot, &read);
        if error.is_nan() || error > 1e-9 {
            return Err(internal(what, format!("its torques differ by {error:e} of their size")));
        }
    }
    Ok(Some(files))
}

/// The JSON model: the robot with its parameters, the offsets, and the base parameters as estimated.
fn model_value(robot: &Value, base: &BaseParameters, found: &Estimate, fit: &PhysicalFit) -> Value {
    let standard = base.map.ncols();
    let offsets = (fit.values.len() > standard).then(|| &fit.values[standard..]);
    let one = |c: usize| json!({"name": base.names[c], "value": found.is_determined(c).then_some(found.values[c]), "unit": base.units[c]});
    json!({"robot": robot, "offsets": offsets, "base_parameters": (0..base.len()).map(one).collect::<Vec<_>>()})
}

/// Largest difference of torques between two robots at a few states, relative to the largest torque. Both are the same numbers in
/// other frames, so that only the rounding of angles written as text (1e-16 each) separates them.
fn torque_difference(a: &Robot, b: &Robot) -> f64 {
    if a.joint_count() != b.joint_count() {
        return f64::INFINITY;
    }
    let layout = Layout::standard(a);
    let (Some(phi), Some(psi)) = (layout.prior(a), layout.prior(b)) else {
        return f64::INFINITY;
    };
    let (mut worst, mut largest) = (0.0f64, f64::MIN_POSITIVE);
    for k in 0..10 {
        let state = |phase: f64, size: f64| -> Vec<f64> {
            (0..a.joint_count())
                .map(|j| size * (phase + 1.7 * (k * 7 + j) as f64).sin())
                .collect()
        };
        let (q, qd, qdd) = (state(0.0, 2.0), state(1.0, 1.0), state(2.0, 3.0));
        let one = DVector::from(inverse_dynamics(a, &layout, phi.as_slice(), &q, &qd, &qdd));
        let two = DVector::from(inverse_dynamics(b, &layout, psi.as_slice(), &q, &qd, &qdd));
        worst = worst.max((&one - two).amax());
        largest = largest.max(one.amax());
    }
    worst / largest
}

/// The quality's verdict in words.
pub(super) fn reason(quality: &Quality, base: &BaseParameters, estimate: &Estimate, robot: &Robot) -> String {
    use crate::identification::Verdict;
    match quality.verdict {
        Verdict::Good => {
            "the parameters predict torques elsewhere in the workspace at least as well as on the log's own path".to_string()
        }
        Verdict::Unidentifiable => {
            let names: Vec<&str> = (0..base.len())
                .filter(|&c| !estimate.is_determined(c))
                .map(|c| base.names[c].as_str())
                .collect();
            format!(
                "the log does not determine {}; excite those joints more, or in other combinations",
                names.join(", ")
            )
        }
        Verdict::PoorExcitation => {
            let worst = (0..robot.joint_count()).max_by(|&a, &b| quality.extrapolation[a].total_cmp(&quality.extrapolation[b]));
            let j = worst.unwrap_or(0);
            format!(
                "away from the log's own path the torque of joint {} is uncertain by {:.3} {}, {:.1} times the error on it: record a \
                 richer excitation before using this model",
                robot.joints()[j].name,
                quality.prediction_std[j],
                robot.joints()[j].effort_unit(),
                quality.extrapolation[j]
            )
        }
    }
}
