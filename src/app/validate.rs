//! Hold a model against logs.

use super::diagnose::{beyond_repair, data_faults, report_faults};
use super::identify::{LogFile, ReadLogs, Reading, split_companions, stoppable, use_log};
use super::own_effects::has_values;
use super::report::errors;
use super::series::{Predictors, drawn, predictions};
use super::tell::residual_document;
use super::{CancelFlag, Code, Error};
use crate::diagnosis::{DataFault, DiagnosisOptions, diagnose};
use crate::documents::{
    LogDocument, ModelEffect, PredictionDocument, ResidualDocument, ValidateDocument, ValidateRequest, ValidatedLog,
};
use crate::parameters::Layout;
use crate::regression::{AugmentedModel, Prior};

/// A finished validation.
#[derive(Debug, Clone)]
pub struct Validated {
    /// The answer that clients get.
    pub document: ValidateDocument,
    /// The bodies of the model, and its effects.
    bodies: AugmentedModel,
    read: ReadLogs,
}

impl Validated {
    /// Measured and predicted torques over time, as many points of every joint as the request asks for; no part of [`validate`],
    /// so that the errors can be stored before anything is made for pictures.
    ///
    /// # Errors
    /// `drawing_failed`: the result is as good without them.
    pub fn predictions(&self, request: &ValidateRequest) -> Result<Vec<PredictionDocument>, Error> {
        let by = Predictors {
            base: &self.bodies,
            physical: None,
            declared: None,
        };
        drawn("the predictions", || {
            predictions(&request.robot, &self.read, &by, request.prediction_points)
        })
    }
}

/// Predicts every log with the model, its effects included. The document has no predictions yet: see [`Validated::predictions`].
///
/// # Errors
/// `invalid_log` with what is wrong with which file; `no_result` where `cancel` was set meanwhile.
pub fn validate(request: &ValidateRequest, logs: &[LogFile], cancel: &CancelFlag) -> Result<Validated, Error> {
    stoppable("validation", || validated(request, logs, cancel))
}

fn validated(request: &ValidateRequest, logs: &[LogFile], cancel: &CancelFlag) -> Result<Validated, Error> {
    let robot = &request.robot;
    let bodies = bodies(request)?;
    let tracing = request.augmented.as_ref().filter(|_| request.trace);
    let mut read = read_logs(request, logs, tracing.is_some(), cancel)?;
    let faults = match tracing {
        Some(_) => data_faults(robot, &read.used, cancel),
        None => Vec::new(),
    };
    read.turn(robot, &faults);
    for term in &bodies.terms {
        if let Some(own) = term.effect.own() {
            has_values(robot, own, std::slice::from_ref(&term.shape), &read.stretches)?;
        }
    }
    let base = request.augmented.as_ref().map(|(model, _)| model);
    let of_log = |(log, stretch): (&super::UsedLog, &crate::regression::Stretch)| ValidatedLog {
        name: log.report.file.clone(),
        errors: errors(bodies.errors(stretch)),
        base: base.map(|model| errors(model.errors(stretch))),
    };
    let document = ValidateDocument {
        robot: robot.name().to_string(),
        joints: robot.joints().iter().map(|j| j.name.clone()).collect(),
        effects: effects(&bodies),
        logs: read.used.iter().zip(&read.stretches).map(of_log).collect(),
        log_report: read
            .used
            .iter()
            .map(|log| LogDocument::new(&log.report, "validation", &log.prepared.choices))
            .collect(),
        predictions: Vec::new(),
        predictions_error: None,
        residual: tracing.map(|existing| changes(request, &read, existing, faults, cancel)),
        notes: request.notes.clone(),
    };
    Ok(Validated { document, bodies, read })
}

/// The bodies of the model, and its effects.
fn bodies(request: &ValidateRequest) -> Result<AugmentedModel, Error> {
    let robot = &request.robot;
    let prior = Layout::standard(robot).prior(robot);
    let prior = prior.ok_or_else(|| Error::new(Code::NoModel, "a link of the model has no mass and inertia"))?;
    let model = match &request.augmented {
        Some((model, _)) => model.clone(),
        None => AugmentedModel::declared(robot).with_offsets(request.offsets.as_deref().unwrap_or_default()),
    };
    Ok(AugmentedModel {
        values: model.base.project(prior.as_slice()),
        ..model
    })
}

fn effects(model: &AugmentedModel) -> Vec<ModelEffect> {
    let joint = |&j: &usize| model.robot.joints()[j].name.clone();
    let terms = model.terms.iter();
    terms
        .map(|term| ModelEffect {
            effect: term.effect.code().into(),
            joints: term.acts_on().iter().map(joint).collect(),
        })
        .collect()
}

fn read_logs(request: &ValidateRequest, logs: &[LogFile], trace: bool, cancel: &CancelFlag) -> Result<ReadLogs, Error> {
    if logs.is_empty() {
        return Err(
            Error::new(Code::InvalidLog, "there is no log to validate with").with_hint("send at least one part called `log`")
        );
    }
    let expected = request.preprocess.for_other_log();
    let reading = Reading {
        robot: &request.robot,
        columns: &request.columns,
        preprocess: &expected,
        trace,
        cancel,
    };
    let (logs, beside) = split_companions(&request.columns, logs)?;
    let mut read = ReadLogs::default();
    for file in logs {
        let (used, stretch) = use_log(&reading, file, &beside)?;
        read.used.push(used);
        read.stretches.push(stretch);
    }
    Ok(read)
}

/// What has changed since the model was made.
fn changes(
    request: &ValidateRequest,
    read: &ReadLogs,
    existing: &(AugmentedModel, Prior),
    faults: Vec<DataFault>,
    cancel: &CancelFlag,
) -> ResidualDocument {
    let options = DiagnosisOptions {
        existing: Some(existing.clone()),
        search: !beyond_repair(&faults),
        cancel: cancel.clone(),
        ..DiagnosisOptions::default()
    };
    let mut report = diagnose(&request.robot, &read.stretches, &[], &options).report;
    report_faults(&mut report, faults);
    residual_document(&request.robot, &report)
}
