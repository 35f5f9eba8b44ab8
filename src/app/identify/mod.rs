//! Identify a robot from logs.

mod model;
mod reading;

pub use model::ModelFiles;
pub(super) use reading::{Companions, Reading, split_companions, use_log};
pub use reading::{LogFile, UsedLog};

use self::model::{Found, model_files};
use self::reading::{prepared, raw_log};
use super::diagnose::{beyond_repair, data_faults, mounted, mounting_fault, report_faults};
use super::own_effects::has_values;
use super::provenance::provenance;
use super::report::{Answer, declared_effects, effects};
use super::series::{Predictors, drawn, predictions};
use super::tell::residual_document;
use super::{CancelFlag, Code, Error};
use crate::cancel::Cancelled;
use crate::diagnosis::{DataFault, Diagnosis, DiagnosisOptions, Estimates, FaultKind, Remedy, diagnose, diagnose_mounted};
use crate::documents::{IdentifyDocument, IdentifyRequest, PredictionDocument};
use crate::formats::significant;
use crate::identification::physical::{FeasibleFit, FitObjective, fit_feasible};
use crate::identification::{Quality, QualityVerdict, quality};
use crate::model::Robot;
use crate::parameters::{BaseParameters, Layout};
use crate::preparation::{PreparedLog, PreprocessOptions, signal_cutoff};
use crate::regression::{AugmentedModel, Estimate, Fitted, Stretch};

/// Where an identification stands, for whoever watches.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// Name of the step, in words.
    pub what: &'static str,
    /// Parts of the step that are done.
    pub done: usize,
    /// Parts of the step in all.
    pub of: usize,
}

/// A finished identification.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The answer that clients get.
    pub document: IdentifyDocument,
    /// The model that was found: base parameters and effects, one estimate.
    pub found: Fitted,
    /// The declared model by the same rows and weights.
    pub declared: Fitted,
    /// Physical parameters; nothing if they were not asked for or not found.
    pub physical: Option<FeasibleFit>,
    /// The model in the formats that it is exported to; nothing without a usable model.
    pub model: Option<ModelFiles>,
    /// The model that was found with bodies in the place of its base parameters.
    pub bodies: Option<AugmentedModel>,
    /// Logs to identify from, then those to validate with.
    read: ReadLogs,
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

    /// Measured and predicted torques over time, as many points of every joint as the request asks for. They are no part of
    /// [`identify`]: what was identified can be stored before anything is made for pictures.
    ///
    /// # Errors
    /// `drawing_failed`: the result is as good without them.
    pub fn predictions(&self, request: &IdentifyRequest) -> Result<Vec<PredictionDocument>, Error> {
        let by = Predictors {
            base: &self.found.model,
            physical: self.bodies.as_ref(),
            declared: request.trace.then_some(&self.declared.model),
        };
        drawn("the predictions", || {
            predictions(&request.robot, &self.read, &by, request.prediction_points)
        })
    }
}

/// Reads the logs, estimates, validates. The document has no predictions yet: see [`Identified::predictions`].
///
/// # Errors
/// `invalid_log` with what is wrong with which file; `no_result` where `cancel` was set meanwhile; nothing else that the request
/// could have caused.
pub fn identify(
    request: &IdentifyRequest,
    logs: &[LogFile],
    validation: &[LogFile],
    cancel: &CancelFlag,
    observe: &(dyn Fn(&Step) + Sync),
) -> Result<Identified, Error> {
    std::thread::scope(|scope| {
        // Hashing keeps one core busy; beside the rest it costs no time.
        let hashed = scope.spawn(|| provenance(request, logs, validation, cancel));
        let mut found = stoppable("identification", || identified(request, logs, validation, cancel, observe))?;
        let origin = hashed.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        found.document.provenance = Some(origin?);
        Ok(found)
    })
}

