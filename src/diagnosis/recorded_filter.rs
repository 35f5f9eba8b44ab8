//! Logs that were filtered before they were recorded.
//!
//! Controllers smooth the torques that they publish. The steps of Coulomb friction are then no steps in the log, and a model that has them leaves their edges, which
//! look like smooth Coulomb or Stribeck friction. The noise tells: it is as white as sensors make it, and has been through the same filter. Where its power falls as behind a
//! low-pass, and the declared model is clearly the better account once its columns go through that filter, all columns do.

use crate::diagnosis::data_quality::{DataFault, FaultKind, Remedy};
use crate::diagnosis::report::ReportedParameter;
use crate::diagnosis::settings::SETTINGS;
use crate::model::decimals;
use crate::preparation::spectrum::forward_of;
use crate::regression::{AugmentedModel, Data, Phase, RecordedFilter, Stretch, deviation, floor};
use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

/// The low-pass that the torques of `stretches` have been through; `None` where nothing says so.
pub(crate) fn recorded_filter(start: &AugmentedModel, stretches: &[Stretch]) -> Option<RecordedFilter> {
    let coarse: Vec<Stretch> = stretches.iter().map(Stretch::as_coarse).collect();
    let suspects = suspects(stretches);
    // All on the same rows, those of the filter that leaves fewest.
    let step = |s: &Stretch| suspects.iter().map(|spec| s.step(*spec)).max().unwrap_or(1);
    let steps: Vec<usize> = coarse.iter().map(step).collect();
    let tried = suspects.iter().filter_map(|spec| Tried::new(start, &coarse, &steps, *spec));
    let best = tried.min_by(|a, b| a.left.total_cmp(&b.left))?;
    (best.gain > SETTINGS.recorded_filter.gain).then_some(best.spec)
}

/// A filter, held against the declared model.
struct Tried {
    spec: RecordedFilter,
    /// By how much the sum of squares falls when columns go through the filter.
    gain: f64,
    /// Mean square that is left [in units of the noise].
    left: f64,
}

impl Tried {
    /// On rows so far apart that the noise is nearly white, at the cut-off by which the model fits best: the noise alone has it to a few per cent.
    fn new(start: &AugmentedModel, stretches: &[Stretch], steps: &[usize], spec: RecordedFilter) -> Option<Self> {
        let sparse: Vec<Stretch> = stretches.iter().zip(steps).map(|(s, &step)| s.sparse(step)).collect();
        let mut plain = Data::new(&sparse, Vec::new(), None).for_comparison();
        plain.noise = floor(&start.robot, &plain, start);
        let before = plain.chi_square(&plain.fit(start.clone()));
        let after = |spec: RecordedFilter| {
            let smooth = stretches.iter().zip(steps).map(|(s, &step)| s.behind_with(spec, step));
            let smooth: Vec<Stretch> = smooth.collect::<Option<_>>()?;
            let data = Data::new(&smooth, plain.noise.clone(), None).for_comparison();
            Some(data.chi_square(&data.fit(start.clone())))
        };
        let at = |x: f64| RecordedFilter {
            cutoff_hz: x.exp(),
            ..spec
        };
        let around = SETTINGS.recorded_filter.around.map(|factor| (factor * spec.cutoff_hz).ln());
        let steps_of_search = SETTINGS.recorded_filter.refined;
        let spec = at(golden_section(around, steps_of_search, |x| {
            after(at(x)).unwrap_or(f64::INFINITY)
        }));
        let least = after(spec)?;
        let rows: usize = sparse.iter().map(|s| s.usable.iter().flatten().filter(|u| **u).count()).sum();
        Some(Self {
            spec,
            gain: before - least,
            left: least / rows.max(1) as f64,
        })
    }
}

/// What is reported of the filter.
pub(crate) fn filtered(spec: RecordedFilter) -> DataFault {
    let parameter = |name: &str, value: f64, unit: &str| ReportedParameter {
        name: name.into(),
        value,
        unit: unit.into(),
        std_dev: f64::NAN,
    };
    let detail = format!(
        "the torques went through a low-pass of about {} Hz before they were recorded: their noise falls beyond, and the steps of friction are as smooth",
        decimals(spec.cutoff_hz, if spec.cutoff_hz < 10.0 { 1 } else { 0 })
    );
    DataFault {
        parameters: vec![
            parameter("cutoff", spec.cutoff_hz, "Hz"),
            parameter("order", spec.order as f64, "1"),
        ],
        ..DataFault::new(FaultKind::FilteredTorque, Vec::new(), detail, Remedy::Filter)
    }
}

/// The stretches with columns that go through the filter. One that is recorded too slowly to show it stays as it is.
pub(crate) fn behind(stretches: &[Stretch], spec: Option<RecordedFilter>) -> Cow<'_, [Stretch]> {
    match spec {
        None => Cow::Borrowed(stretches),
        Some(spec) => stretches
            .iter()
            .map(|s| s.behind(spec).unwrap_or_else(|| s.clone()))
            .collect(),
    }
}

/// Filters of every order that the noise of all joints goes with, where it is far from white.
fn suspects(stretches: &[Stretch]) -> Vec<RecordedFilter> {
    let unfiltered = |s: &Stretch| s.periods.len() >= 2 && s.is_plain();
    if !stretches.iter().all(unfiltered) {
        return Vec::new();
    }
    let bands = Bands::new(&stretches[0]);
    let white = bands.deviance(&|f| bands.mean(f));
    let phases = [Phase::Zero, Phase::Causal];
    let kinds = SETTINGS
        .recorded_filter
        .orders
        .into_iter()
        .flat_map(|order| phases.map(|phase| (order, phase)));
    let best = kinds.filter_map(|(order, phase)| bands.best(order, phase));
    let clear = best.filter(|(deviance, _)| white - deviance > SETTINGS.recorded_filter.not_white);
    let filters = clear.map(|(_, filter)| filter);
    filters.filter(|filter| bands.goes_with(filter)).collect()
}

