//! The power density of the noise, and the filters that it goes with.

use crate::diagnosis::golden_section::golden_section;
use crate::diagnosis::settings::SETTINGS;
use crate::preparation::spectrum::forward_of;
use crate::regression::{Phase, RecordedFilter, SampledFilter, Stretch, deviation};
use std::f64::consts::{PI, TAU};

/// Power of the noise of every joint in bands of frequency, by what the periods deviate from their mean.
pub(super) struct NoiseDensity {
    /// Samples per second.
    rate_hz: f64,
    /// Rows per second, each the mean of so many samples.
    rows_hz: f64,
    /// Middle of every band (Hz).
    frequencies: Vec<f64>,
    /// Per joint and band, mean of `|X_l|²`.
    power: Vec<Vec<f64>>,
    /// Lines times periods that a band is the mean of: half its degrees of freedom.
    weight: f64,
}

/// A filter, held against the density.
pub(super) struct Fit {
    pub filter: RecordedFilter,
    /// Whittle's deviance from the density as it is.
    pub deviance: f64,
    /// Per band, on the joint where it is largest: near the mean square of `x − 1`, x the ratio of the two densities.
    pub misfit: f64,
}

impl NoiseDensity {
    /// Of a stretch with two periods or more.
    pub fn new(stretch: &Stretch) -> Self {
        let rows = stretch.rows();
        let rows_hz = rows as f64 / (stretch.motion.samples() as f64 * stretch.interval);
        let lines = rows / 2;
        let width = lines.div_ceil(SETTINGS.recorded_filter.bands).max(1);
        let count = (lines / width).max(1);
        let of_joint = |j: usize| {
            let mut bands = vec![0.0; count];
            for period in &stretch.periods {
                let spectrum = forward_of(tapered(deviation(stretch, period, j)));
                // The first line is a level of its own in every period.
                for (band, lines) in bands.iter_mut().zip(spectrum[1..].chunks(width)) {
                    *band += lines.iter().map(|x| x.norm_sqr()).sum::<f64>() / lines.len() as f64;
                }
            }
            bands
        };
        let joints = (0..stretch.joints()).filter(|&j| stretch.has_rows(j));
        let middle = |b: usize| (1.0 + (b as f64 + 0.5) * width as f64) * rows_hz / rows as f64;
        Self {
            rate_hz: 1.0 / stretch.interval,
            rows_hz,
            frequencies: (0..count).map(middle).collect(),
            power: joints.map(of_joint).filter_map(raised).collect(),
            weight: (width * (stretch.periods.len() - 1)) as f64,
        }
    }

    /// Of a known density: bands of `weight` lines each, with these middles (Hz).
    pub(super) fn of_power(rate_hz: f64, frequencies: Vec<f64>, power: Vec<Vec<f64>>, weight: f64) -> Self {
        Self {
            rate_hz,
            rows_hz: rate_hz,
            frequencies,
            power: power.into_iter().filter_map(raised).collect(),
            weight,
        }
    }

    /// Twice Whittle's negative log likelihood of noise behind `filter`, less a constant; and the misfit, as of a [`Fit`]. The
    /// noise is white but for steps that were not predicted right, whose density falls with the square of the frequency and is
    /// that of the noise at `steps_hz`; white noise is added behind the filter.
    pub(super) fn cost(&self, filter: Option<&SampledFilter>, steps_hz: f64, added: f64) -> (f64, f64) {
        let through = |f: f64| filter.map_or(1.0, |filter| filter.density(f));
        let unseen = if filter.is_some() {
            SETTINGS.recorded_filter.unseen
        } else {
            0.0
        };
        let misfits = self.misfits(&|f| through(f) * (1.0 + (steps_hz / f).powi(2)) + added + unseen);
        let bands = self.frequencies.len() as f64;
        let level: f64 = self.power.iter().map(|p| p.iter().map(|v| v.ln()).sum::<f64>() / bands).sum();
        let cost = self.deviance(&misfits) + 2.0 * self.weight * bands * level;
        (cost, misfits.into_iter().fold(0.0, f64::max))
    }

