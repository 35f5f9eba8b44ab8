//! Rows that do not belong to a motion: dropped rows, stray packets, and what is no garbage but friction.

use super::RawLog;
use std::ops::Range;

/// The 90th percentile of the steps from row to row: nearly what a column does at its fastest, and below what a twentieth of spoiled rows makes.
pub(super) fn usual_step(column: &[f64]) -> f64 {
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

/// The smallest step of a column that is one: the count of an encoder or a converter, or next to nothing in a column of full numbers; 0 where nothing changes.
pub(super) fn least_step(column: &[f64]) -> f64 {
    let steps = column
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .filter(|d| *d > 0.0 && d.is_finite());
    let least = steps.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// Twenty times the usual step: motion and white noise stay below three, a dropped row or a stray packet is in the hundreds.
const FAR: f64 = 20.0;
/// Rows that a stray packet can hold on to.
const LONGEST_PACKET: usize = 50;

/// Rows that jump away from both neighbours by far more than neighbours differ, or are not finite; in positions, which never jump, also runs
/// of rows between a jump away and a jump back. A torque may do so where its joint turns round: sharp friction is felt in a single row there.
pub(super) fn garbage_rows(log: &RawLog) -> Vec<bool> {
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
        matches!((before, after), (Some(a), Some(b)) if a * b < 0.0) || self.starts_or_ends(row)
    }

    /// Whether the joint leaves rest or comes to it at an end of the log: it stands there, or, evenly accelerated as over the first two stretches of some rows,
    /// it went the other way in the one before, so that its speed was zero within half a stretch of the first row; likewise at the last row.
    fn starts_or_ends(&self, row: usize) -> bool {
        let last = self.q.len().saturating_sub(1);
        let at = |k: usize| match row {
            0 => self.q.get(k),
            _ => last.checked_sub(k).map(|s| &self.q[s]),
        };
        let [Some(q0), Some(q1), Some(q2)] = [0, LONGEST_REST, 2 * LONGEST_REST].map(at) else {
            return false;
        };
        let (near, far) = (q1 - q0, q2 - q1);
        (row == 0 || row == last) && (near == 0.0 || (2.0 * near - far) * far < 0.0)
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