/// Prepare, estimate, diagnose, estimate again with what was found, fit bodies, and measure the errors of the result.
fn identified(
    request: &IdentifyRequest,
    logs: &[LogFile],
    validation: &[LogFile],
    cancel: &CancelFlag,
    observe: &(dyn Fn(&Step) + Sync),
) -> Result<Identified, Error> {
    let progress = Progress {
        cancel,
        observe,
        of: logs.len() + validation.len() + 2,
    };
    let (mut read, beside) = read_logs(request, logs, validation, &progress)?;
    for own in &request.effects {
        has_values(&request.robot, own, &own.grid(), &read.stretches)?;
    }
    let Declared { robot, moved, faults } = Declared::by_data(request, &read.used[..beside], cancel);
    read.turn(&robot, &faults);
    progress.at("estimating and diagnosing", logs.len() + validation.len())?;
    let (measured, held_out) = read.stretches.split_at(beside);
    let options = DiagnosisOptions {
        search: request.trace && !beyond_repair(&faults),
        offsets: request.offset,
        own: request.effects.clone(),
        estimator: request.estimator,
        cancel: cancel.clone(),
        ..DiagnosisOptions::default()
    };
    let mounting = moved.then_some(&request.robot);
    let diagnosis = diagnosed(&robot, mounting, [measured, held_out], &faults, &options);
    // Gravity is where the data have it.
    let robot = diagnosis.model.robot.clone();
    let Estimates { found, declared } = diagnosis.estimates.clone().expect("there is no existing model");
    let prepared: Vec<&PreparedLog> = read.used[..beside].iter().map(|u| &u.prepared).collect();
    let mut judged = quality(&robot, &found.base, &prepared, &found.estimate, diagnosis.explained.clone());
    if beyond_repair(&diagnosis.report.data_faults) {
        judged.verdict = QualityVerdict::DataFault;
    }
    progress.at("physical parameters", logs.len() + validation.len() + 1)?;
    let physical = request.feasible.as_ref().map(|options| {
        let objective = FitObjective::new(&found.base, &found.normals, &found.estimate.values);
        fit_feasible(&robot, &objective, options, &|| cancel.is_cancelled())
    });
    progress.stop_if_cancelled()?;
    let bodies = physical.as_ref().map(|fit| with_bodies(&found.model, &fit.model().values));
    let files = |(fit, bodies): (&FeasibleFit, &AugmentedModel)| {
        model_files(&Found {
            request,
            robot: &robot,
            fitted: &found,
            fit: fit.model(),
            bodies,
            diagnosis: &diagnosis,
            logs: measured,
            band_hz: read.band_hz(),
        })
    };
    let model = physical.as_ref().zip(bodies.as_ref()).map(files).transpose()?.flatten();
    let answer = Answer {
        request,
        robot: &robot,
        found: &found,
        declared: &declared,
        judged: &judged,
        feasible: physical.as_ref(),
        bodies: bodies.as_ref(),
        read: &read,
        identification: beside,
    };
    let mut document = answer.document();
    document.effects = declared_effects(&found);
    if request.trace {
        document.effects.extend(effects(&diagnosis.report));
        document.residual = Some(residual_document(&robot, &diagnosis.report));
    }
    Ok(Identified {
        document,
        found,
        declared,
        physical,
        model,
        bodies,
        read,
    })
}

/// The robot as declared, with gravity where the data have it, and what is wrong with the data.
struct Declared {
    robot: Robot,
    /// Whether gravity was moved.
    moved: bool,
    faults: Vec<DataFault>,
}

impl Declared {
    /// Without a diagnosis everything is as it was declared.
    fn by_data(request: &IdentifyRequest, logs: &[UsedLog], cancel: &CancelFlag) -> Self {
        let mut mounted = request.trace.then(|| mounted(&request.robot, logs, cancel)).flatten();
        let mut robot = mounted.map_or_else(|| request.robot.clone(), |m| request.robot.with_gravity(m.gravity));
        let mut faults = match request.trace {
            true => data_faults(&robot, logs, cancel),
            false => Vec::new(),
        };
        // Gravity turned round with all torques turned round is what was declared: the data decide for neither.
        let all_turned = |f: &DataFault| f.fault == FaultKind::TorqueSign && f.joints.len() == robot.joint_count();
        if mounted.is_some() && faults.iter().any(all_turned) {
            (mounted, robot) = (None, request.robot.clone());
            faults = data_faults(&robot, logs, cancel);
        }
        Self {
            moved: mounted.is_some(),
            robot,
            faults,
        }
    }
}

