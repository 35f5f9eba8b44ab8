//! Faults of single samples, reported and left out: garbage, frozen, clipped, repeated times.

use super::fault::{DataFault, FaultKind, Remedy};
use super::raw_log::RawLog;
use super::seen::Seen;
use crate::model::{Joint, Robot, decimals};
use crate::preparation::{Exclusion, Log};
use std::ops::Range;

/// Faults of the samples of a log, from the columns alone.
pub fn sample_faults(robot: &Robot, log: &RawLog) -> Vec<DataFault> {
    let seen = Seen::new(log);
    let mut found = unusable_torques(robot, &seen);
    let mut say = |joints: Vec<String>, remedy: Remedy, detail: String| {
        found.push(DataFault::new(FaultKind::BadSamples, joints, detail, remedy));
    };
    if let Some(detail) = time_faults(&log.time) {
        say(Vec::new(), Remedy::LeaveOut, detail);
    }
    if let Some(first) = seen.garbage.iter().position(|g| *g) {
        let count = seen.garbage.iter().filter(|g| **g).count();
        let detail = format!(
            "{count} rows hold numbers that do not belong to a motion, the first is row {}: leave them out",
            first + 1
        );
        say(Vec::new(), Remedy::LeaveOut, detail);
    }
    if let Some(first) = seen.frozen.first() {
        let rows: usize = seen.frozen.iter().map(Range::len).sum();
        let detail = format!(
            "all columns stand still for {rows} rows from row {}: the recording froze, leave the interval out",
            first.start + 1
        );
        say(Vec::new(), Remedy::LeaveOut, detail);
    }
    for (j, joint) in robot.joints().iter().enumerate() {
        let named = || vec![joint.name.clone()];
        for (what, stuck) in [("torque", &seen.stuck_torque[j]), ("position", &seen.stuck_position[j])] {
            if let Some(first) = stuck.first() {
                let rows: usize = stuck.iter().map(Range::len).sum();
                let detail = format!(
                    "the {what} of {} stands still for {rows} rows from row {} while the arm moves: leave the interval out",
                    joint.name,
                    first.start + 1
                );
                say(named(), Remedy::LeaveOut, detail);
            }
        }
        if let Some(clip) = &seen.clipped[j] {
            let levels: Vec<String> = clip.levels.iter().map(|l| decimals(*l, 4)).collect();
            let remedy = if clip.spoils_too_much() {
                Remedy::Nothing
            } else {
                Remedy::LeaveOut
            };
            let detail = format!(
                "{} torque samples of {} lie at {}: the signal is clipped there, leave them out or lower the load",
                clip.count,
                joint.name,
                levels.join(" and ")
            );
            say(named(), remedy, detail);
        }
    }
    found
}

/// Joints whose torque says nothing of them; they are left out of everything.
fn unusable_torques(robot: &Robot, seen: &Seen) -> Vec<DataFault> {
    let of = |(joint, why): (&Joint, &Option<Exclusion>)| {
        let why = (*why)?;
        let kind = match why {
            Exclusion::ImplausibleTorque(_) => FaultKind::UnitUnknown,
            _ => FaultKind::BadSamples,
        };
        let detail = format!(
            "joint {}: {why}; the joint is left out, the others are not affected",
            joint.name
        );
        Some(DataFault::new(kind, vec![joint.name.clone()], detail, Remedy::LeaveOut))
    };
    robot.joints().iter().zip(&seen.unusable).filter_map(of).collect()
}

/// Rows that are no measurement.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LostRows {
    /// Garbage, frozen, or with a position that stands still.
    pub motion: Vec<bool>,
    /// Those, and rows with a torque that stands still or lies at the end of its range, whose positions are sound.
    pub torque: Vec<bool>,
}

/// Rows of a log that its faults have spoiled.
pub fn lost_rows(log: &RawLog) -> LostRows {
    let seen = Seen::new(log);
    let mut motion = seen.garbage.clone();
    for run in seen.frozen.iter().chain(seen.stuck_position.iter().flatten()) {
        motion[run.clone()].fill(true);
    }
    let mut torque = motion.clone();
    for run in seen.stuck_torque.iter().flatten() {
        torque[run.clone()].fill(true);
    }
    for clip in seen.clipped.iter().flatten().filter(|c| !c.spoils_too_much()) {
        torque.iter_mut().zip(&clip.rows).for_each(|(l, c)| *l |= c);
    }
    LostRows { motion, torque }
}

/// Puts straight lines in the place of what is lost, and says that these rows are not data.
pub fn leave_out(log: &mut Log, lost: &LostRows) {
    let moved = log.q.iter_mut().chain(log.qd.iter_mut().flatten());
    moved.for_each(|column| bridge(column, &lost.motion));
    log.tau.iter_mut().for_each(|column| bridge(column, &lost.torque));
    log.usable.iter_mut().zip(&lost.torque).for_each(|(u, l)| *u &= !l);
}

/// Straight lines over the lost rows of a column, level at its ends.
fn bridge(column: &mut [f64], lost: &[bool]) {
    let n = column.len();
    let mut s = 0;
    while s < n {
        if !lost[s] {
            s += 1;
            continue;
        }
        let end = (s..n).find(|&e| !lost[e]).unwrap_or(n);
        let before = s.checked_sub(1).map(|b| column[b]);
        let after = (end < n).then(|| column[end]);
        let (from, to) = (before.or(after).unwrap_or(0.0), after.or(before).unwrap_or(0.0));
        for k in s..end {
            column[k] = from + (to - from) * (k + 1 - s) as f64 / (end + 1 - s) as f64;
        }
        s = end;
    }
}

fn time_faults(time: &[f64]) -> Option<String> {
    let not_finite = time.iter().filter(|t| !t.is_finite()).count();
    let repeated = time.windows(2).filter(|w| w[1] == w[0]).count();
    let backwards = time.windows(2).filter(|w| w[1] < w[0]).count();
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let usual = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    // Half a sample more than two steps: one row at least is missing. A repeated stamp makes the next step two long, which is no
    // gap.
    let missing = steps.iter().filter(|d| **d > 2.5 * usual).count();
    let said: Vec<String> = [
        (not_finite, "not numbers"),
        (repeated, "repeated"),
        (backwards, "going back"),
        (missing, "followed by a gap"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{count} {what}"))
    .collect();
    (!said.is_empty()).then(|| {
        format!(
            "time stamps: {}; drop repeated rows and split the log at gaps",
            said.join(", ")
        )
    })
}
