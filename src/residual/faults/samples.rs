//! Faults of single samples, from the columns alone: garbage, frozen, clipped, repeated times.

use super::{DataFault, FaultKind, RawLog, Remedy};
use crate::identification::Log;
use crate::model::Robot;
use std::ops::Range;

/// Faults of the samples of a log, from the columns alone.
pub fn sample_faults(robot: &Robot, log: &RawLog) -> Vec<DataFault> {
    let mut found = Vec::new();
    let mut say = |joints: Vec<String>, remedy: Remedy, detail: String| {
        found.push(DataFault {
            fault: FaultKind::BadSamples,
            joints,
            detail,
            remedy,
        })
    };
    if let Some(detail) = time_faults(&log.time) {
        say(Vec::new(), Remedy::LeaveOut, detail);
    }
    let seen = Seen::new(log);
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
        if seen.constant_torque[j] || seen.constant_position[j] {
            let what = if seen.constant_torque[j] { "torque" } else { "position" };
            let detail = format!(
                "the {what} column of {} is constant: not connected, or not recorded",
                joint.name
            );
            say(named(), Remedy::Nothing, detail);
        }
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
            let levels: Vec<String> = clip.levels.iter().map(|l| format!("{l:.4}")).collect();
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

/// What is wrong, row by row.
struct Seen {
    garbage: Vec<bool>,
    frozen: Vec<Range<usize>>,
    constant_torque: Vec<bool>,
    constant_position: Vec<bool>,
    stuck_torque: Vec<Vec<Range<usize>>>,
    stuck_position: Vec<Vec<Range<usize>>>,
    clipped: Vec<Option<Clip>>,
}

impl Seen {
    fn new(log: &RawLog) -> Self {
        let rows = log.q[0].len();
        let garbage = garbage_rows(log);
        let frozen = frozen_runs(log);
        let mut left: Vec<bool> = garbage.iter().map(|g| !g).collect();
        frozen.iter().for_each(|run| left[run.clone()].fill(false));
        let clean = |column: &[f64]| -> Vec<f64> { (0..rows).filter(|&s| left[s]).map(|s| column[s]).collect() };
        let constant = |column: &Vec<f64>| clean(column).windows(2).all(|w| w[0] == w[1]);
        let constant_torque: Vec<bool> = log.tau.iter().map(constant).collect();
        let still: Vec<bool> = log.q.iter().map(constant).collect();
        // A joint that is held still has a constant position; one that is held still alone, with a torque that changes, is not recorded.
        let others_move = |j: usize| still.iter().enumerate().any(|(i, s)| i != j && !s);
        let constant_position = (0..still.len())
            .map(|j| still[j] && others_move(j) && !constant_torque[j])
            .collect();
        let apart = |runs: Vec<Range<usize>>| -> Vec<Range<usize>> {
            runs.into_iter()
                .filter(|r| !frozen.iter().any(|f| f.start < r.end && r.start < f.end))
                .collect()
        };
        let stuck_torque: Vec<Vec<Range<usize>>> = (0..log.tau.len())
            .map(|j| {
                if constant_torque[j] {
                    Vec::new()
                } else {
                    apart(stuck_torque(log, j))
                }
            })
            .collect();
        let stuck_position = (0..log.q.len())
            .map(|j| {
                if still[j] {
                    Vec::new()
                } else {
                    apart(stuck_position(&log.q[j]))
                }
            })
            .collect();
        let clipped = (0..log.tau.len())
            .map(|j| {
                let mut left = left.clone();
                // A clipped signal stands still at its end as well.
                let ends = extremes(&log.tau[j], &left);
                let inside = |r: &&Range<usize>| !ends.contains(&log.tau[j][r.start]);
                stuck_torque[j]
                    .iter()
                    .filter(inside)
                    .for_each(|r| left[r.clone()].fill(false));
                if constant_torque[j] {
                    None
                } else {
                    clipped(&log.tau[j], &left)
                }
            })
            .collect::<Vec<_>>();
        let stuck_torque = stuck_torque
            .into_iter()
            .enumerate()
            .map(|(j, runs)| {
                let at_end = |r: &Range<usize>| {
                    clipped[j]
                        .as_ref()
                        .is_some_and(|c: &Clip| c.levels.contains(&log.tau[j][r.start]))
                };
                runs.into_iter().filter(|r| !at_end(r)).collect()
            })
            .collect();
        Self {
            garbage,
            frozen,
            constant_torque,
            constant_position,
            stuck_torque,
            stuck_position,
            clipped,
        }
    }
}

fn time_faults(time: &[f64]) -> Option<String> {
    let not_finite = time.iter().filter(|t| !t.is_finite()).count();
    let repeated = time.windows(2).filter(|w| w[1] == w[0]).count();
    let backwards = time.windows(2).filter(|w| w[1] < w[0]).count();
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let usual = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    // Half a sample more than two steps: one row at least is missing. A repeated stamp makes the next step two long, which is no gap.
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

/// The 90th percentile of the steps from row to row: nearly what a column does at its fastest, and below what a twentieth of spoiled rows makes.
fn usual_step(column: &[f64]) -> f64 {
    let mut steps: Vec<f64> = column
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .filter(|d| d.is_finite())
        .collect();
    if steps.is_empty() {
        return 0.0;
    }
    let at = (steps.len() * 9) / 10;
    *steps.select_nth_unstable_by(at, f64::total_cmp).1
}

/// Twenty times the usual step: motion and white noise stay below three, a dropped row or a stray packet is in the hundreds.
const FAR: f64 = 20.0;
/// Rows that a stray packet can hold on to.
const LONGEST_PACKET: usize = 50;

/// Rows that jump away from both neighbours by far more than neighbours differ, or are not finite; in positions, which never jump, also runs
/// of rows between a jump away and a jump back. A torque may do so where its joint turns round: sharp friction is felt in a single row there.
fn garbage_rows(log: &RawLog) -> Vec<bool> {
    let rows = log.q[0].len();
    let mut bad = vec![false; rows];
    for (at, column) in log.q.iter().chain(&log.tau).enumerate() {
        let usual = usual_step(column);
        let limit = (FAR * usual).max(1e-9);
        let friction = at.checked_sub(log.q.len()).map(|j| Friction::new(&log.q[j], column));
        for s in 0..rows {
            let value = column[s];
            let neighbours = [s.checked_sub(1), (s + 1 < rows).then_some(s + 1)];
            let away: Vec<f64> = neighbours
                .into_iter()
                .flatten()
                .filter(|&n| column[n].is_finite() && !bad[n])
                .map(|n| value - column[n])
                .collect();
            // A fast motion between two rests passes on: it lies between its neighbours.
            let passes = away.len() == 2 && away[0] * away[1] < 0.0;
            let far = !passes && away.iter().all(|d| d.abs() > limit);
            let sharp = || friction.as_ref().is_some_and(|f| f.explains(s, value));
            bad[s] |= !value.is_finite() || far && usual > 0.0 && !sharp();
        }
        if at < log.q.len() && usual > 0.0 {
            packets(column, limit).into_iter().for_each(|run| bad[run].fill(true));
        }
    }
    bad
}

/// What friction can do to a torque in a single row.
struct Friction<'a> {
    q: &'a [f64],
    /// Beyond the usual torques by as much as they differ among themselves is more than any friction of this joint.
    range: [f64; 2],
}

impl<'a> Friction<'a> {
    fn new(q: &'a [f64], torque: &[f64]) -> Self {
        let mut sorted: Vec<f64> = torque.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        // Spoiled rows are fewer than one in fifty at each end.
        let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(0.0);
        let (low, high) = (at(0.02), at(0.98));
        Self {
            q,
            range: [low - (high - low), high + (high - low)],
        }
    }

    fn explains(&self, row: usize, torque: f64) -> bool {
        (self.range[0]..=self.range[1]).contains(&torque) && (row.saturating_sub(1)..=row + 1).any(|s| self.turns(s))
    }

    /// Whether the joint turns round at a row: the last step before it goes one way, the first one after it the other. Encoders count whole steps, so that
    /// it may stand for some rows.
    fn turns(&self, row: usize) -> bool {
        let step = |s: usize| Some(self.q.get(s + 1)? - self.q[s]).filter(|d| *d != 0.0);
        let before = (row.saturating_sub(LONGEST_REST)..row).rev().find_map(step);
        let after = (row..row + LONGEST_REST).find_map(step);
        matches!((before, after), (Some(a), Some(b)) if a * b < 0.0)
    }
}

/// Rows that a joint stands where it turns round.
const LONGEST_REST: usize = 5;

/// Runs between a jump away and a jump back to where the column would have gone.
fn packets(column: &[f64], limit: f64) -> Vec<Range<usize>> {
    let jumps: Vec<usize> = (1..column.len())
        .filter(|&s| (column[s] - column[s - 1]).abs() > limit)
        .collect();
    let back = |w: &&[usize]| {
        let length = w[1] - w[0];
        length <= LONGEST_PACKET && (column[w[1]] - column[w[0] - 1]).abs() <= limit * (length + 1) as f64 / FAR
    };
    jumps.windows(2).filter(back).map(|w| w[0]..w[1]).collect()
}

/// Runs of equal rows as `start..end`, by whether row s is the same as the one before.
fn runs(rows: usize, same: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let (mut all, mut start) = (Vec::new(), 0);
    for s in 1..=rows {
        if s == rows || !same(s) {
            all.push(start..s);
            start = s;
        }
    }
    all
}

/// Runs that are far longer than those of a log whose rows are merely polled twice: `least` rows, and five times what 99 of 100 runs are.
fn long_runs(all: Vec<Range<usize>>, least: usize, rows: usize) -> Vec<Range<usize>> {
    let mut lengths: Vec<usize> = all.iter().map(Range::len).collect();
    lengths.sort_unstable();
    let usual = lengths[lengths.len() * 99 / 100];
    let long = |r: &Range<usize>| r.len() >= least && r.len() > 5 * usual && r.len() < rows;
    all.into_iter().filter(long).collect()
}

/// Intervals in which no column changes, unless the arm comes to rest before and sets off from rest afterwards.
fn frozen_runs(log: &RawLog) -> Vec<Range<usize>> {
    let rows = log.q[0].len();
    let same = |s: usize| log.q.iter().chain(&log.tau).all(|c| c[s] == c[s - 1]);
    let usual: Vec<f64> = log.q.iter().map(|q| usual_step(q)).collect();
    let step = |j: usize, s: usize| (log.q[j][s] - log.q[j][s - 1]).abs();
    let goes_on = |run: &Range<usize>| {
        (0..log.q.len()).any(|j| {
            // The clock went on: the first row afterwards makes up for it, or the last before was in full motion.
            let after = run.end < rows && step(j, run.end) > usual[j];
            let before = run.start > 0 && step(j, run.start) > 0.05 * usual[j];
            usual[j] > 0.0 && (after || before)
        })
    };
    let runs = long_runs(runs(rows, same), 10, rows);
    runs.into_iter().filter(goes_on).collect()
}

/// A torque that does not change while its joint travels: a fifth of its usual step per row.
fn stuck_torque(log: &RawLog, joint: usize) -> Vec<Range<usize>> {
    let (q, tau) = (&log.q[joint], &log.tau[joint]);
    let usual = usual_step(q);
    let travels = |r: &Range<usize>| (q[r.end - 1] - q[r.start]).abs() > 0.2 * usual * r.len() as f64;
    let runs = long_runs(runs(tau.len(), |s| tau[s] == tau[s - 1]), 20, tau.len());
    runs.into_iter().filter(travels).collect()
}

/// A position that does not change and then jumps to where the joint has gone.
fn stuck_position(q: &[f64]) -> Vec<Range<usize>> {
    let usual = usual_step(q);
    let jumps = |r: &Range<usize>| r.end < q.len() && (q[r.end] - q[r.end - 1]).abs() > 3.0 * usual;
    let runs = long_runs(runs(q.len(), |s| q[s] == q[s - 1]), 20, q.len());
    runs.into_iter().filter(jumps).collect()
}

/// A signal that has been cut off.
struct Clip {
    levels: Vec<f64>,
    /// Samples at the levels.
    count: usize,
    /// Rows whose mean over periods or neighbours the cut has moved.
    rows: Vec<bool>,
}

impl Clip {
    /// With half of the rows gone, what is left is no motion that a model could be asked about.
    fn spoils_too_much(&self) -> bool {
        2 * self.rows.iter().filter(|r| **r).count() > self.rows.len()
    }
}

fn extremes(column: &[f64], left: &[bool]) -> [f64; 2] {
    let values = column.iter().zip(left).filter(|(_, l)| **l).map(|(v, _)| *v);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    [low, high]
}

/// Ends of the range at which samples pile up: ten at least, and more than three times as many as on the next level. The top of a sinusoid
/// in coarse steps has 1/(√2 − 1) = 2.4 times as many as the step below it.
fn clipped(column: &[f64], left: &[bool]) -> Option<Clip> {
    let mut sorted: Vec<f64> = column.iter().zip(left).filter(|(_, l)| **l).map(|(v, _)| *v).collect();
    sorted.sort_by(f64::total_cmp);
    let top = piled_up(sorted.iter().rev().copied());
    let bottom = piled_up(sorted.iter().copied());
    let noise = noise_of(column);
    let half = WINDOW / 2;
    let mean = |s: usize| {
        let (from, to) = (s.saturating_sub(half), (s + half + 1).min(column.len()));
        column[from..to].iter().sum::<f64>() / (to - from) as f64
    };
    let (mut levels, mut count) = (Vec::new(), 0);
    let mut rows = vec![false; column.len()];
    for (level, side, piled) in [top.map(|(l, c)| (l, 1.0, c)), bottom.map(|(l, c)| (l, -1.0, c))]
        .into_iter()
        .flatten()
    {
        levels.push(level);
        count += piled;
        // Within two standard deviations of the level, noise is cut off on one side. By the local mean: a choice by the sample's own noise would
        // move the mean of the rest.
        for s in 0..column.len() {
            rows[s] |= column[s] == level || side * (level - mean(s)) < 2.0 * noise;
        }
    }
    (count > 0).then_some(Clip { levels, count, rows })
}

/// Neighbours whose mean says where a torque is: a tenth of a second at 200 Hz.
const WINDOW: usize = 21;

/// The first value of a sorted series and its count, if that stands out.
fn piled_up(values: impl Iterator<Item = f64>) -> Option<(f64, usize)> {
    let mut values = values.peekable();
    let level = *values.peek()?;
    let mut count = 0;
    while values.next_if(|v| *v == level).is_some() {
        count += 1;
    }
    let next = values.peek().copied()?;
    let on_next = values.take_while(|v| *v == next).count();
    (count >= 10 && count > 3 * on_next).then_some((level, count))
}

/// White noise on a smooth signal, from the median of its third differences: √20 times the noise, 0.6745 of a normal deviate's spread.
fn noise_of(column: &[f64]) -> f64 {
    let mut third: Vec<f64> = column
        .windows(4)
        .map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs())
        .collect();
    if third.is_empty() {
        return 0.0;
    }
    let middle = third.len() / 2;
    *third.select_nth_unstable_by(middle, f64::total_cmp).1 / (0.6745 * 20f64.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One row of a torque stands out by a hundred steps: garbage, unless the joint turns round there and friction could be that large.
    #[test]
    fn prop_a_peak_is_no_garbage_where_the_joint_turns_round() {
        let time: Vec<f64> = (0..1000).map(|s| 0.005 * s as f64).collect();
        let of = |f: fn(f64) -> f64| time.iter().map(|t| f(*t)).collect::<Vec<f64>>();
        // It turns round after 1.25 s, in row 250, where it is for one, or, with an encoder of coarse steps, for several rows.
        let fine = of(|t| (0.4 * std::f64::consts::PI * t).sin());
        let coarse: Vec<f64> = fine.iter().map(|q| (q * 5000.0).round() / 5000.0).collect();
        for q in [fine, coarse] {
            let garbage = |row: usize, peak: f64| {
                let mut tau = of(|t| 3.0 * (0.8 * std::f64::consts::PI * t).cos());
                tau[row] += peak;
                let log = RawLog {
                    time: time.clone(),
                    q: vec![q.clone()],
                    tau: vec![tau],
                };
                let rows = garbage_rows(&log);
                (0..rows.len()).filter(|&s| rows[s]).collect::<Vec<usize>>()
            };
            assert_eq!(garbage(250, 4.0), [0usize; 0]);
            assert_eq!(garbage(250, 40.0), [250]);
            assert_eq!(garbage(400, 4.0), [400]);
        }
    }
}