/// Searches for effects, unless the options say not to; estimates in any case. `declared` is the robot as declared, where the
/// data have gravity elsewhere.
fn diagnosed(
    robot: &Robot,
    declared: Option<&Robot>,
    [measured, held_out]: [&[Stretch]; 2],
    faults: &[DataFault],
    options: &DiagnosisOptions,
) -> Diagnosis {
    let (mut diagnosis, mounting) = match declared {
        None => (diagnose(robot, measured, held_out, options), None),
        Some(declared) => {
            let (diagnosis, gravity) = diagnose_mounted(robot, measured, held_out, options);
            (diagnosis, Some(mounting_fault(declared, &gravity)))
        }
    };
    report_faults(
        &mut diagnosis.report,
        mounting.into_iter().chain(faults.iter().cloned()).collect(),
    );
    diagnosis
}

/// The model with base parameters of bodies (standard parameters `values`), and its effects as they are.
fn with_bodies(model: &AugmentedModel, values: &[f64]) -> AugmentedModel {
    AugmentedModel {
        values: model.base.project(&values[..model.base.map.ncols()]),
        ..model.clone()
    }
}

/// Who watches, and who may stop it.
struct Progress<'a> {
    cancel: &'a CancelFlag,
    observe: &'a (dyn Fn(&Step) + Sync),
    of: usize,
}

impl Progress<'_> {
    fn at(&self, what: &'static str, done: usize) -> Result<(), Error> {
        self.stop_if_cancelled()?;
        (self.observe)(&Step { what, done, of: self.of });
        Ok(())
    }

    fn stop_if_cancelled(&self) -> Result<(), Error> {
        match self.cancel.is_cancelled() {
            true => Err(cancelled("identification")),
            false => Ok(()),
        }
    }
}

/// The result of `work`, which its loops may leave when it is cancelled.
pub(super) fn stoppable<T>(what: &str, work: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    CancelFlag::run(work).unwrap_or_else(|Cancelled| Err(cancelled(what)))
}

pub(super) fn cancelled(what: &str) -> Error {
    Error::new(Code::NoResult, format!("the {what} was cancelled before it had a result"))
}

/// Logs as they were read, and their rows.
#[derive(Debug, Clone, Default)]
pub(in super::super) struct ReadLogs {
    pub used: Vec<UsedLog>,
    pub stretches: Vec<Stretch>,
    /// Per joint: −1 where the torque was turned.
    pub signs: Vec<f64>,
}

impl ReadLogs {
    fn push(&mut self, (used, stretch): (UsedLog, Stretch)) {
        self.used.push(used);
        self.stretches.push(stretch);
    }

    /// Band of the logs that do not repeat [Hz]: the lowest of them.
    fn band_hz(&self) -> Option<f64> {
        let bands = self.used.iter().filter_map(|u| u.prepared.band_hz());
        bands.min_by(f64::total_cmp)
    }

    /// Turns the torques whose sign is inverted, in all logs.
    pub(in super::super) fn turn(&mut self, robot: &Robot, faults: &[DataFault]) {
        let turned = |name: &String| faults.iter().any(|f| f.remedy == Remedy::Turn && f.joints.contains(name));
        let sign = |j: &crate::model::Joint| if turned(&j.name) { -1.0 } else { 1.0 };
        self.signs = robot.joints().iter().map(sign).collect();
        for (joint, _) in self.signs.iter().enumerate().filter(|(_, s)| **s < 0.0) {
            self.stretches.iter_mut().for_each(|s| s.turn(joint));
        }
    }
}

