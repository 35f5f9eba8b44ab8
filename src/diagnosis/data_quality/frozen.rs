//! Intervals in which a log, or one of its columns, stands still while the arm moves.

use super::garbage::{least_step, usual_step};
use super::raw_log::RawLog;
use crate::diagnosis::settings::SETTINGS;
use std::ops::Range;

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

/// Runs that are far longer than those of a log whose rows are merely polled twice: `least` rows, and five times what 99 of 100
/// runs are.
fn long_runs(all: Vec<Range<usize>>, least: usize, rows: usize) -> Vec<Range<usize>> {
    let mut lengths: Vec<usize> = all.iter().map(Range::len).collect();
    lengths.sort_unstable();
    let usual = lengths.get(lengths.len() * 99 / 100).copied().unwrap_or(0);
    let long = |r: &Range<usize>| r.len() >= least && r.len() > 5 * usual && r.len() < rows;
    all.into_iter().filter(long).collect()
}

/// Intervals in which no column changes, unless the arm comes to rest before and sets off from rest afterwards.
pub(crate) fn frozen_runs(log: &RawLog) -> Vec<Range<usize>> {
    let rows = log.q[0].len();
    let same = |s: usize| log.q.iter().chain(&log.tau).all(|c| c[s] == c[s - 1]);
    let usual: Vec<f64> = log.q.iter().map(|q| usual_step(q)).collect();
    // A single count of an encoder is what every slow motion is made of.
    let counts: Vec<f64> = log.q.iter().map(|q| 2.0 * least_step(q)).collect();
    let step = |j: usize, s: usize| (log.q[j][s] - log.q[j][s - 1]).abs();
    let goes_on = |run: &Range<usize>| {
        (0..log.q.len()).any(|j| {
            // The clock went on: the first row afterwards makes up for it, or the last before was in full motion.
            let after = run.end < rows && step(j, run.end) > usual[j].max(counts[j]);
            let before = run.start > 0 && step(j, run.start) > (0.05 * usual[j]).max(counts[j]);
            usual[j] > 0.0 && (after || before)
        })
    };
    let runs = long_runs(runs(rows, same), 10, rows);
    runs.into_iter().filter(goes_on).collect()
}

/// A torque that does not change while its joint travels, a fifth of its usual step per row, and then jumps to where it should
/// have been: a coarse converter goes on by a count.
pub(crate) fn stuck_torque(log: &RawLog, joint: usize) -> Vec<Range<usize>> {
    let (q, tau) = (&log.q[joint], &log.tau[joint]);
    let usual = usual_step(q);
    let travels = |r: &Range<usize>| (q[r.end - 1] - q[r.start]).abs() > 0.2 * usual * r.len() as f64;
    let most = 3.0 * usual_step(tau).max(least_step(tau));
    let jumps = |r: &Range<usize>| match tau.get(r.end) {
        Some(next) => (next - tau[r.end - 1]).abs() > most,
        None => r.len() as f64 > SETTINGS.data_quality.frozen_share * tau.len() as f64,
    };
    let runs = long_runs(runs(tau.len(), |s| tau[s] == tau[s - 1]), 20, tau.len());
    runs.into_iter().filter(|r| travels(r) && jumps(r)).collect()
}

/// A position that does not change and then jumps to where the joint has gone.
pub(crate) fn stuck_position(q: &[f64]) -> Vec<Range<usize>> {
    let usual = usual_step(q).max(least_step(q));
    let jumps = |r: &Range<usize>| r.end < q.len() && (q[r.end] - q[r.end - 1]).abs() > 3.0 * usual;
    let runs = long_runs(runs(q.len(), |s| q[s] == q[s - 1]), 20, q.len());
    runs.into_iter().filter(jumps).collect()
}
