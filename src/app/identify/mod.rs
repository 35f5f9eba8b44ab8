//! Identify a robot from logs.

mod model;
mod reading;

pub use model::ModelFiles;
pub use reading::{LogFile, UsedLog};
pub(super) use reading::{Reading, split_companions, use_log};

use self::model::model_files;
use super::provenance::provenance;
use super::report::{document, physical_columns};
use super::series::{Predictors, drawn, predictions};
use super::trace::{add_effects, residual};
use super::{CancelFlag, Code, Error};
use crate::identification::physical::{FeasibleFit, FitObjective, fit_feasible};
use crate::identification::{Estimate, Observation, PreparedLog, Quality, estimate_from, normal_equations, quality};
use crate::io::{IdentifyDocument, IdentifyRequest, PredictionDocument};
use crate::model::Robot;
use crate::parameters::BaseParameters;
use crate::residual::AugmentedModel;

/// Where an identification stands, for whoever watches.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    pub what: &'static str,
    pub done: usize,
    pub of: usize,
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

    /// Measured and predicted torques over time, as many points of every joint as the request asks for. They are no part of [`identify`]: what was
    /// identified can be stored before anything is made for pictures.
    ///
    /// # Errors
    /// `drawing_failed`: the result is as good without them.
    pub fn predictions(&self, request: &IdentifyRequest) -> Result<Vec<PredictionDocument>, Error> {
        let columns = self.physical.as_ref().map(|fit| physical_columns(&self.base, fit.model()));
        let by = Predictors {
            base: &self.estimate.values,
            physical: columns.as_ref(),
            augmented: self.augmented.as_ref(),
            residual: self.document.residual.as_ref(),
        };
        let logs = || self.identification.iter().chain(&self.validation);
        drawn("the predictions", || {
            predictions(&request.robot, logs(), &by, request.prediction_points)
        })
    }
}

/// Reads the logs, estimates, validates. The document has no predictions yet: see [`Identified::predictions`].
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
    let traced = request
        .trace
        .then(|| residual(&request.robot, &used, &held_out, None, request.offset));
    let (report, traced) = traced.unzip();
    document.residual = report;
    let mut model = model;
    if let (Some(files), Some(traced)) = (&mut model, &traced) {
        add_effects(files, traced);
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