    /// Lines times periods of a band: the misfit of the right density is one over it by chance.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// Deviance of white noise.
    pub fn white(&self) -> f64 {
        self.deviance(&self.misfits(&|f| self.mean(f)))
    }

    /// Per joint, the mean over the bands of `2 (x − ln x − 1)` for the ratio x of the power to a shape g, at the level that
    /// makes the mean of x one.
    fn misfits(&self, shape: &dyn Fn(f64) -> f64) -> Vec<f64> {
        let g: Vec<f64> = self.frequencies.iter().map(|f| shape(*f)).collect();
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / g.len() as f64;
        let of_joint = |power: &Vec<f64>| {
            let ratios = || power.iter().zip(&g).map(|(p, g)| p / g);
            2.0 * (mean(&mut ratios()).ln() - mean(&mut ratios().map(f64::ln)))
        };
        self.power.iter().map(of_joint).collect()
    }

    fn deviance(&self, misfits: &[f64]) -> f64 {
        self.weight * self.frequencies.len() as f64 * misfits.iter().sum::<f64>()
    }

    /// Power that the mean over the samples of a row leaves of a wave: `(sin(m x) / (m sin x))²`, `x = π f/f_s`.
    fn mean(&self, frequency_hz: f64) -> f64 {
        let m = self.rate_hz / self.rows_hz;
        let x = PI * frequency_hz / self.rate_hz;
        ((m * x).sin() / (m * x.sin())).powi(2)
    }

    /// The cut-off at which noise that is white but for a filter of this kind, and for white noise added behind it, fits best.
    pub fn best(&self, order: usize, phase: Phase) -> Option<Fit> {
        let settings = SETTINGS.recorded_filter;
        let highest = settings.highest * self.rows_hz / 2.0;
        let lowest = self.frequencies[0].max(settings.lowest * self.rows_hz);
        if lowest >= highest {
            return None;
        }
        let at = |x: f64| RecordedFilter {
            order,
            cutoff_hz: x.exp(),
            rate_hz: self.rate_hz,
            phase,
        };
        let misfits = |x: f64, added: f64| -> Option<Vec<f64>> {
            let filter = at(x).made()?;
            Some(self.misfits(&|f| filter.density(f) * self.mean(f) + added + settings.unseen))
        };
        let likelihood = |x: f64, added: f64| misfits(x, added).map_or(f64::NEG_INFINITY, |m| -self.deviance(&m));
        let last = settings.cutoffs - 1;
        let place = |i: usize| lowest.ln() + (highest / lowest).ln() * i as f64 / last as f64;
        let places = (0..=last).flat_map(|i| settings.added.map(|added| (i, added)));
        let tried = places.map(|(i, added)| (likelihood(place(i), added), i, added));
        let (_, i, added) = tried.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let around = [i.saturating_sub(1), (i + 1).min(last)].map(place);
        let x = golden_section(|x| likelihood(x, added), around, settings.refined);
        let misfits = misfits(x, added)?;
        Some(Fit {
            filter: at(x),
            deviance: self.deviance(&misfits),
            misfit: misfits.into_iter().fold(0.0, f64::max),
        })
    }
}

/// Power with a little of its largest added, as to the shapes that it is held against: what is a thousandth of the noise and less
/// comes from anywhere. `None` without power.
fn raised(mut power: Vec<f64>) -> Option<Vec<f64>> {
    let largest = power.iter().copied().fold(0.0, f64::max);
    power.iter_mut().for_each(|p| *p += SETTINGS.recorded_filter.unseen * largest);
    (largest > 0.0 && largest.is_finite()).then_some(power)
}

/// Hann's window: a period is a piece of noise that does not repeat, and the power behind a steep filter would be what leaks
/// there from before it.
pub(super) fn tapered(mut x: Vec<f64>) -> Vec<f64> {
    let n = x.len() as f64;
    let window = |s: usize| 0.5 - 0.5 * (TAU * (s as f64 + 0.5) / n).cos();
    x.iter_mut().enumerate().for_each(|(s, v)| *v *= window(s));
    x
}
