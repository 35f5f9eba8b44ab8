//! Measured and predicted torques over time, for plots.

use super::identify::{ReadLogs, UsedLog};
use super::{Code, Error};
use crate::documents::PredictionDocument;
use crate::model::Robot;
use crate::preparation::keep_peaks;
use crate::regression::{AugmentedModel, Stretch};
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
    /// The model as estimated.
    pub base: &'a AugmentedModel,
    /// With bodies in the place of its base parameters.
    pub physical: Option<&'a AugmentedModel>,
    /// Without the effects found.
    pub declared: Option<&'a AugmentedModel>,
}

/// One series per log and joint, torques as recorded; none where no points are asked for.
pub(super) fn predictions(robot: &Robot, read: &ReadLogs, by: &Predictors, most: usize) -> Vec<PredictionDocument> {
    if most == 0 {
        return Vec::new();
    }
    let logs = read.used.iter().zip(&read.stretches);
    logs.flat_map(|(used, stretch)| of_log(robot, used, stretch, &read.signs, by, most))
        .collect()
}

fn of_log(
    robot: &Robot,
    used: &UsedLog,
    stretch: &Stretch,
    signs: &[f64],
    by: &Predictors,
    most: usize,
) -> Vec<PredictionDocument> {
    let base = by.base.predict(stretch);
    let [physical, declared] = [by.physical, by.declared].map(|m| m.map(|m| m.predict(stretch)));
    let of = |j: usize| {
        let rows: Vec<usize> = (0..stretch.rows()).filter(|&r| stretch.usable[j][r]).collect();
        let residual: Vec<f64> = rows.iter().map(|&r| stretch.torque[j][r] - base[j][r]).collect();
        let measured: Vec<f64> = rows.iter().map(|&r| stretch.torque[j][r]).collect();
        let picked: Vec<usize> = keep_peaks(&[&measured, &residual], most)
            .into_iter()
            .map(|i| rows[i])
            .collect();
        let torque = |all: &[Vec<f64>]| picked.iter().map(|&r| signs[j] * all[j][r]).collect::<Vec<f64>>();
        let state = |k: usize| picked.iter().map(|&r| stretch.motion.get(j, stretch.samples[r])[k]).collect();
        PredictionDocument {
            log: used.report.file.clone(),
            joint: robot.joints()[j].name.clone(),
            time: picked.iter().map(|&r| used.prepared.time(stretch.samples[r])).collect(),
            q: state(0),
            qd: state(1),
            qdd: state(2),
            measured: torque(&stretch.torque),
            base: torque(&base),
            physical: physical.as_ref().map(|t| torque(t)),
            declared: declared.as_ref().map(|t| torque(t)),
        }
    };
    (0..stretch.joints()).map(of).collect()
}
