//! Averaging over periods, and what the scatter of the periods says about noise.

use super::log::Log;
use super::period::{at, repeating_stretch};
use super::spectrum::forward_of;
use crate::cancel::CancelFlag;
use rayon::prelude::*;
use std::borrow::Cow;

/// Where the whole periods lie in a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Periods {
    /// Length of a period (s).
    pub period_s: f64,
    /// Whole periods K.
    pub count: usize,
    /// Samples N that a period is divided into.
    pub samples: usize,
    /// Sample of the log at which the first whole period starts.
    pub first: usize,
    /// Period in samples of the log; need not be a whole number.
    pub lag: f64,
}

/// A period that is short of the log's end by no more than this fraction still counts: its last samples are left out of the mean.
const ALMOST_WHOLE: f64 = 0.01;

impl Periods {
    /// Whole periods of `period_s` in the stretch of `log` that repeats; `None` when there is none.
    pub(crate) fn find(log: &Log, period_s: f64, cancel: &CancelFlag) -> Option<Self> {
        let lag = period_s * log.rate_hz;
        let n = log.samples() as f64;
        if !(lag >= 8.0 && lag <= n * (1.0 + ALMOST_WHOLE)) {
            return None;
        }
        let stretch = repeating_stretch(log, lag, cancel);
        // A single period and a bit: nothing to compare, the log is taken from its start.
        let (first, length) = if n < 1.5 * lag {
            (0, n)
        } else {
            (stretch.start, stretch.len() as f64 + lag)
        };
        let count = (length / lag + ALMOST_WHOLE).floor() as usize;
        (count > 0).then_some(Self {
            period_s,
            count,
            samples: lag.round() as usize,
            first,
            lag,
        })
    }

    /// True when periods are a whole number of samples long: to within a thousandth of a sample over the whole log.
    fn aligned(&self) -> bool {
        (self.lag - self.samples as f64).abs() * (self.count as f64) < 1e-3
    }

    /// Position in the log, in samples, of sample `i` of period `k`.
    fn place(&self, k: usize, i: usize) -> f64 {
        if self.aligned() {
            return (self.first + k * self.samples + i) as f64;
        }
        self.first as f64 + (k as f64 + i as f64 / self.samples as f64) * self.lag
    }

    /// Whether each sample of each period is data (K × N, period after period).
    pub(crate) fn usable(&self, log: &Log) -> Vec<bool> {
        let n = log.samples();
        let whole = self.first..self.first + self.count * self.samples;
        if self.aligned() && whole.end <= n {
            return log.usable[whole].to_vec();
        }
        (0..self.count)
            .flat_map(|k| (0..self.samples).map(move |i| (k, i)))
            .map(|(k, i)| {
                let at = self.place(k, i) as usize;
                at < n && log.usable[at] && (self.aligned() || log.usable[(at + 1).min(n - 1)])
            })
            .collect()
    }

    /// A signal of the log, period after period: K × N.
    pub(crate) fn unfold<'x>(&self, x: &'x [f64]) -> Cow<'x, [f64]> {
        let whole = self.first..self.first + self.count * self.samples;
        if self.aligned() && whole.end <= x.len() {
            return Cow::Borrowed(&x[whole]);
        }
        let places = (0..self.count).flat_map(|k| (0..self.samples).map(move |i| (k, i)));
        places.map(|(k, i)| at(x, self.place(k, i))).collect()
    }

    /// Mean over the usable periods, for every sample of a period; the mean of all where none is usable.
    pub(crate) fn mean(&self, unfolded: &[f64], usable: &[bool]) -> Vec<f64> {
        let n = self.samples;
        let (mut sum, mut count, mut all) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for (period, usable) in unfolded.chunks_exact(n).zip(usable.chunks_exact(n)) {
            for i in 0..n {
                let used = f64::from(u8::from(usable[i]));
                sum[i] += used * period[i];
                count[i] += used;
                all[i] += period[i];
            }
        }
        let mean = |i: usize| {
            if count[i] > 0.0 {
                sum[i] / count[i]
            } else {
                all[i] / self.count as f64
            }
        };
        (0..n).map(mean).collect()
    }

    /// Sum of the squares of the usable samples' deviations from `mean`.
    pub(crate) fn scatter_square(&self, unfolded: &[f64], mean: &[f64], usable: &[bool]) -> f64 {
        let n = self.samples;
        let periods = unfolded.chunks_exact(n).zip(usable.chunks_exact(n));
        let square = |((v, m), used): ((&f64, &f64), &bool)| if *used { (v - m).powi(2) } else { 0.0 };
        periods
            .map(|(period, usable)| period.iter().zip(mean).zip(usable).map(square).sum::<f64>())
            .sum()
    }
}

/// Variance of the mean of K ≥ 2 periods that each Fourier line 0 … N/2 carries, `E|X_l|²/N`, by the scatter of the `unfolded`
/// periods about their `mean`: for white noise the constant `σ²/K`. Unusable samples count as equal to the mean.
pub(crate) fn mean_spectrum(periods: &Periods, unfolded: &[f64], mean: &[f64], usable: &[bool], cancel: &CancelFlag) -> Vec<f64> {
    let (k, n) = (periods.count, periods.samples);
    let mut lines = vec![0.0; n / 2 + 1];
    for (period, usable) in unfolded.chunks_exact(n).zip(usable.chunks_exact(n)) {
        cancel.leave_if_set();
        let values = period.iter().zip(mean).zip(usable);
        let deviation = values.map(|((v, m), &used)| if used { v - m } else { 0.0 }).collect();
        lines
            .iter_mut()
            .zip(forward_of(deviation))
            .for_each(|(sum, x)| *sum += x.norm_sqr());
    }
    // Mean over periods with K − 1 degrees of freedom is the noise of one period; the average has 1/K of it.
    let scale = 1.0 / ((k - 1) as f64 * k as f64 * n as f64);
    lines.iter_mut().for_each(|v| *v *= scale);
    lines
}

/// Torques of the single periods, and the noise that their scatter shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// K.
    pub periods: usize,
    /// Per joint, K × N torques, period after period.
    pub torque: Vec<Vec<f64>>,
    /// Whether each of the K × N samples is data.
    pub usable: Vec<bool>,
    /// Standard deviation of one torque sample about the mean of its periods, per joint [N m or N].
    pub std_dev: Vec<f64>,
    /// Variance of the *averaged* torque that each Fourier line 0 … N/2 carries, per joint, `E|X_l|²/N`: for white noise the
    /// constant `std_dev²/K`.
    pub spectrum: Vec<Vec<f64>>,
}

impl Scatter {
    /// From torques unfolded into K ≥ 2 periods and their means. Unusable samples count as equal to the mean.
    pub(crate) fn new(
        periods: &Periods,
        torque: Vec<Vec<f64>>,
        mean: &[Vec<f64>],
        usable: Vec<bool>,
        cancel: &CancelFlag,
    ) -> Self {
        let n = periods.samples;
        let of_joint = |(tau, mean): (&Vec<f64>, &Vec<f64>)| {
            let used = usable.iter().filter(|&&u| u).count() as f64;
            // Every sample of the period spends one degree of freedom on its mean.
            let freedom = (used - n as f64).max(1.0);
            let std_dev = (periods.scatter_square(tau, mean, &usable) / freedom).sqrt();
            let lines = mean_spectrum(periods, tau, mean, &usable, cancel);
            (std_dev, lines)
        };
        let (std_dev, spectrum) = torque.par_iter().zip(mean).map(of_joint).unzip();
        Self {
            periods: periods.count,
            torque,
            usable,
            std_dev,
            spectrum,
        }
    }
}
