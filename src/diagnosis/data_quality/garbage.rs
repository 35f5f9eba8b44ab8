//! Rows that do not belong to a motion: dropped rows, stray packets, and what is no garbage but friction.

use super::raw_log::RawLog;
use crate::diagnosis::settings::SETTINGS;
use std::ops::Range;

/// The 90th percentile of the steps from row to row: nearly what a column does at its fastest, and below what a twentieth of
/// spoiled rows makes.
pub(crate) fn usual_step(column: &[f64]) -> f64 {
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

/// The smallest step of a column that is one: the count of an encoder or a converter, or next to nothing in a column of full
/// numbers; 0 where nothing changes.
pub(crate) fn least_step(column: &[f64]) -> f64 {
    let steps = column
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .filter(|d| *d > 0.0 && d.is_finite());
    let least = steps.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// Rows that jump away from both neighbours by far more than neighbours differ, or are not finite; in positions, which never
/// jump, also runs of rows between a jump away and a jump back. A torque may do so where its joint turns round: sharp friction is
/// felt in a single row there.
pub(crate) fn garbage_rows(log: &RawLog) -> Vec<bool> {
    let rows = log.q[0].len();
    let mut bad = vec![false; rows];
    for (at, column) in log.q.iter().chain(&log.tau).enumerate() {
        let usual = usual_step(column);
        let limit = (SETTINGS.data_quality.garbage_step * usual).max(1e-9);
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
    /// Rows between the five positions that a speed is taken from.
    stride: usize,
    /// Step of the encoder.
    step: f64,
    /// Standard deviation of its noise.
    noise: f64,
}

impl<'a> Friction<'a> {
    fn new(q: &'a [f64], torque: &[f64]) -> Self {
        let mut sorted: Vec<f64> = torque.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        // Spoiled rows are fewer than one in fifty at each end.
        let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(0.0);
        let (low, high) = (at(0.02), at(0.98));
        let (step, noise, usual) = (least_step(q), position_noise(q), usual_step(q));
        let stride = (SETTINGS.data_quality.garbage_counts * step.max(noise) / usual.max(f64::MIN_POSITIVE)).ceil();
        Self {
            q,
            range: [low - (high - low), high + (high - low)],
            stride: (stride as usize).clamp(1, SETTINGS.data_quality.widest_jump),
            step,
            noise,
        }
    }

    fn explains(&self, row: usize, torque: f64) -> bool {
        (self.range[0]..=self.range[1]).contains(&torque) && self.may_stand(row)
    }

    /// Whether the speed of the joint can be zero within a row of this one: it turns round there, touches rest and goes on, or
    /// stands.
    ///
    /// The speed is the derivative of the cubic that fits five positions best; it is zero where it changes its sign or is less
    /// than rounding and noise of the positions make of it.
    fn may_stand(&self, row: usize) -> bool {
        let reach = 2 * self.stride;
        if self.q.len() <= 2 * reach {
            return false;
        }
        let centre = row.clamp(reach, self.q.len() - 1 - reach);
        let stride = self.stride as f64;
        let here = (row as f64 - centre as f64) / stride;
        let positions: [f64; 5] = std::array::from_fn(|k| self.q[centre + k * self.stride - reach]);
        let speed = |x: f64| {
            let weights = speed_weights(x);
            let value: f64 = weights.iter().zip(&positions).map(|(w, q)| w * q).sum();
            let rounding = 0.5 * self.step * weights.iter().map(|w| w.abs()).sum::<f64>();
            let noise =
                SETTINGS.data_quality.friction_deviations * self.noise * weights.iter().map(|w| w * w).sum::<f64>().sqrt();
            (value, rounding + noise)
        };
        // A parabola: where it is zero twice within two rows, it is next to nothing in between and at their ends.
        let parts: Vec<(f64, f64)> = (-4..=4).map(|k| speed(here + 0.25 * f64::from(k) / stride)).collect();
        parts.iter().any(|(v, uncertain)| v.abs() <= *uncertain) || parts.windows(2).any(|w| w[0].0 * w[1].0 < 0.0)
    }
}

/// Weights of five evenly spaced positions in the derivative, `x` spaces from the middle one, of the cubic that fits them best
/// (Savitzky & Golay 1964).
fn speed_weights(x: f64) -> [f64; 5] {
    let first = [1.0, -8.0, 0.0, 8.0, -1.0].map(|w| w / 12.0);
    let second = [2.0, -1.0, -2.0, -1.0, 2.0].map(|w| w / 7.0);
    let third = [-1.0, 2.0, 0.0, -2.0, 1.0].map(|w| w / 2.0);
    std::array::from_fn(|k| first[k] + x * second[k] + 0.5 * x * x * third[k])
}

/// Standard deviation of white noise on a position, from its fourth differences, which hardly know the motion: the squares of
/// their weights sum to 70.
fn position_noise(q: &[f64]) -> f64 {
    let of = |w: &[f64]| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs();
    let mut differences: Vec<f64> = q.windows(5).map(of).filter(|d| d.is_finite()).collect();
    if differences.is_empty() {
        return 0.0;
    }
    let at = differences.len() / 2;
    // The median of the sizes of normal values is 0.6745 of their deviation.
    *differences.select_nth_unstable_by(at, f64::total_cmp).1 / (0.6745 * 70f64.sqrt())
}

/// Runs between a jump away and a jump back to where the column would have gone.
fn packets(column: &[f64], limit: f64) -> Vec<Range<usize>> {
    let jumps: Vec<usize> = (1..column.len())
        .filter(|&s| (column[s] - column[s - 1]).abs() > limit)
        .collect();
    let back = |w: &&[usize]| {
        let length = w[1] - w[0];
        length <= SETTINGS.data_quality.longest_packet
            && (column[w[1]] - column[w[0] - 1]).abs() <= limit * (length + 1) as f64 / SETTINGS.data_quality.garbage_step
    };
    jumps.windows(2).filter(back).map(|w| w[0]..w[1]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One row of a torque stands out by a hundred steps: garbage, unless the joint turns round there and friction could be that
    /// large.
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
