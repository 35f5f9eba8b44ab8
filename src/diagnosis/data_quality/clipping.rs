//! Torques that are cut off at the ends of their range.

use crate::diagnosis::settings::SETTINGS;
use crate::preparation::step_of;

/// A signal that has been cut off.
pub(crate) struct Clip {
    pub levels: Vec<f64>,
    /// Samples at the levels.
    pub count: usize,
    /// Rows whose mean over periods or neighbours the cut has moved.
    pub rows: Vec<bool>,
}

impl Clip {
    /// With half of the rows gone, what is left is no motion that a model could be asked about.
    pub fn spoils_too_much(&self) -> bool {
        2 * self.rows.iter().filter(|r| **r).count() > self.rows.len()
    }
}

pub(crate) fn extremes(column: &[f64], left: &[bool]) -> [f64; 2] {
    let values = column.iter().zip(left).filter(|(_, l)| **l).map(|(v, _)| *v);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    [low, high]
}

/// Ends of the range at which samples pile up: ten at least, and more than three times as many as on the next level. The top of a
/// sinusoid in coarse steps has 1/(√2 − 1) = 2.4 times as many as the step below it.
///
/// `q` are the positions of the joint. A torque that jumps to its end where the joint turns round is friction, which stays the
/// same until the next turn.
pub(crate) fn clipped(column: &[f64], q: &[f64], left: &[bool]) -> Option<Clip> {
    let mut sorted: Vec<f64> = column.iter().zip(left).filter(|(_, l)| **l).map(|(v, _)| *v).collect();
    sorted.sort_by(f64::total_cmp);
    let top = piled_up(sorted.iter().rev().copied());
    let bottom = piled_up(sorted.iter().copied());
    let noise = noise_of(column);
    let half = SETTINGS.data_quality.clipping_window / 2;
    let mean = |s: usize| {
        let (from, to) = (s.saturating_sub(half), (s + half + 1).min(column.len()));
        column[from..to].iter().sum::<f64>() / (to - from) as f64
    };
    let (mut levels, mut count) = (Vec::new(), 0);
    let mut rows = vec![false; column.len()];
    // Noise smooths steps; where rounding is all there is, the top of a wave is one step. Third differences of rounded values are
    // whole steps: the median of two steps, which a fast wave has, reads as noise of 0.66 of one.
    let coarse = step_of(column, left).filter(|step| noise <= *step);
    let natural = |level: &f64| turns_at(column, q, *level) || coarse.is_some_and(|step| beyond(column, *level) <= step);
    let (top, bottom) = (top.filter(|(l, _)| !natural(l)), bottom.filter(|(l, _)| !natural(l)));
    for (level, side, piled) in [top.map(|(l, c)| (l, 1.0, c)), bottom.map(|(l, c)| (l, -1.0, c))]
        .into_iter()
        .flatten()
    {
        levels.push(level);
        count += piled;
        // Within two standard deviations of the level, noise is cut off on one side. By the local mean: a choice by the sample's
        // own noise would move the mean of the rest.
        for s in 0..column.len() {
            rows[s] |= column[s] == level || side * (level - mean(s)) < 2.0 * noise;
        }
    }
    (count > 0).then_some(Clip { levels, count, rows })
}

/// How far a column would go beyond `level`, as a mean over the samples there, if every run at the level were the top of a
/// parabola through the samples around it.
///
/// A parabola that is cut off by E over a run of L samples lies `(13/3) E` below the level in the mean over the L samples before
/// it, and after it.
fn beyond(column: &[f64], level: f64) -> f64 {
    let (mut sum, mut all, mut s) = (0.0, 0, 0);
    while s < column.len() {
        if column[s] != level {
            s += 1;
            continue;
        }
        let end = (s..column.len()).find(|&e| column[e] != level).unwrap_or(column.len());
        let length = end - s;
        let mean = |around: std::ops::Range<usize>| {
            let count = around.len() as f64;
            column[around].iter().map(|v| (level - v).abs()).sum::<f64>() / count
        };
        let sides = [s.saturating_sub(length)..s, end..(end + length).min(column.len())];
        // A jump of friction on one side is no slope. A log that is all of one value is none that is cut off.
        let drop = sides.into_iter().filter(|r| !r.is_empty()).map(mean).reduce(f64::min);
        sum += length as f64 * drop.unwrap_or(0.0) * 3.0 / 13.0;
        all += length;
        s = end;
    }
    sum / all.max(1) as f64
}

/// Whether most of the samples at a level are in runs that last from one turn of the joint to the next, or in which it does not
/// move. Where a torque is cut off, a run may begin at a turn as well: there the acceleration is at its largest. But then it ends
/// before the next one.
fn turns_at(column: &[f64], q: &[f64], level: f64) -> bool {
    let direction = |s: usize| {
        let step = if s + 1 < q.len() { q[s + 1] - q[s] } else { 0.0 };
        if step == 0.0 { 0.0 } else { step.signum() }
    };
    let (mut natural, mut all, mut s) = (0, 0, 0);
    while s < column.len() {
        if column[s] != level {
            s += 1;
            continue;
        }
        let end = (s..column.len()).find(|&e| column[e] != level).unwrap_or(column.len());
        let moves = |d: &f64| *d != 0.0;
        let before = (0..s.saturating_sub(SETTINGS.data_quality.turning_samples))
            .rev()
            .map(direction)
            .find(moves);
        let first = (s..end).map(direction).find(moves);
        let last = (s..end)
            .rev()
            .skip(SETTINGS.data_quality.turning_samples)
            .map(direction)
            .find(moves)
            .or(first);
        let after = (end + SETTINGS.data_quality.turning_samples..column.len())
            .map(direction)
            .find(moves);
        // What was before the log began, or is after its end, is not known.
        let turns = |a: Option<f64>, b: Option<f64>| a.is_none() || b.is_none() || a != b;
        if first.is_none() || (before.is_some() || after.is_some()) && turns(before, first) && turns(last, after) {
            natural += end - s;
        }
        all += end - s;
        s = end;
    }
    2 * natural > all
}

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

/// White noise on a smooth signal, from the median of its third differences: √20 times the noise, 0.6745 of a normal deviate's
/// spread.
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
