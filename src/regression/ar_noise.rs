//! The noise floor: what the torque does from one period to the next, or, without periods, what is left at high frequency.

use super::dataset::Stretch;
use crate::preparation::rounded_alike;
use crate::regression::settings::SETTINGS;

/// Where a noise model is taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseSource {
    /// Scatter between periods: needs no model.
    Periods,
    /// The residual's own behaviour from sample to sample: weaker, because what the model lacks can pass for noise.
    Residual,
}

/// Noise on the torque of one joint: variance and correlation in time.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseModel {
    /// Where it is taken from.
    pub source: NoiseSource,
    /// Standard deviation of one measurement [N·m or N].
    pub std_dev: f64,
    /// Coefficients a of `e_t = Σ a_k e_{t−k} + w_t`; none for white noise.
    pub autoregression: Vec<f64>,
    /// Standard deviation of w for one measurement [N·m or N].
    pub innovation: f64,
    /// Degrees of freedom of the variance.
    pub degrees_of_freedom: f64,
}

impl NoiseModel {
    /// White noise of a standard deviation that nothing but the rows' weights is taken from.
    pub(crate) fn white(std_dev: f64) -> Self {
        Self {
            source: NoiseSource::Residual,
            std_dev,
            autoregression: Vec::new(),
            innovation: std_dev,
            degrees_of_freedom: 1.0,
        }
    }

    /// Of a joint without rows: nothing is weighed by it.
    pub(crate) fn absent(source: NoiseSource) -> Self {
        Self {
            source,
            std_dev: 1.0,
            autoregression: Vec::new(),
            innovation: 1.0,
            degrees_of_freedom: 0.0,
        }
    }

    /// Whether it is that of a joint without rows.
    pub fn is_absent(&self) -> bool {
        self.degrees_of_freedom == 0.0
    }

    /// From the deviations of every period from the mean of all, joint by joint. `None` for fewer than two periods.
    pub fn from_periods(stretches: &[Stretch], joint: usize) -> Option<Self> {
        Self::from_periods_and(stretches, joint, 0.0)
    }

    /// The same with errors beside that no period shows, as white noise of variance `hidden` for one measurement [(N·m)² or N²].
    pub(crate) fn from_periods_and(stretches: &[Stretch], joint: usize, hidden: f64) -> Option<Self> {
        let mut covariance = vec![0.0; SETTINGS.noise_terms + 1];
        let mut freedom = 0.0;
        let repeating: Vec<&Stretch> = stretches.iter().filter(|s| s.periods.len() >= 2).collect();
        for stretch in &repeating {
            let rows = stretch.usable[joint].iter().filter(|&&u| u).count() as f64;
            freedom += rows * (stretch.periods.len() - 1) as f64;
            for period in &stretch.periods {
                let deviation = deviation(stretch, period, joint);
                (0..=SETTINGS.noise_terms).for_each(|lag| covariance[lag] += lagged(&deviation, lag));
            }
        }
        if repeating.is_empty() {
            return None;
        }
        if freedom == 0.0 {
            let measured_elsewhere = stretches.iter().any(|s| s.has_rows(joint));
            return (!measured_elsewhere).then(|| Self::absent(NoiseSource::Periods));
        }
        covariance.iter_mut().for_each(|c| *c /= freedom);
        let own = covariance[0];
        let unseen = hidden + rounding(&repeating, joint, own);
        if unseen > SETTINGS.negligible_variance * own {
            covariance[0] += unseen;
        }
        let known = repeating.iter().all(|s| s.recorded.is_some());
        let floor = if known {
            SETTINGS.known_filter_floor
        } else {
            SETTINGS.whitening_floor
        };
        Some(Self::from_covariance(NoiseSource::Periods, &covariance, freedom, floor))
    }

    /// Levinson's recursion, the order chosen by the Bayesian information criterion, with a little white noise added (white-noise
    /// correction; Kay, Modern Spectral Estimation, 1988). Where a log was filtered before it was recorded its noise has next to
    /// no power, and no model of a few terms says how little: differences there would be magnified by orders of magnitude and
    /// taken for effects.
    fn from_covariance(source: NoiseSource, covariance: &[f64], freedom: f64, floor: f64) -> Self {
        let variance = covariance[0].max(f64::MIN_POSITIVE.sqrt());
        let floored = covariance[0].max(f64::MIN_POSITIVE) * (1.0 + floor);
        let r: Vec<f64> = std::iter::once(1.0)
            .chain(covariance[1..].iter().map(|c| c / floored))
            .collect();
        let mut best = (0.0, Vec::new(), 1.0);
        let (mut a, mut error): (Vec<f64>, f64) = (Vec::new(), 1.0);
        for order in 1..r.len() {
            let reflection = (r[order] - a.iter().enumerate().map(|(k, a)| a * r[order - 1 - k]).sum::<f64>()) / error;
            let reversed: Vec<f64> = a.iter().rev().copied().collect();
            a.iter_mut().zip(&reversed).for_each(|(a, b)| *a -= reflection * b);
            a.push(reflection);
            error *= 1.0 - reflection * reflection;
            if error <= 1e-9 {
                break;
            }
            let criterion = freedom * error.ln() + order as f64 * freedom.ln();
            if criterion < best.0 {
                best = (criterion, a.clone(), error);
            }
        }
        let (_, autoregression, share) = best;
        // Without terms nothing was added.
        let added = if autoregression.is_empty() {
            0.0
        } else {
            SETTINGS.whitening_floor
        };
        let innovation = (variance * (1.0 + added) * share).sqrt();
        Self {
            source,
            std_dev: variance.sqrt(),
            autoregression,
            innovation,
            degrees_of_freedom: freedom,
        }
    }

