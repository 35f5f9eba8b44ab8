//! Friction of one joint that drifts over a log as the joint warms up, from what the periods deviate from their mean.

use super::period_finding::{BetweenFinding, Explained, Seams, start_rows};
use crate::diagnosis::golden_section::golden_section;
use crate::diagnosis::report::ReportedParameter;
use crate::diagnosis::selection::chance;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::by_code;
use crate::model::Robot;
use crate::regression::{NoiseModel, Stretch, deviation, reduce};
use nalgebra::{DMatrix, DVector};

pub(crate) fn best_drift(robot: &Robot, stretch: &Stretch, noise: &[NoiseModel], seams: &Seams) -> Option<Explained> {
    let length = length_of(stretch)?;
    let courses = SETTINGS.replicates.drift_courses;
    let tries = (courses.len() * robot.joint_count()) as f64;
    let mut best: Option<(f64, usize, f64)> = None;
    for j in 0..robot.joint_count() {
        let at = |course: f64| drift_fit(stretch, noise, seams, j, course * length);
        for course in courses {
            let (gain, _, _) = at(course);
            if best.is_none_or(|b| gain > b.0) {
                best = Some((gain, j, course * length));
            }
        }
    }
    let (_, j, coarse) = best?;
    let drift = refined_drift(stretch, noise, seams, j, coarse);
    let p_value = chance(drift.gain, 3) * tries;
    let finding = drift_finding(robot, stretch, noise, seams, &drift, p_value);
    let Drift { course, solution, .. } = drift;
    let mut periods = stretch.periods.clone();
    let mean = mean_course(stretch, course);
    for (p, period) in periods.iter_mut().enumerate() {
        for s in 0..stretch.rows() {
            let v = stretch.motion.velocities(j)[s];
            let g = course_at(stretch, p, s, course) - mean;
            period[j][s] -= g * (solution[0] * v + solution[1] * direction(v));
        }
    }
    Some((finding, periods))
}

/// Time from the start of the first period to the end of the last (s).
fn length_of(stretch: &Stretch) -> Option<f64> {
    Some(stretch.starts.last()? - stretch.starts[0] + stretch.rows() as f64 * stretch.interval)
}

fn direction(v: f64) -> f64 {
    if v == 0.0 { 0.0 } else { v.signum() }
}

/// `exp(−(t − t_0)/T)` with t_0 the start of the log.
fn course_at(stretch: &Stretch, period: usize, row: usize, constant: f64) -> f64 {
    (-(stretch.starts[period] - stretch.starts[0] + row as f64 * stretch.interval) / constant).exp()
}

fn mean_course(stretch: &Stretch, constant: f64) -> f64 {
    let (periods, rows) = (stretch.periods.len(), stretch.rows());
    let sum: f64 = (0..periods)
        .map(|p| (0..rows).map(|s| course_at(stretch, p, s, constant)).sum::<f64>())
        .sum();
    sum / (periods * rows) as f64
}

