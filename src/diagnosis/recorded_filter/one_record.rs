//! The noise of a log that does not repeat, and the filters that it goes with.
//!
//! No period shows it there: it is what the declared model leaves of the torque as it was recorded, above the frequencies that
//! the rows are made of. The steps of Coulomb friction stand out there as well. So a filter is tried on both: the prediction
//! goes through it, and what is left must be white noise behind the same filter.

use super::noise_density::{NoiseDensity, tapered};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::Motions;
use crate::preparation::spectrum::forward_of;
use crate::regression::{AugmentedModel, Phase, RecordedFilter, SampledFilter, Stretch};
use rayon::prelude::*;
use realfft::num_complex::Complex64;

/// Fourier lines of the torques of one record, measured and predicted.
pub(super) struct OneRecord {
    /// Samples per second.
    rate_hz: f64,
    /// From one line to the next (Hz).
    step_hz: f64,
    /// The first line that is used.
    first: usize,
    /// Lines of a band.
    width: usize,
    /// Per joint with a torque: measured and predicted.
    lines: Vec<[Vec<Complex64>; 2]>,
}

/// A filter, with the likelihood of the record behind it.
pub(super) struct Likely {
    pub filter: RecordedFilter,
    /// Twice the negative log likelihood, less a constant.
    pub cost: f64,
    /// As of the fits to the noise of periods.
    pub misfit: f64,
    /// Whether the cut-off lies among the frequencies that are looked at.
    pub in_sight: bool,
}

impl OneRecord {
    /// Of a stretch that was prepared without periods and behind a filter, beside a model fitted to it.
    pub fn new(stretch: &Stretch, model: &AugmentedModel) -> Option<Self> {
        let source = stretch.source.as_ref()?;
        let samples = source.samples();
        let step_hz = source.rate_hz / samples as f64;
        let first = ((SETTINGS.recorded_filter.beyond_rows * source.band_hz()? / step_hz) as usize).max(1);
        let end = (samples / 2).min((SETTINGS.recorded_filter.sight * first as f64) as usize);
        let width = end.checked_sub(first)? / SETTINGS.recorded_filter.bands;
        let predicted = model.torques(Motions::stiff(&source.motion), &model.robot, None).declared;
        let lines = |x: &Vec<f64>| forward_of(tapered(x.clone()))[first..end].to_vec();
        let of_joint = |j: usize| [&source.torque[j], &predicted[j]].map(lines);
        let joints: Vec<usize> = (0..stretch.joints()).filter(|&j| stretch.has_rows(j)).collect();
        (width > 0).then(|| Self {
            rate_hz: source.rate_hz,
            lines: joints.into_par_iter().map(of_joint).collect(),
            step_hz,
            first,
            width,
        })
    }

    /// Density of what is left where the prediction goes through `filter`.
    fn behind(&self, filter: &SampledFilter) -> NoiseDensity {
        self.density(|frequency_hz| filter.gain(frequency_hz))
    }

    /// Density of what is left of the torques where the prediction is subtracted with a gain.
    fn density(&self, gain: impl Fn(f64) -> Complex64) -> NoiseDensity {
        let count = self.lines.first().map_or(0, |[measured, _]| measured.len());
        let frequency = |l: usize| (self.first + l) as f64 * self.step_hz;
        let gains: Vec<Complex64> = (0..count).map(|l| gain(frequency(l))).collect();
        let of_joint = |[measured, predicted]: &[Vec<Complex64>; 2]| -> Vec<f64> {
            let left = |l: usize| (measured[l] - gains[l] * predicted[l]).norm_sqr();
            let band = |b: usize| (b * self.width..(b + 1) * self.width).map(left).sum::<f64>() / self.width as f64;
            (0..count / self.width).map(band).collect()
        };
        let middle = |b: usize| frequency(b * self.width) + 0.5 * self.width as f64 * self.step_hz;
        NoiseDensity::of_power(
            self.rate_hz,
            (0..count / self.width).map(middle).collect(),
            self.lines.iter().map(of_joint).collect(),
            self.width as f64,
        )
    }

    /// Twice the negative log likelihood without a filter, with the prediction or without: where an arm rests, noise of the
    /// speeds makes the predicted friction chatter, and a filter is no remedy for that.
    pub fn white(&self) -> f64 {
        let cost = |gain: f64| {
            let density = self.density(|_| Complex64::new(gain, 0.0));
            let costs = SETTINGS
                .recorded_filter
                .steps_hz
                .map(|steps| density.cost(None, steps, 0.0).0);
            costs.into_iter().fold(f64::INFINITY, f64::min)
        };
        cost(1.0).min(cost(0.0))
    }

    /// The likeliest filter of a kind.
    pub fn best(&self, order: usize, phase: Phase) -> Option<Likely> {
        let settings = SETTINGS.recorded_filter;
        let highest = settings.highest * (self.first + settings.bands * self.width) as f64 * self.step_hz;
        let lowest = settings.below_sight * self.first as f64 * self.step_hz;
        let last = settings.cutoffs - 1;
        let at = |i: usize| -> Option<Likely> {
            let filter = RecordedFilter {
                order,
                cutoff_hz: lowest * (highest / lowest).powf(i as f64 / last as f64),
                rate_hz: self.rate_hz,
                phase,
            };
            let made = filter.made()?;
            let density = self.behind(&made);
            let shapes = settings
                .steps_hz
                .into_iter()
                .flat_map(|steps| settings.added_once.map(|added| (steps, added)));
            let costs = shapes.map(|(steps, added)| density.cost(Some(&made), steps, added));
            let (cost, misfit) = costs.min_by(|a, b| a.0.total_cmp(&b.0))?;
            let in_sight = filter.cutoff_hz > self.first as f64 * self.step_hz;
            Some(Likely {
                filter,
                cost,
                misfit,
                in_sight,
            })
        };
        let tried: Vec<Likely> = (0..=last).into_par_iter().filter_map(at).collect();
        tried.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Degrees of freedom of a band over two: the misfit of the right density is one over it by chance.
    pub fn weight(&self) -> f64 {
        self.width as f64
    }
}
