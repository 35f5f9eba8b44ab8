//! Finding the period of a log, and the stretch of it in which the robot really repeats.

use super::autocorrelation::{lag_difference, moments};
use super::log::Log;
use super::spectrum::{median, smoothed};
use crate::cancel::CancelFlag;
use rayon::prelude::*;

/// A lag is a candidate when the mean square difference between the record and itself that much later is below this fraction of
/// what it is for unrelated stretches: a robot that waits, or settles, for a tenth of the record passes.
const CANDIDATE: f64 = 0.1;

/// It is the period when the *median* square difference is below this fraction: most of the record repeats to 3 % of its travel.
const REPEATS: f64 = 1e-3;

/// Before the first period the difference must have risen beyond this fraction: close neighbours in time always resemble.
const LEFT: f64 = 0.3;

/// The period of the positions (s), from their autocorrelation: `None` when nothing repeats at least twice.
///
/// `d(L) = Σ_j mean_t (q_j(t + L) − q_j(t))² / 2 var q_j`, averaged over the joints that move; the period is the first lag, after
/// d has risen, where it falls to a minimum near zero. The lag of the last full repetition, divided by their number, refines it
/// to a fraction of a sample.
///
/// The stretch that really repeats is then looked at alone, because a robot that starts late pulls the minimum aside, and a
/// period within a fiftieth of a sample of a whole number of samples is taken to be that: a controller counts samples.
pub fn detect_period(log: &Log) -> Option<f64> {
    detect_period_until(log, &CancelFlag::default())
}

/// The same, left when `cancel` is set, as by [`CancelFlag::leave_if_set`].
pub(crate) fn detect_period_until(log: &Log, cancel: &CancelFlag) -> Option<f64> {
    let rough = period_in_samples(log, cancel)?;
    let stretch = repeating_stretch(log, rough, cancel);
    let end = (stretch.end + rough.ceil() as usize).min(log.samples());
    let whole_stretch = stretch.start > 0 || end < log.samples();
    let lag = if whole_stretch {
        period_in_samples(&log.slice(stretch.start..end), cancel).unwrap_or(rough)
    } else {
        rough
    };
    let lag = if (lag - lag.round()).abs() < 0.02 { lag.round() } else { lag };
    Some(lag / log.rate_hz)
}

fn period_in_samples(log: &Log, cancel: &CancelFlag) -> Option<f64> {
    let n = log.samples();
    let difference = lag_difference(log, cancel)?;
    // The record may end a few samples short of the second period.
    let limit = (n / 2 + n / 100 + 1).min(difference.len());
    let left = (1..limit).find(|&l| difference[l] > LEFT)?;
    let candidate = (left..limit).find(|&l| {
        let d = difference[l];
        let lowest = d < CANDIDATE && d <= difference[l - 1] && difference.get(l + 1).is_none_or(|&next| d <= next);
        lowest && mostly_repeats(log, l, cancel)
    })?;
    let mut lag = refine(&difference, candidate);
    for count in 2.. {
        // Beyond three quarters of the record the overlap is too short to weigh.
        let guess = lag * f64::from(count);
        if guess > 0.75 * n as f64 || guess as usize + 2 >= difference.len() {
            break;
        }
        let around = (guess.round() as usize).saturating_sub(2)..=guess.round() as usize + 2;
        let best = around.min_by(|&a, &b| difference[a].total_cmp(&difference[b]))?;
        lag = refine(&difference, best) / f64::from(count);
    }
    Some(lag)
}

/// Whether the median of `|q(t + L) − q(t)|²` over time, all joints together, is next to nothing beside the variance: whether
/// more than half of the samples are below that.
fn mostly_repeats(log: &Log, lag: usize, cancel: &CancelFlag) -> bool {
    /// Samples of all joints that stay in the cache together.
    const STRETCH: usize = 1024;
    let count = log.samples() - lag;
    let variance: f64 = log.q.iter().map(|q| moments(q).1).sum();
    let most = REPEATS * 2.0 * variance;
    let starts: Vec<usize> = (0..count).step_by(STRETCH).collect();
    let repeating = |&start: &usize| {
        cancel.leave_if_set();
        let mut squares = [0.0; STRETCH];
        let squares = &mut squares[..STRETCH.min(count - start)];
        for q in &log.q {
            let later = q[start + lag..].iter().zip(&q[start..]);
            squares.iter_mut().zip(later).for_each(|(d, (b, a))| *d += (b - a).powi(2));
        }
        squares.iter().filter(|d| **d < most).count()
    };
    starts.par_iter().map(repeating).sum::<usize>() > count / 2
}

