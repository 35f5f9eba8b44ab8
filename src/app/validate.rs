//! Hold a model against logs.

use super::identify::{LogFile, Reading, UsedLog, split_companions, use_log};
use super::report::errors;
use super::series::{Predictors, drawn, predictions};
use super::trace::residual;
use super::{CancelFlag, Code, Error};
use crate::identification::validate as prediction_errors;
use crate::io::{LogDocument, PredictionDocument, ValidateDocument, ValidateRequest, ValidatedLog};
use crate::parameters::{BaseParameters, Layout};
use nalgebra::DVector;

/// A finished validation.
#[derive(Debug, Clone)]
pub struct Validated {
    pub document: ValidateDocument,
    pub logs: Vec<UsedLog>,
    /// The model's columns: base parameters, then offsets.
    values: DVector<f64>,
}

impl Validated {
    /// Measured and predicted torques over time, as many points of every joint as the request asks for; no part of [`validate`], so that the
    /// errors can be stored before anything is made for pictures.
    ///
    /// # Errors
    /// `drawing_failed`: the result is as good without them.
    pub fn predictions(&self, request: &ValidateRequest) -> Result<Vec<PredictionDocument>, Error> {
        let by = Predictors {
            base: &self.values,
            physical: None,
            augmented: None,
            residual: None,
        };
        drawn("the predictions", || {
            predictions(&request.robot, self.logs.iter(), &by, request.prediction_points)
        })
    }
}

/// Predicts every log with the model. The document has no predictions yet: see [`Validated::predictions`].
///
/// # Errors
/// `invalid_log` with what is wrong with which file.
pub fn validate(request: &ValidateRequest, logs: &[LogFile], cancel: &CancelFlag) -> Result<Validated, Error> {
    if logs.is_empty() {
        return Err(
            Error::new(Code::InvalidLog, "there is no log to validate with").with_hint("send at least one part called `log`")
        );
    }
    let robot = &request.robot;
    let base = BaseParameters::exact(robot);
    let prior = Layout::standard(robot).prior(robot);
    let prior = prior.ok_or_else(|| Error::new(Code::NoModel, "a link of the model has no mass and inertia"))?;
    let offsets = request.offsets.clone().unwrap_or_default();
    let projected = base.project(prior.as_slice());
    let values = DVector::from_iterator(
        base.len() + offsets.len(),
        projected.iter().copied().chain(offsets.iter().copied()),
    );
    let reading = Reading {
        robot,
        base: &base,
        columns: &request.columns,
        preprocess: &request.preprocess,
        offset: !offsets.is_empty(),
        trace: request.existing.is_some(),
    };
    let mut document = ValidateDocument {
        robot: robot.name().to_string(),
        joints: robot.joints().iter().map(|j| j.name.clone()).collect(),
        logs: Vec::new(),
        log_report: Vec::new(),
        predictions: Vec::new(),
        predictions_error: None,
        residual: None,
    };
    let (logs, beside) = split_companions(&request.columns, logs)?;
    let mut used = Vec::new();
    for file in logs {
        if cancel.is_cancelled() {
            return Err(Error::new(
                Code::NoResult,
                "the validation was cancelled before it had a result",
            ));
        }
        let log = use_log(&reading, file, &beside)?;
        let name = log.report.file.clone();
        document.logs.push(ValidatedLog {
            name: name.clone(),
            errors: errors(prediction_errors(&log.observation, &values)),
        });
        document
            .log_report
            .push(LogDocument::new(&log.report, "validation", &log.prepared.choices));
        used.push(log);
    }
    let existing = request.existing.clone();
    document.residual = existing.map(|model| residual(robot, &used, &[], Some(model), false).0);
    Ok(Validated {
        document,
        logs: used,
        values,
    })
}