/// Power of the noise of every joint in bands of frequency, by what the periods deviate from their mean.
struct Bands {
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

impl Bands {
    fn new(stretch: &Stretch) -> Self {
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

    /// Whittle's deviance of a shape of the power density, the level of every joint the best: `2 w Σ (ln g + ln s²)`, up to a constant.
    fn deviance(&self, shape: &dyn Fn(f64) -> f64) -> f64 {
        let g: Vec<f64> = self.frequencies.iter().map(|f| shape(*f)).collect();
        let logs: f64 = g.iter().map(|g| g.ln()).sum();
        let of_joint = |power: &Vec<f64>| {
            let level = power.iter().zip(&g).map(|(p, g)| p / g).sum::<f64>() / g.len() as f64;
            logs + g.len() as f64 * level.ln()
        };
        2.0 * self.weight * self.power.iter().map(of_joint).sum::<f64>()
    }

    /// Whether the density of every joint is that of white noise behind the filter, and no other that falls: per band, `2 (x − ln x − 1)` of the ratio x of the two is near the
    /// square of `x − 1`, and a fiftieth by chance with fifty lines. What differs slowly between the periods is no noise behind a filter.
    fn goes_with(&self, filter: &RecordedFilter) -> bool {
        let settings = SETTINGS.recorded_filter;
        let misfit = |added: f64| match filter.made() {
            Some(made) => self.misfit(&|f| made.density(f) * self.mean(f) + added + settings.unseen),
            None => f64::INFINITY,
        };
        let least = settings.added.into_iter().map(misfit).fold(f64::INFINITY, f64::min);
        least < settings.misfit + 1.0 / self.weight
    }

    /// Of the joint where it is largest, the mean over the bands of `2 (x − ln x − 1)`.
    fn misfit(&self, shape: &dyn Fn(f64) -> f64) -> f64 {
        let g: Vec<f64> = self.frequencies.iter().map(|f| shape(*f)).collect();
        let of_joint = |power: &Vec<f64>| {
            let level = power.iter().zip(&g).map(|(p, g)| p / g).sum::<f64>() / g.len() as f64;
            let ratios = power.iter().zip(&g).map(|(p, g)| p / (g * level));
            ratios.map(|x| 2.0 * (x - x.ln() - 1.0)).sum::<f64>() / g.len() as f64
        };
        self.power.iter().map(of_joint).fold(0.0, f64::max)
    }

    /// Power that the mean over the samples of a row leaves of a wave: `(sin(m x) / (m sin x))²`, `x = π f/f_s`.
    fn mean(&self, frequency_hz: f64) -> f64 {
        let m = self.rate_hz / self.rows_hz;
        let x = PI * frequency_hz / self.rate_hz;
        ((m * x).sin() / (m * x.sin())).powi(2)
    }

    /// The cut-off at which noise that is white but for a filter of this order, and for white noise added behind it, fits best; with its deviance.
    fn best(&self, order: usize, phase: Phase) -> Option<(f64, RecordedFilter)> {
        let settings = SETTINGS.recorded_filter;
        let highest = settings.highest * self.rows_hz / 2.0;
        let lowest = self.frequencies[0].max(settings.lowest * self.rows_hz);
        if lowest >= highest {
            return None;
        }
        let filter = |cutoff_hz: f64| RecordedFilter {
            order,
            cutoff_hz,
            rate_hz: self.rate_hz,
            phase,
        };
        let deviance = |cutoff_hz: f64, added: f64| match filter(cutoff_hz).made() {
            Some(filter) => self.deviance(&|f| filter.density(f) * self.mean(f) + added + settings.unseen),
            None => f64::INFINITY,
        };
        let steps = settings.cutoffs;
        let cutoff = |i: usize| lowest * (highest / lowest).powf(i as f64 / (steps - 1) as f64);
        let places = (0..steps).flat_map(|i| settings.added.iter().map(move |&added| (i, added)));
        let at = |(i, added): (usize, f64)| (deviance(cutoff(i), added), i, added);
        let (_, i, added) = places.map(at).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let around = [i.saturating_sub(1), (i + 1).min(steps - 1)].map(|i| cutoff(i).ln());
        let cutoff_hz = golden_section(around, settings.refined, |x| deviance(x.exp(), added)).exp();
        Some((deviance(cutoff_hz, added), filter(cutoff_hz)))
    }
}

/// Power with a little of its largest added, as to the shapes that it is held against: what is a thousandth of the noise and less comes from anywhere. `None` without power.
fn raised(mut power: Vec<f64>) -> Option<Vec<f64>> {
    let largest = power.iter().copied().fold(0.0, f64::max);
    power.iter_mut().for_each(|p| *p += SETTINGS.recorded_filter.unseen * largest);
    (largest > 0.0 && largest.is_finite()).then_some(power)
}

/// Hann's window: a period is a piece of noise that does not repeat, and the power behind a steep filter would be what leaks there from before it.
fn tapered(mut x: Vec<f64>) -> Vec<f64> {
    let n = x.len() as f64;
    let window = |s: usize| 0.5 - 0.5 * (TAU * (s as f64 + 0.5) / n).cos();
    x.iter_mut().enumerate().for_each(|(s, v)| *v *= window(s));
    x
}

/// The minimum between two places: every step leaves 0.62 of the distance.
fn golden_section([mut low, mut high]: [f64; 2], steps: usize, f: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..steps {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if f(a) < f(b) { high = b } else { low = a }
    }
    0.5 * (low + high)
}
