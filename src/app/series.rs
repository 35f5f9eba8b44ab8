//! Measured and predicted torques over time, for plots.

use super::identify::UsedLog;
use super::{Code, Error};
use crate::identification::predictions as predict;
use crate::io::PredictionDocument;
use crate::model::Robot;
use crate::residual::{AugmentedModel, Stretch};
use nalgebra::DVector;
use serde_json::Value;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What is made for pictures, after the result: if it cannot be made, `what` says so, and the result is as good without it.
///
/// # Errors
/// `drawing_failed`
pub fn drawn<T>(what: &str, make: impl FnOnce() -> T) -> Result<T, Error> {
    let failed = |_| {
        Error::new(Code::DrawingFailed, format!("{what} cannot be made"))
            .with_hint("the result is complete without; please report this")
    };
    catch_unwind(AssertUnwindSafe(make)).map_err(failed)
}

/// What predicts.
pub(super) struct Predictors<'a> {
    pub base: &'a DVector<f64>,
    pub physical: Option<&'a DVector<f64>>,
    pub augmented: Option<&'a AugmentedModel>,
    /// The `residual` part of the answer: torques that it calls inverted were turned before the augmented model saw them.
    pub residual: Option<&'a Value>,
}

/// One series per log and joint; none where no points are asked for.
pub(super) fn predictions<'a>(
    robot: &Robot,
    logs: impl Iterator<Item = &'a UsedLog>,
    by: &Predictors,
    most: usize,
) -> Vec<PredictionDocument> {
    if most == 0 {
        return Vec::new();
    }
    logs.flat_map(|log| of_log(robot, log, by, most)).collect()
}

fn of_log(robot: &Robot, log: &UsedLog, by: &Predictors, most: usize) -> Vec<PredictionDocument> {
    let augmented = by.augmented.zip(log.stretch.as_ref()).map(|(model, traced)| {
        // Rows of tracing are means over several samples where a period has many; these are the rows that least squares has.
        let motion = Stretch::of_motion(traced.motion.clone(), traced.interval, traced.periodic);
        let samples = model.predict(&motion).into_iter();
        samples
            .map(|torque| log.prepared.row_filter.column_rows(&torque))
            .collect::<Vec<_>>()
    });
    let sets: Vec<&DVector<f64>> = std::iter::once(by.base).chain(by.physical).collect();
    predict(&log.observation, &sets, most)
        .into_iter()
        .enumerate()
        .map(|(j, series)| {
            let joint = &robot.joints()[j].name;
            let sign = if is_inverted(by.residual, joint) { -1.0 } else { 1.0 };
            let state = |k: usize| series.samples.iter().map(|&s| log.prepared.motion.get(j, s)[k]).collect();
            let mut predicted = series.predicted.into_iter();
            PredictionDocument {
                log: log.report.file.clone(),
                joint: joint.clone(),
                time: series.samples.iter().map(|&s| log.prepared.time(s)).collect(),
                q: state(0),
                qd: state(1),
                qdd: state(2),
                measured: series.measured,
                base: predicted.next().unwrap_or_default(),
                physical: predicted.next(),
                augmented: augmented
                    .as_ref()
                    .map(|t| series.rows.iter().map(|&r| sign * t[j][r]).collect()),
            }
        })
        .collect()
}

fn is_inverted(residual: Option<&Value>, joint: &str) -> bool {
    let faults = residual.and_then(|r| r["data_faults"].as_array()).into_iter().flatten();
    faults
        .filter(|f| f["fault"] == "torque_sign")
        .any(|f| f["joints"].as_array().is_some_and(|joints| joints.iter().any(|j| j == joint)))
}