/// Whether the log repeats after `period_s`; `None` where it is too short to tell: less than half of a second period.
pub(crate) fn repeats_with(log: &Log, period_s: f64, cancel: &CancelFlag) -> Option<bool> {
    let lag = period_s * log.rate_hz;
    if !(lag >= 1.0 && 1.5 * lag <= log.samples() as f64) {
        return None;
    }
    Some(mostly_repeats(log, lag.round() as usize, cancel))
}

/// Minimum of the parabola through a point and its neighbours.
fn refine(d: &[f64], at: usize) -> f64 {
    if at == 0 || at + 1 >= d.len() {
        return at as f64;
    }
    let (a, b, c) = (d[at - 1], d[at], d[at + 1]);
    let curvature = a - 2.0 * b + c;
    let shift = if curvature > 0.0 {
        (0.5 * (a - c) / curvature).clamp(-0.5, 0.5)
    } else {
        0.0
    };
    at as f64 + shift
}

/// The longest stretch of samples in which positions repeat after `lag` samples: `[first, last)` of samples s with q(s) ≈ q(s +
/// lag).
///
/// A robot that starts late, a transient before the motion has settled, or an early end show as samples that do not repeat. The
/// difference is smoothed over a hundredth of the period; it may be four times its median (noise is steady, a transient is not),
/// and in any case a thousandth of the joint's travel, which is below what tracking errors do to the torque.
pub(crate) fn repeating_stretch(log: &Log, lag: f64, cancel: &CancelFlag) -> std::ops::Range<usize> {
    let n = log.samples();
    let whole = lag.round() as usize;
    if whole >= n {
        return 0..0;
    }
    let count = n - whole;
    let half = (whole / 200).max(2);
    let of_joint = |q: &Vec<f64>| -> Option<Vec<bool>> {
        cancel.leave_if_set();
        let (low, high) = q
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        let smooth = smoothed(&differences(q, lag, count), half);
        cancel.leave_if_set();
        let always = (1e-3 * (high - low)).powi(2);
        // Where that allows all of them the median has no say, and nothing breaks the stretch.
        if smooth.iter().all(|&d| d <= always) {
            return None;
        }
        let allowed = (16.0 * median(smooth.clone())).max(always);
        Some(smooth.iter().map(|&d| d <= allowed).collect())
    };
    let joints: Vec<Vec<bool>> = log.q.par_iter().filter_map(of_joint).collect();
    if joints.is_empty() {
        return 0..count;
    }
    let agrees = |s: usize| joints.iter().all(|joint| joint[s]);
    let (mut best, mut start) = (0..0, 0);
    for s in 0..=count {
        if s == count || !agrees(s) {
            if s - start > best.len() {
                best = start..s;
            }
            start = s + 1;
        }
    }
    best
}

/// `(q(s + lag) − q(s))²` for the first `count` samples s.
fn differences(q: &[f64], lag: f64, count: usize) -> Vec<f64> {
    let (whole, part) = (lag as usize, lag.fract());
    if part == 0.0 {
        let later = q[whole..].iter().zip(q);
        return later.take(count).map(|(b, a)| (b - a).powi(2)).collect();
    }
    // Four neighbours at the same place between them, but for the last samples.
    let inner = if whole > 0 {
        q.len().saturating_sub(whole + 2).min(count)
    } else {
        0
    };
    let mut squares = Vec::with_capacity(count);
    let neighbours = q[whole.saturating_sub(1)..].windows(4).zip(q).take(inner);
    squares.extend(neighbours.map(|(x, &here)| (cubic(x[0], x[1], x[2], x[3], part) - here).powi(2)));
    squares.extend((inner..count).map(|s| (at(q, s as f64 + lag) - q[s]).powi(2)));
    squares
}

/// Value between samples, cubic through four of them (linear at the ends).
pub(crate) fn at(x: &[f64], position: f64) -> f64 {
    let i = (position as usize).min(x.len() - 1);
    let f = position - i as f64;
    if f == 0.0 || i + 1 >= x.len() {
        return x[i];
    }
    if i == 0 || i + 2 >= x.len() {
        return x[i] + f * (x[i + 1] - x[i]);
    }
    cubic(x[i - 1], x[i], x[i + 1], x[i + 2], f)
}

/// Value at the fraction `f` of the way from b to c of four values in succession.
fn cubic(a: f64, b: f64, c: f64, d: f64, f: f64) -> f64 {
    b + 0.5 * f * (c - a + f * (2.0 * a - 5.0 * b + 4.0 * c - d + f * (3.0 * (b - c) + d - a)))
}
