//! How much a record differs from itself some time later.

use super::log::Log;
use crate::cancel::CancelFlag;
use rayon::prelude::*;
use realfft::num_complex::Complex64;
use realfft::{RealFftPlanner, RealToComplex};

/// Root mean square [rad or m] below which a joint stands still: encoder noise of a coarse encoder.
pub(crate) const NO_MOTION: f64 = 1e-3;

/// Mean and variance.
pub(crate) fn moments(q: &[f64]) -> (f64, f64) {
    let mean = q.iter().sum::<f64>() / q.len() as f64;
    (mean, q.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / q.len() as f64)
}

/// `d(L) = Σ_j mean_t (q_j(t + L) − q_j(t))² / 2 var q_j`, averaged over the joints that move, for all lags up to three quarters
/// of the record and a few more; `None` when nothing moves.
///
/// The sum over joints is taken before the transform back. Zeros behind the record keep its end from meeting its start at any of
/// those lags.
pub(crate) fn lag_difference(log: &Log, cancel: &CancelFlag) -> Option<Vec<f64>> {
    let n = log.samples();
    let lags = n.min(3 * n / 4 + 5);
    let moving: Vec<Moving> = log.q.par_iter().filter_map(|q| Moving::from_positions(q)).collect();
    if moving.is_empty() {
        return None;
    }
    let length = smooth_length(n + lags);
    let forward = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    // Always the same joints together, so that sums do not depend on the number of threads.
    let spectra: Vec<Vec<f64>> = moving
        .par_chunks(2)
        .map(|pair| power(pair, length, &*forward, cancel))
        .collect();
    let mut lines: Vec<Complex64> = (0..=length / 2)
        .map(|l| Complex64::new(spectra.iter().map(|power| power[l]).sum(), 0.0))
        .collect();
    drop(spectra);
    cancel.leave_if_set();
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(length);
    let mut correlation = inverse.make_output_vec();
    inverse
        .process(&mut lines, &mut correlation)
        .expect("lengths come from the plan");
    cancel.leave_if_set();
    let mut squares = Vec::with_capacity(n + 1);
    squares.push(0.0);
    let mut sum = 0.0;
    squares.extend((0..n).map(|s| {
        sum += moving.iter().map(|joint| joint.at(s).powi(2)).sum::<f64>();
        sum
    }));
    let difference = |lag: usize| {
        let difference = squares[n - lag] + (squares[n] - squares[lag]) - 2.0 * correlation[lag] / length as f64;
        difference / ((n - lag) as f64 * 2.0 * moving.len() as f64)
    };
    Some((0..lags).map(difference).collect())
}

/// Positions of a joint that moves, to be seen as having mean zero and variance one.
struct Moving<'a> {
    q: &'a [f64],
    mean: f64,
    per_std: f64,
}

impl<'a> Moving<'a> {
    fn from_positions(q: &'a [f64]) -> Option<Self> {
        let (mean, variance) = moments(q);
        (variance >= NO_MOTION * NO_MOTION).then(|| Self {
            q,
            mean,
            per_std: 1.0 / variance.sqrt(),
        })
    }

    fn at(&self, s: usize) -> f64 {
        (self.q[s] - self.mean) * self.per_std
    }
}

/// `Σ |X_l|²` of some joints over a record of `length`, zeros behind theirs.
fn power(joints: &[Moving], length: usize, forward: &dyn RealToComplex<f64>, cancel: &CancelFlag) -> Vec<f64> {
    let (mut x, mut lines, mut scratch) = (
        forward.make_input_vec(),
        forward.make_output_vec(),
        forward.make_scratch_vec(),
    );
    let mut power = vec![0.0; length / 2 + 1];
    for joint in joints {
        cancel.leave_if_set();
        let n = joint.q.len();
        x[..n].iter_mut().enumerate().for_each(|(s, v)| *v = joint.at(s));
        x[n..].fill(0.0);
        forward
            .process_with_scratch(&mut x, &mut lines, &mut scratch)
            .expect("lengths come from the plan");
        power.iter_mut().zip(&lines).for_each(|(sum, x)| *sum += x.norm_sqr());
    }
    power
}

/// The least even number from `least` on without prime factors beyond five: transforms of such lengths are fast.
fn smooth_length(least: usize) -> usize {
    let rest = |mut n: usize, factor: usize| {
        while n.is_multiple_of(factor) {
            n /= factor;
        }
        n
    };
    let is_smooth = |&n: &usize| n.is_multiple_of(2) && [2, 3, 5].into_iter().fold(n, rest) == 1;
    (least.max(2)..).find(is_smooth).expect("powers of two have no end")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_differences_are_those_of_their_definition() {
        let q: Vec<Vec<f64>> = (0..5)
            .map(|j| {
                let wave = |t: usize| (0.13 * (j + 1) as f64 * t as f64).sin() + 1e-3 * (t * t) as f64 % 0.7 + j as f64;
                (0..203).map(|t| if j == 3 { 1.0 } else { wave(t) }).collect()
            })
            .collect();
        let log = Log {
            name: String::new(),
            rate_hz: 1.0,
            start_s: 0.0,
            tau: q.clone(),
            qd: None,
            usable: vec![true; 203],
            channels: Vec::new(),
            q,
        };
        let found = lag_difference(&log, &CancelFlag::default()).unwrap();
        assert_eq!(found.len(), 157);
        let by_definition = |lag: usize| {
            let of = |q: &Vec<f64>| {
                let square: f64 = q[lag..].iter().zip(q).map(|(b, a)| (b - a).powi(2)).sum();
                square / ((q.len() - lag) as f64 * 2.0 * moments(q).1)
            };
            let moving = [0, 1, 2, 4].map(|j| of(&log.q[j]));
            moving.iter().sum::<f64>() / 4.0
        };
        for (lag, d) in found.iter().enumerate() {
            assert!((d - by_definition(lag)).abs() < 1e-12, "lag {lag}: {d}");
        }
    }

    #[test]
    fn val_lengths_have_small_factors() {
        assert_eq!(
            [1, 3, 7, 11, 280_005, 320_001].map(smooth_length),
            [2, 4, 8, 12, 281_250, 324_000]
        );
    }
}