    /// Standard deviation of white noise that hides slow signals as much: what the whitening filter makes of a constant [N·m or
    /// N].
    pub fn slow_std_dev(&self) -> f64 {
        let gain = 1.0 - self.autoregression.iter().sum::<f64>();
        self.innovation / gain.abs().max(f64::EPSILON)
    }

    /// Rows whose whitened value needs no row that is left out.
    pub(crate) fn whitened_rows(&self, keep: &[bool], periodic: bool) -> Vec<bool> {
        let order = self.autoregression.len();
        let n = keep.len();
        (0..n)
            .map(|s| {
                (0..=order).all(|k| match s.checked_sub(k) {
                    Some(at) => keep[at],
                    None => periodic && keep[(s + n - k % n) % n],
                })
            })
            .collect()
    }

    /// `x` filtered to unit variance for a mean of `repetitions`; rows not in `rows` become zero.
    pub(crate) fn whiten(&self, x: &[f64], rows: &[bool], repetitions: usize) -> Vec<f64> {
        self.whitened(x, rows, repetitions).collect()
    }

    /// The same, one after the other.
    pub(crate) fn whitened<'a>(&'a self, x: &'a [f64], rows: &'a [bool], repetitions: usize) -> impl Iterator<Item = f64> + 'a {
        let (n, order) = (x.len(), self.autoregression.len());
        let scale = (repetitions as f64).sqrt() / self.innovation;
        let whitened = move |s: usize| {
            if !rows[s] {
                return 0.0;
            }
            let coefficients = self.autoregression.iter();
            let predicted: f64 = match s.checked_sub(order) {
                Some(first) => coefficients.zip(x[first..s].iter().rev()).map(|(a, x)| a * x).sum(),
                None => coefficients.enumerate().map(|(k, a)| a * x[(s + n - 1 - k) % n]).sum(),
            };
            (x[s] - predicted) * scale
        };
        (0..n).map(whitened)
    }
}

/// Variance, for one measurement, of the rounding of torques that the mean over periods keeps, given noise of variance `own`.
/// Without noise every period is rounded alike, by `d²/12` for steps d, and the mean over them as well; noise smooths the steps,
/// and of their variance `exp(−4π² σ²/d²)` remains (Widrow & Kollár, Quantization Noise, 2008).
///
/// A torque that stays within a step for some rows is off by the same all that time: those rows count as one, and white noise
/// that says as little has so many times the variance.
fn rounding(repeating: &[&Stretch], joint: usize, own: f64) -> f64 {
    let lasting = repeating.iter().map(|s| rows_of_a_step(s, joint)).fold(1.0, f64::max);
    let alike = |s: &&Stretch| s.repetitions() as f64 * rounded_alike(s.resolution[joint] * 12f64.sqrt(), own.sqrt());
    lasting * repeating.iter().map(alike).fold(0.0, f64::max)
}

/// Rows that follow each other with the same torque, in the mean over a period.
fn rows_of_a_step(stretch: &Stretch, joint: usize) -> f64 {
    let torque = &stretch.periods[0][joint];
    let changes = torque.windows(2).filter(|w| w[0] != w[1]).count();
    torque.len() as f64 / (changes + 1) as f64
}

/// Deviation of one period from the mean of all, zero where the row does not count.
pub(crate) fn deviation(stretch: &Stretch, period: &[Vec<f64>], joint: usize) -> Vec<f64> {
    let pairs = period[joint].iter().zip(&stretch.torque[joint]).zip(&stretch.usable[joint]);
    pairs
        .map(|((t, mean), &usable)| if usable { t - mean } else { 0.0 })
        .collect()
}

fn lagged(x: &[f64], lag: usize) -> f64 {
    x[lag.min(x.len())..].iter().zip(x).map(|(a, b)| a * b).sum()
}
