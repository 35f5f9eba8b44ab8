//! Logs that were filtered before they were recorded.
//!
//! Controllers smooth the torques that they publish. The steps of Coulomb friction are then no steps in the log, and a model that
//! has them leaves their edges, which look like smooth Coulomb or Stribeck friction. The noise tells: it is as white as sensors
//! make it, and has been through the same filter. Where its power falls as behind a low-pass, and the declared model is clearly
//! the better account once its columns go through that filter, all columns do.

mod noise_density;
mod one_record;

use self::noise_density::{Fit, NoiseDensity};
use self::one_record::{Likely, OneRecord};
use crate::cancel::CancelFlag;
use crate::diagnosis::data_quality::{DataFault, FaultKind, Remedy};
use crate::diagnosis::golden_section::golden_section;
use crate::diagnosis::report::ReportedParameter;
use crate::diagnosis::settings::SETTINGS;
use crate::model::decimals;
use crate::regression::{AugmentedModel, Data, NoiseModel, Phase, RecordedFilter, Stretch, floor};
use std::borrow::Cow;

/// The low-pass that the torques of `stretches` have been through; `None` where nothing says so.
pub(crate) fn recorded_filter(start: &AugmentedModel, stretches: &[Stretch], cancel: &CancelFlag) -> Option<RecordedFilter> {
    let suspects = suspects(start, stretches, cancel);
    if suspects.is_empty() {
        return None;
    }
    let rows = Rows::new(start, stretches, &suspects, cancel);
    let before = rows.chi_square(&rows.data());
    let tried = suspects.into_iter().filter_map(|suspect| rows.refined(suspect));
    let (after, filter) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (before - after > SETTINGS.recorded_filter.gain).then_some(filter)
}

/// Rows so far apart that the noise is nearly white, those of the filter that leaves fewest, on which all filters are held
/// against the declared model.
struct Rows<'a> {
    start: &'a AugmentedModel,
    coarse: Vec<Stretch>,
    /// Every how-manieth row of each stretch.
    steps: Vec<usize>,
    sparse: Vec<Stretch>,
    noise: Vec<NoiseModel>,
    cancel: &'a CancelFlag,
}

impl<'a> Rows<'a> {
    fn new(start: &'a AugmentedModel, stretches: &[Stretch], suspects: &[Suspect], cancel: &'a CancelFlag) -> Self {
        let coarse: Vec<Stretch> = stretches.iter().map(Stretch::as_coarse).collect();
        let step = |s: &Stretch| suspects.iter().map(|suspect| s.step(suspect.filter)).max().unwrap_or(1);
        let steps: Vec<usize> = coarse.iter().map(step).collect();
        let sparse = coarse.iter().zip(&steps).map(|(s, &step)| s.sparse(step)).collect();
        let mut rows = Self {
            start,
            coarse,
            steps,
            sparse,
            noise: Vec::new(),
            cancel,
        };
        rows.noise = floor(&start.robot, &rows.data(), start);
        rows
    }

    fn data(&self) -> Data<'_> {
        self.of(&self.sparse)
    }

    fn of<'d>(&'d self, stretches: &'d [Stretch]) -> Data<'d> {
        Data::new(stretches, self.noise.clone(), None)
            .for_comparison()
            .until(self.cancel)
    }

    fn chi_square(&self, data: &Data) -> f64 {
        data.chi_square(&data.fit(self.start.clone()))
    }

    /// What the declared model leaves with columns behind the filter; nothing where it cannot be made.
    fn behind(&self, filter: RecordedFilter) -> Option<f64> {
        let smooth = self
            .coarse
            .iter()
            .zip(&self.steps)
            .map(|(s, &step)| s.behind_with(filter, step));
        let smooth: Vec<Stretch> = smooth.collect::<Option<_>>()?;
        Some(self.chi_square(&self.of(&smooth)))
    }

    /// The filter with the cut-off by which the model fits best, and what it leaves: the noise alone has the cut-off to a few per
    /// cent.
    fn refined(&self, Suspect { filter, around }: Suspect) -> Option<(f64, RecordedFilter)> {
        let settings = SETTINGS.recorded_filter;
        let at = |x: f64| RecordedFilter {
            cutoff_hz: x.exp(),
            ..filter
        };
        let around = around.map(|factor| (factor * filter.cutoff_hz).ln());
        let gain = |x: f64| self.behind(at(x)).map_or(f64::NEG_INFINITY, |left| -left);
        let filter = at(golden_section(gain, around, settings.refined));
        Some((self.behind(filter)?, filter))
    }
}