/// All logs, and how many of them are to identify from.
fn read_logs(
    request: &IdentifyRequest,
    logs: &[LogFile],
    validation: &[LogFile],
    progress: &Progress,
) -> Result<(ReadLogs, usize), Error> {
    if logs.is_empty() {
        return Err(
            Error::new(Code::InvalidLog, "there is no log to identify from").with_hint("send at least one part called `log`")
        );
    }
    let reading = Reading {
        robot: &request.robot,
        columns: &request.columns,
        preprocess: &request.preprocess,
        trace: request.trace,
        cancel: progress.cancel,
    };
    let ((logs, beside_logs), (validation, beside_validation)) = (
        split_companions(&request.columns, logs)?,
        split_companions(&request.columns, validation)?,
    );
    let mut read = ReadLogs::default();
    let mut raws = Vec::new();
    for (done, file) in logs.iter().enumerate() {
        progress.at("reading logs", done)?;
        raws.push(raw_log(&reading, file, &beside_logs)?);
    }
    // Errors of two logs compare where they are of one band.
    let one_band = PreprocessOptions {
        band_hz: (raws.len() > 1).then(|| {
            raws.iter()
                .map(|r| signal_cutoff(&r.log, progress.cancel))
                .fold(f64::INFINITY, f64::min)
        }),
        ..request.preprocess.clone()
    };
    let reading = Reading {
        preprocess: &one_band,
        ..reading
    };
    for raw in raws {
        read.push(prepared(&reading, raw)?);
    }
    // Validation logs may be of another trajectory: their period is their own.
    let expected = PreprocessOptions {
        band_hz: read.band_hz(),
        ..request.preprocess.for_other_log()
    };
    let reading = Reading {
        preprocess: &expected,
        ..reading
    };
    for (done, file) in validation.iter().enumerate() {
        progress.at("reading logs", logs.len() + done)?;
        read.push(use_log(&reading, file, &beside_validation)?);
    }
    Ok((read, logs.len()))
}

/// The quality's verdict in words.
pub(super) fn reason(quality: &Quality, base: &BaseParameters, estimate: &Estimate, robot: &Robot) -> String {
    match quality.verdict {
        QualityVerdict::Good => {
            "the parameters predict torques elsewhere in the workspace at least as well as on the recorded motion".to_string()
        }
        QualityVerdict::ExplainsNothing => {
            "the model explains nothing here: on data that it was not fitted to it predicts the torques no better than a constant per joint; check that the \
             torque columns belong to these positions"
                .to_string()
        }
        QualityVerdict::DataFault => "the data have a fault that could not be put right, named in `residual.data_faults`: the parameters are those of wrong data; correct \
                               the data and identify again"
            .to_string(),
        QualityVerdict::Unidentifiable => {
            let layout = Layout::standard(robot);
            let open: Vec<usize> = (0..base.len()).filter(|&c| !estimate.is_determined(c)).collect();
            let names: Vec<&str> = open.iter().map(|&c| base.names[c].as_str()).collect();
            let mut joints: Vec<&str> = open
                .iter()
                .map(|&c| robot.joints()[layout.parameters()[base.kept[c]].link].name.as_str())
                .collect();
            joints.dedup();
            format!(
                "the log does not determine {}, parameters of what {} moves: record a motion that moves {} and the joints before further and faster, or in other \
                 combinations",
                names.join(", "),
                joints.join(", "),
                if joints.len() == 1 { "it" } else { "them" }
            )
        }
        QualityVerdict::PoorExcitation => {
            let poor: Vec<usize> = quality.poor_joints().into_iter().filter(|&j| estimate.joints[j].rows > 0).collect();
            let name = |j: &usize| robot.joints()[*j].name.as_str();
            let worst = poor.first().copied().unwrap_or(0);
            let others: Vec<&str> = poor.iter().skip(1).map(name).collect();
            format!(
                "away from the recorded motion, the predicted torque of joint {} is uncertain by {} {}, {} times its RMS error in the log{}: record a richer \
                 excitation, with all joints over more of their range and at several speeds, before using this model",
                name(&worst),
                significant(quality.prediction_std[worst], 3),
                robot.joints()[worst].effort_unit(),
                significant(quality.extrapolation[worst], 2),
                if others.is_empty() {
                    String::new()
                } else {
                    format!(" (that of {} is uncertain too)", others.join(", "))
                }
            )
        }
    }
}
