//! What a simulation may be asked for.

use super::{Path, Request};
use crate::model::{FieldProblem, INPUT_LIMITS, Robot, decimals, shortest};
use crate::parameters::Layout;
use crate::simulate::{HiddenEffect, LogFault, RecordedLog};

/// Fewest rows: faults of a record and the ends of a trajectory need a first and a last.
const LEAST_ROWS: f64 = 2.0;
/// Elastic joints are integrated in steps of a millisecond, whatever the sample rate.
const STEPS_PER_SECOND: f64 = 1e3;

pub(super) fn check(request: &Request, robot: &Robot, problems: &mut Vec<FieldProblem>) {
    let n = robot.joint_count();
    let mut count = |field: &str, have: usize, want: usize| {
        if have != want {
            problems.push(FieldProblem::new(
                field,
                format!("has {have} entries where {want} are wanted"),
            ));
        }
    };
    if let Some(noise) = &request.noise {
        count("/noise/torque", noise.torque.len(), n);
    }
    if let Some(parameters) = &request.parameters {
        count("/parameters", parameters.len(), Layout::standard(robot).len());
    }
    match &request.trajectory {
        Path::Fourier { a, b, offset, .. } => {
            count("/trajectory/fourier/a", a.len(), n);
            count("/trajectory/fourier/b", b.len(), n);
            let order = a.first().map_or(0, Vec::len);
            a.iter()
                .chain(b)
                .for_each(|row| count("/trajectory/fourier", row.len(), order));
            offset.iter().for_each(|o| count("/trajectory/fourier/offset", o.len(), n));
        }
        Path::WayPoints { positions, durations } => {
            count("/trajectory/way_points/positions", positions.len(), durations.len() + 1);
            positions
                .iter()
                .for_each(|p| count("/trajectory/way_points/positions", p.len(), n));
        }
        Path::Sines { terms, .. } => count("/trajectory/sines/terms", terms.len(), n),
    }
    let durations: Vec<f64> = match &request.trajectory {
        Path::Fourier { fundamental_hz, .. } => vec![*fundamental_hz],
        Path::WayPoints { durations, .. } => {
            if durations.is_empty() {
                vec![0.0]
            } else {
                durations.clone()
            }
        }
        Path::Sines { duration, .. } => vec![*duration],
    };
    let mut positive = |field: &str, values: &[f64]| {
        if !values.iter().all(|v| v.is_finite() && *v > 0.0) {
            problems.push(FieldProblem::new(field, "is not a positive number"));
        }
    };
    positive("/trajectory", &durations);
    positive("/periods", &[request.periods]);
    positive("/sample_rate_hz", &[request.sample_rate_hz]);
    if problems.is_empty() {
        check_size(request, robot, problems);
    }
}

/// Length in time and rows, and what must fit into it: an input of a line must not ask for work without end.
fn check_size(request: &Request, robot: &Robot, problems: &mut Vec<FieldProblem>) {
    let joints = robot.joint_count();
    let seconds = request.periods * duration(&request.trajectory);
    let rows = (seconds * request.sample_rate_hz).round();
    let most = (INPUT_LIMITS.simulated_values / (joints + 2)) as f64;
    if !(LEAST_ROWS..=most).contains(&rows) {
        let detail = format!(
            "makes {} rows with this trajectory and `sample_rate_hz`; from 2 to {most} can be made of {joints} joints",
            decimals(rows, 0)
        );
        problems.push(FieldProblem::new("/periods", detail));
    }
    let elastic = |e: &HiddenEffect| matches!(e, HiddenEffect::JointElasticity { .. });
    let longest = (INPUT_LIMITS.simulated_steps / joints) as f64 / STEPS_PER_SECOND;
    if request.effects.iter().any(elastic) && seconds > longest {
        let detail = format!(
            "makes {} s; with elastic joints up to {longest} s can be made of {joints} joints",
            decimals(seconds, 0)
        );
        problems.push(FieldProblem::new("/periods", detail));
    }
    for (i, effect) in request.effects.iter().enumerate() {
        if let Some(detail) = misfit(effect, robot, seconds) {
            problems.push(FieldProblem::new(format!("/effects/{i}"), detail));
        }
    }
    for (i, fault) in request.faults.iter().enumerate() {
        if let LogFault::RepeatedTimes { count } | LogFault::GarbageRows { count } = fault
            && *count as f64 > rows
        {
            problems.push(FieldProblem::new(
                format!("/faults/{i}/count"),
                format!("is {count}, and the log has {rows:.0} rows"),
            ));
        }
    }
    if let Some(noise) = &request.noise {
        if !(0.0..=1.0 / request.sample_rate_hz).contains(&noise.jitter) {
            problems.push(FieldProblem::new(
                "/noise/jitter",
                format!("is {} s, expected a time from 0 to one sample", shortest(noise.jitter)),
            ));
        }
        if !(-1.0..=1.0).contains(&noise.torque_correlation) {
            problems.push(FieldProblem::new(
                "/noise/torque_correlation",
                format!(
                    "is {}, expected a correlation from -1 to 1",
                    shortest(noise.torque_correlation)
                ),
            ));
        }
    }
}

/// Of one run through the trajectory (s).
fn duration(path: &Path) -> f64 {
    match path {
        Path::Fourier { fundamental_hz, .. } => 1.0 / fundamental_hz,
        Path::WayPoints { durations, .. } => durations.iter().sum(),
        Path::Sines { duration, .. } => *duration,
    }
}

fn misfit(effect: &HiddenEffect, robot: &Robot, seconds: f64) -> Option<String> {
    let joints = robot.joint_count();
    match effect {
        HiddenEffect::Listed(listed) => listed.misfit(robot),
        HiddenEffect::ExternalContact { torque, .. } if torque.len() != joints => {
            Some(format!("has {} torques, the robot has {joints} joints", torque.len()))
        }
        HiddenEffect::TorqueDelay { seconds: late } if !(0.0..=seconds).contains(late) => Some(format!(
            "is late by {} s, expected a time from 0 to that of the log, {} s",
            shortest(*late),
            shortest(seconds)
        )),
        _ => None,
    }
}

/// Where the numbers of a log end: quantities of any size can be asked for, and their products need not fit into a double.
pub(super) fn not_finite(log: &RecordedLog, robot: &Robot) -> Option<FieldProblem> {
    let columns = [("position", &log.q), ("torque", &log.tau)];
    let each = columns
        .into_iter()
        .flat_map(|(what, all)| all.iter().enumerate().map(move |(j, column)| (what, j, column)));
    each.into_iter().find_map(|(what, j, column)| {
        let at = column.iter().position(|v| !v.is_finite())?;
        let detail = format!(
            "makes a {what} of joint {} that is no finite number, from {} s on",
            robot.joints()[j].name,
            shortest(log.time[at])
        );
        Some(FieldProblem::new("", detail).with_hint("make motion, masses or effects smaller"))
    })
}