/// Friction of one joint that changes as `exp(−t/T)`, fitted to the deviations between periods.
struct Drift {
    joint: usize,
    gain: f64,
    /// T (s).
    course: f64,
    /// Viscous and Coulomb friction that fades.
    solution: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// Golden section on the logarithm of the time constant, a factor of three to either side: thirty steps leave 1e-6 of it, a
/// hundredth of the standard deviation of the strongest drift.
fn refined_drift(stretch: &Stretch, noise: &[NoiseModel], seams: &Seams, joint: usize, coarse: f64) -> Drift {
    let ratio = SETTINGS.replicates.course_ratio;
    let around = [coarse / ratio, coarse * ratio].map(f64::ln);
    let gain = |x: f64| drift_fit(stretch, noise, seams, joint, x.exp()).0;
    let course = golden_section(gain, around, 30).exp();
    let (gain, solution, covariance) = drift_fit(stretch, noise, seams, joint, course);
    Drift {
        joint,
        gain,
        course,
        solution,
        covariance,
    }
}

/// Least squares of the whitened deviations of all periods on friction times the course, whose mean over the periods is taken
/// out.
fn drift_fit(
    stretch: &Stretch,
    noise: &[NoiseModel],
    seams: &Seams,
    j: usize,
    constant: f64,
) -> (f64, DVector<f64>, DMatrix<f64>) {
    let count = stretch.periods.len();
    let rows = stretch.rows();
    let keep = seams.whitened_rows(&noise[j], stretch.kept(&stretch.motion, j));
    let speed = stretch.motion.velocities(j);
    // The start of the first period is filled with the others' mean: it says nothing, and is no part of the mean there.
    let start = start_rows(stretch);
    let mean: Vec<f64> = (0..rows)
        .map(|s| {
            let first = usize::from(s < start);
            (first..count).map(|p| course_at(stretch, p, s, constant)).sum::<f64>() / (count - first) as f64
        })
        .collect();
    let (mut own, mut right) = (DMatrix::zeros(2, 2), DVector::zeros(2));
    for (p, period) in stretch.periods.iter().enumerate() {
        let mut rows_here = keep.clone();
        if p == 0 {
            let reach = (start + noise[j].autoregression.len()).min(rows);
            rows_here[..reach].iter_mut().for_each(|k| *k = false);
        }
        let keep = &rows_here;
        let column = |f: fn(f64) -> f64| {
            let raw: Vec<f64> = (0..rows)
                .map(|s| (course_at(stretch, p, s, constant) - mean[s]) * f(speed[s]))
                .collect();
            noise[j].whiten(&raw, keep, 1)
        };
        let columns = DMatrix::from_columns(&[DVector::from_vec(column(|v| v)), DVector::from_vec(column(direction))]);
        let white = DVector::from_vec(noise[j].whiten(&deviation(stretch, period, j), keep, 1));
        own += columns.tr_mul(&columns);
        right += columns.tr_mul(&white);
    }
    let reduced = reduce(&own, &own, &right);
    let covariance = own
        .clone()
        .try_inverse()
        .unwrap_or_else(|| DMatrix::from_element(2, 2, f64::INFINITY));
    (reduced.gain, reduced.coefficients, covariance)
}

/// Standard deviation of a time constant of which nothing is known but that it is one of those tried (s).
fn spread_of_tried(stretch: &Stretch) -> f64 {
    let length = length_of(stretch).unwrap_or(0.0);
    let (courses, ratio) = (SETTINGS.replicates.drift_courses, SETTINGS.replicates.course_ratio);
    (courses[courses.len() - 1] * ratio - courses[0] / ratio) * length / 12f64.sqrt()
}

/// Changes of friction from the start of the log to its end, with the time constant that they were fitted with (variable
/// projection: the gain falls by one at one standard deviation of it, and the coefficients move with it).
fn drift_finding(
    robot: &Robot,
    stretch: &Stretch,
    noise: &[NoiseModel],
    seams: &Seams,
    drift: &Drift,
    p_value: f64,
) -> BetweenFinding {
    let (j, course) = (drift.joint, drift.course);
    let last = stretch.periods.len() - 1;
    let swing = |constant: f64| course_at(stretch, last, stretch.rows() - 1, constant) - 1.0;
    // A tenth of the time constant to both sides is where the gain is still a parabola.
    let step = 0.1 * course;
    let sides = [course - step, course + step].map(|t| (drift_fit(stretch, noise, seams, j, t), swing(t)));
    let curvature = 2.0 * drift.gain - sides[0].0.0 - sides[1].0.0;
    // Where the gain hardly falls, at an end of the courses tried, the course is anywhere among those tried.
    let of_course = (step * (2.0 / curvature.max(f64::MIN_POSITIVE)).sqrt()).min(spread_of_tried(stretch));
    let infos = by_code("friction_drift").expect("is in the list").parameters(0, robot, &[j]);
    let change = |(i, info): (usize, crate::effects::ParameterInfo)| {
        let slope = (sides[1].0.1[i] * sides[1].1 - sides[0].0.1[i] * sides[0].1) / (2.0 * step);
        let alone = drift.covariance[(i, i)].max(0.0).sqrt() * swing(course);
        ReportedParameter {
            name: format!("{}_over_log", info.name),
            value: drift.solution[i] * swing(course),
            unit: info.unit,
            std_dev: alone.hypot(slope * of_course),
        }
    };
    let mut parameters: Vec<ReportedParameter> = infos.into_iter().enumerate().map(change).collect();
    parameters.push(ReportedParameter {
        name: "time_constant".into(),
        value: course,
        unit: "s".into(),
        std_dev: of_course,
    });
    BetweenFinding {
        effect: "friction_drift",
        joints: vec![j],
        parameters,
        gain: drift.gain,
        p_value,
        first_row: None,
        filled: None,
        rms: None,
    }
}
