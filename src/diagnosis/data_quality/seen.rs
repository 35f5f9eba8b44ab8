//! What is wrong with a log, row by row, from the columns alone.

use super::clipping::{Clip, clipped, extremes};
use super::frozen::{frozen_runs, stuck_position, stuck_torque};
use super::garbage::garbage_rows;
use super::raw_log::RawLog;
use crate::preparation::{Exclusion, exclusions};
use std::ops::Range;

/// What is wrong, row by row.
pub(crate) struct Seen {
    pub garbage: Vec<bool>,
    pub frozen: Vec<Range<usize>>,
    /// Torque columns that say nothing of their joint, and why.
    pub unusable: Vec<Option<Exclusion>>,
    pub stuck_torque: Vec<Vec<Range<usize>>>,
    pub stuck_position: Vec<Vec<Range<usize>>>,
    pub clipped: Vec<Option<Clip>>,
}

impl Seen {
    pub fn new(log: &RawLog) -> Self {
        let rows = log.q[0].len();
        let garbage = garbage_rows(log);
        let frozen = frozen_runs(log);
        let mut left: Vec<bool> = garbage.iter().map(|g| !g).collect();
        frozen.iter().for_each(|run| left[run.clone()].fill(false));
        let clean = |column: &[f64]| -> Vec<f64> { (0..rows).filter(|&s| left[s]).map(|s| column[s]).collect() };
        let constant = |column: &Vec<f64>| clean(column).windows(2).all(|w| w[0] == w[1]);
        let still: Vec<bool> = log.q.iter().map(constant).collect();
        let unusable = exclusions(&log.tau, &left, &vec![false; log.tau.len()]);
        let constant_torque: Vec<bool> = unusable.iter().map(Option::is_some).collect();
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
                    clipped(&log.tau[j], &log.q[j], &left)
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
            unusable,
            stuck_torque,
            stuck_position,
            clipped,
        }
    }
}
