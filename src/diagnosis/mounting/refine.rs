//! The direction of gravity by all samples, weighed by their noise.

use crate::cancel::CancelFlag;
use crate::diagnosis::options::DiagnosisOptions;
use crate::diagnosis::outcome::Diagnosis;
use crate::diagnosis::pipeline::diagnose;
use crate::diagnosis::selection::{candidates, honest_covariance};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::tilted;
use crate::model::Robot;
use crate::regression::{AugmentedModel, Data, Stretch, Term, floor, spans};
use nalgebra::{DMatrix, DVector, Vector3};

/// Gravity in the base frame with the standard deviation of every component [m/s²].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    /// Acceleration of gravity in the base frame [m/s²].
    pub value: Vector3<f64>,
    /// Of what the arm shows.
    pub std_dev: Vector3<f64>,
    /// Whether the arm shows all of the direction; what it does not show is as declared.
    pub is_all_seen: bool,
}

/// The tracing with gravity where all samples have it, starting from where `robot` has it. Effects that were found may have
/// turned it by a little: then that is a part of the direction, and not a base out of level.
pub fn diagnose_mounted(
    robot: &Robot,
    measured: &[Stretch],
    held_out: &[Stretch],
    options: &DiagnosisOptions,
) -> (Diagnosis, Gravity) {
    let mut gravity = refined(robot, measured, &options.cancel);
    let first = diagnose(&robot.with_gravity(gravity.value), measured, held_out, options);
    let tilt = first.model.terms.iter().find(|t| t.effect.code() == "base_tilt");
    let Some(tilt) = tilt else { return (first, gravity) };
    gravity.value = tilted(first.model.robot.gravity(), &tilt.shape);
    let again = diagnose(&robot.with_gravity(gravity.value), measured, held_out, options);
    (again, gravity)
}

/// Gravity with a tilt of the base beside all base parameters, from the direction that `robot` has.
fn refined(robot: &Robot, stretches: &[Stretch], cancel: &CancelFlag) -> Gravity {
    let start = AugmentedModel::declared(robot);
    let coarse: Vec<Stretch> = stretches.iter().map(Stretch::as_coarse).collect();
    let mut data = Data::new(&coarse, Vec::new(), None).until(cancel);
    data.noise = floor(robot, &data, &start);
    let list = candidates(&start, &spans(stretches), false);
    let mut model = start;
    let tilt = list.iter().find(|c| c.effect.code() == "base_tilt");
    model
        .terms
        .extend(tilt.map(|c| c.term(&vec![0.0; c.effect.steps().len()], &[])));
    let system = data.fit(model);
    match system.model.terms.last() {
        Some(term) => turned(robot, term, &honest_covariance(&system, 0)),
        None => Gravity {
            value: robot.gravity(),
            std_dev: Vector3::zeros(),
            is_all_seen: false,
        },
    }
}

/// Gravity of `robot` with the tilt `term`, whose parameters have this covariance.
fn turned(robot: &Robot, term: &Term, covariance: &DMatrix<f64>) -> Gravity {
    let (shape, covariance) = seen(term, covariance);
    let value = tilted(robot.gravity(), &shape);
    // A hundred thousandth of a radian: turns are linear over that.
    let step = 1e-5;
    let column = |i: usize| {
        let mut there = shape.clone();
        there[i] += step;
        (tilted(robot.gravity(), &there) - value) / step
    };
    let slope = DMatrix::from_fn(3, shape.len(), |r, c| column(c)[r]);
    let spread = &slope * &covariance.0 * slope.transpose();
    Gravity {
        value,
        std_dev: Vector3::from_fn(|i, _| spread[(i, i)].max(0.0).sqrt()),
        is_all_seen: covariance.1,
    }
}

/// The turns that the data show, with their covariance and whether that is all: along the others gravity stays where it was.
fn seen(term: &Term, covariance: &DMatrix<f64>) -> (Vec<f64>, (DMatrix<f64>, bool)) {
    let k = term.shape.len();
    let eigen = covariance.view((0, 0), (k, k)).into_owned().symmetric_eigen();
    let angles = DVector::from_column_slice(&term.shape);
    let (mut shape, mut spread, mut all) = (DVector::zeros(k), DMatrix::zeros(k, k), true);
    for (variance, axis) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        // Without information a pseudo-inverse has no variance at all.
        if *variance > 0.0 && *variance < SETTINGS.mounting.unseen_angle * SETTINGS.mounting.unseen_angle {
            shape += axis * axis.dot(&angles);
            spread += axis * axis.transpose() * *variance;
        } else {
            all = false;
        }
    }
    (shape.as_slice().to_vec(), (spread, all))
}