/// What is reported of the filter.
pub(crate) fn filtered(filter: RecordedFilter) -> DataFault {
    let parameter = |name: &str, value: f64, unit: &str| ReportedParameter {
        name: name.into(),
        value,
        unit: unit.into(),
        std_dev: f64::NAN,
    };
    let detail = format!(
        "the torques went through a low-pass of about {} Hz before they were recorded: their noise falls beyond, and the steps of friction are as smooth",
        decimals(filter.cutoff_hz, if filter.cutoff_hz < 10.0 { 1 } else { 0 })
    );
    DataFault {
        parameters: vec![
            parameter("cutoff", filter.cutoff_hz, "Hz"),
            parameter("order", filter.order as f64, "1"),
        ],
        ..DataFault::new(FaultKind::FilteredTorque, Vec::new(), detail, Remedy::Filter)
    }
}

/// The stretches with columns that go through the filter. One that is recorded too slowly to show it stays as it is.
pub(crate) fn behind(stretches: &[Stretch], filter: Option<RecordedFilter>) -> Cow<'_, [Stretch]> {
    match filter {
        None => Cow::Borrowed(stretches),
        Some(filter) => stretches
            .iter()
            .map(|s| s.behind(filter).unwrap_or_else(|| s.clone()))
            .collect(),
    }
}

/// A filter that the noise goes with.
#[derive(Debug, Clone, Copy)]
struct Suspect {
    filter: RecordedFilter,
    /// Factors of its cut-off between which the model has the last word.
    around: [f64; 2],
}

/// Filters of every kind that the noise of all joints goes with, where it is far from white.
fn suspects(start: &AugmentedModel, stretches: &[Stretch], cancel: &CancelFlag) -> Vec<Suspect> {
    let repeats = |s: &Stretch| s.periods.len() >= 2 && s.is_plain();
    let comes_once = |s: &Stretch| s.periods.is_empty() && s.source.is_some();
    if stretches.iter().all(repeats) {
        by_periods(&stretches[0])
    } else if stretches.iter().all(comes_once) {
        by_residual(start, stretches, cancel)
    } else {
        Vec::new()
    }
}

fn kinds() -> impl Iterator<Item = (usize, Phase)> {
    let orders = SETTINGS.recorded_filter.orders.into_iter();
    orders.flat_map(|order| [Phase::Zero, Phase::Causal].map(|phase| (order, phase)))
}

fn by_periods(stretch: &Stretch) -> Vec<Suspect> {
    let settings = SETTINGS.recorded_filter;
    let density = NoiseDensity::new(stretch);
    let white = density.white();
    let best = kinds().filter_map(|(order, phase)| density.best(order, phase));
    let clear = best.filter(|fit| white - fit.deviance > settings.not_white);
    // What differs slowly between the periods falls with the frequency too, and is no noise behind a filter.
    let alike = clear.filter(|fit| fit.misfit < settings.misfit + 1.0 / density.weight());
    let suspect = |fit: Fit| Suspect {
        filter: fit.filter,
        around: settings.around,
    };
    alike.map(suspect).collect()
}

/// Filters that what the model leaves goes with, beyond the frequencies of the rows. Of a cut-off below them the slope says how
/// steep the filter is, and little of where it begins.
fn by_residual(start: &AugmentedModel, stretches: &[Stretch], cancel: &CancelFlag) -> Vec<Suspect> {
    let settings = SETTINGS.recorded_filter;
    let coarse: Vec<Stretch> = stretches.iter().map(Stretch::as_coarse).collect();
    let data = Data::new(&coarse, Vec::new(), None).for_comparison().until(cancel);
    let noise = floor(&start.robot, &data, start);
    let model = data.with_noise(noise).fit(start.clone()).model;
    let Some(record) = OneRecord::new(&stretches[0], &model) else {
        return Vec::new();
    };
    let white = record.white();
    let found: Vec<Likely> = kinds().filter_map(|(order, phase)| record.best(order, phase)).collect();
    let least = found.iter().map(|fit| fit.cost).fold(f64::INFINITY, f64::min);
    let clear = found
        .into_iter()
        .filter(|fit| white.min(least + 2.0 * settings.not_white) - fit.cost > settings.not_white);
    let alike = clear.filter(|fit| fit.misfit < settings.misfit + 1.0 / record.weight());
    let suspect = |fit: Likely| Suspect {
        filter: fit.filter,
        around: if fit.in_sight {
            settings.around
        } else {
            settings.around_slope
        },
    };
    alike.map(suspect).collect()
}
