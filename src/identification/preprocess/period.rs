//! Finding the period of a log, and the stretch of it in which the robot really repeats.

use super::spectrum::median;
use crate::identification::Log;
use rayon::prelude::*;
use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;

/// A lag is a candidate when the mean square difference between the record and itself that much later is below this fraction of
/// what it is for unrelated stretches: a robot that waits, or settles, for a tenth of the record passes.
const CANDIDATE: f64 = 0.1;
/// It is the period when the *median* square difference is below this fraction: most of the record repeats to 3 % of its travel.
const REPEATS: f64 = 1e-3;
/// Before the first period the difference must have risen beyond this fraction: close neighbours in time always resemble.
const LEFT: f64 = 0.3;

/// The period of the positions (s), from their autocorrelation: `None` when nothing repeats at least twice.
///
/// `d(L) = Σ_j mean_t (q_j(t + L) − q_j(t))² / 2 var q_j`, averaged over the joints that move; the period is the first lag, after d
/// has risen, where it falls to a minimum near zero. The lag of the last full repetition, divided by their number, refines it to a
/// fraction of a sample.
///
/// The stretch that really repeats is then looked at alone, because a robot that starts late pulls the minimum aside, and a period
/// within a fiftieth of a sample of a whole number of samples is taken to be that: a controller counts samples.
pub fn detect_period(log: &Log) -> Option<f64> {
    let rough = period_in_samples(log)?;
    let stretch = repeating_stretch(log, rough);
    let end = (stretch.end + rough.ceil() as usize).min(log.samples());
    let whole_stretch = stretch.start > 0 || end < log.samples();
    let lag = if whole_stretch {
        period_in_samples(&log.slice(stretch.start..end)).unwrap_or(rough)
    } else {
        rough
    };
    let lag = if (lag - lag.round()).abs() < 0.02 { lag.round() } else { lag };
    Some(lag / log.rate_hz)
}

fn period_in_samples(log: &Log) -> Option<f64> {
    let n = log.samples();
    let difference = lag_difference(log)?;
    // The record may end a few samples short of the second period.
    let limit = (n / 2 + n / 100 + 1).min(difference.len());
    let left = (1..limit).find(|&l| difference[l] > LEFT)?;
    let candidate = (left..limit).find(|&l| {
        let d = difference[l];
        let lowest = d < CANDIDATE && d <= difference[l - 1] && difference.get(l + 1).is_none_or(|&next| d <= next);
        lowest && mostly_repeats(log, l)
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

/// Whether the median of `|q(t + L) − q(t)|²` over time, all joints together, is next to nothing beside the variance.
fn mostly_repeats(log: &Log, lag: usize) -> bool {
    let n = log.samples();
    let mut squares = vec![0.0; n - lag];
    let mut variance = 0.0;
    for q in &log.q {
        let mean = q.iter().sum::<f64>() / n as f64;
        variance += q.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n as f64;
        squares
            .iter_mut()
            .enumerate()
            .for_each(|(s, d)| *d += (q[s + lag] - q[s]).powi(2));
    }
    median(squares) < REPEATS * 2.0 * variance
}

/// d(L) for all lags up to N − 1; `None` when nothing moves.
fn lag_difference(log: &Log) -> Option<Vec<f64>> {
    let n = log.samples();
    let padded = (2 * n).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (planner.plan_fft_forward(padded), planner.plan_fft_inverse(padded));
    let of_joint = |q: &Vec<f64>| {
        let mean = q.iter().sum::<f64>() / n as f64;
        let variance = q.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n as f64;
        if variance < NO_MOTION * NO_MOTION {
            return None;
        }
        let mut x: Vec<f64> = q
            .iter()
            .map(|v| v - mean)
            .chain(std::iter::repeat_n(0.0, padded - n))
            .collect();
        let mut squares = vec![0.0; n + 1];
        (0..n).for_each(|i| squares[i + 1] = squares[i] + x[i] * x[i]);
        let mut lines = forward.make_output_vec();
        forward.process(&mut x, &mut lines).expect("lengths come from the plan");
        lines.iter_mut().for_each(|z| *z = Complex64::new(z.norm_sqr(), 0.0));
        inverse.process(&mut lines, &mut x).expect("lengths come from the plan");
        let difference = |lag: usize| {
            let correlation = x[lag] / padded as f64;
            let difference = squares[n - lag] + (squares[n] - squares[lag]) - 2.0 * correlation;
            difference / ((n - lag) as f64 * 2.0 * variance)
        };
        Some((0..n).map(difference).collect::<Vec<f64>>())
    };
    let moving: Vec<Vec<f64>> = log.q.par_iter().filter_map(of_joint).collect();
    let mean = |lag: usize| moving.iter().map(|d| d[lag]).sum::<f64>() / moving.len() as f64;
    (!moving.is_empty()).then(|| (0..n).map(mean).collect())
}

/// Root mean square [rad or m] below which a joint stands still: encoder noise of a coarse encoder.
const NO_MOTION: f64 = 1e-3;

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

/// The longest stretch of samples in which positions repeat after `lag` samples: `[first, last)` of samples s with q(s) ≈ q(s + lag).
///
/// A robot that starts late, a transient before the motion has settled, or an early end show as samples that do not repeat. The
/// difference is smoothed over a hundredth of the period; it may be four times its median (noise is steady, a transient is not),
/// and in any case a thousandth of the joint's travel, which is below what tracking errors do to the torque.
pub(super) fn repeating_stretch(log: &Log, lag: f64) -> std::ops::Range<usize> {
    let n = log.samples();
    let whole = lag.round() as usize;
    if whole >= n {
        return 0..0;
    }
    let count = n - whole;
    let half = (whole / 200).max(2);
    let of_joint = |q: &Vec<f64>| -> Vec<bool> {
        let (low, high) = q
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        let squares: Vec<f64> = (0..count).map(|s| (at(q, s as f64 + lag) - q[s]).powi(2)).collect();
        let smooth = super::spectrum::smoothed(&squares, half);
        let allowed = (16.0 * median(smooth.clone())).max((1e-3 * (high - low)).powi(2));
        smooth.iter().map(|&d| d <= allowed).collect()
    };
    let joints: Vec<Vec<bool>> = log.q.par_iter().map(of_joint).collect();
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

/// Value between samples, cubic through four of them (linear at the ends).
pub(super) fn at(x: &[f64], position: f64) -> f64 {
    let i = (position.floor().max(0.0) as usize).min(x.len() - 1);
    let f = position - i as f64;
    if f == 0.0 || i + 1 >= x.len() {
        return x[i];
    }
    if i == 0 || i + 2 >= x.len() {
        return x[i] + f * (x[i + 1] - x[i]);
    }
    let (a, b, c, d) = (x[i - 1], x[i], x[i + 1], x[i + 2]);
    b + 0.5 * f * (c - a + f * (2.0 * a - 5.0 * b + 4.0 * c - d + f * (3.0 * (b - c) + d - a)))
}
