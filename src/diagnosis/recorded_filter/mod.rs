//! Logs that were filtered before they were recorded.
//!
//! Controllers smooth the torques that they publish. The steps of Coulomb friction are then no steps in the log, and a model that
//! has them leaves their edges, which look like smooth Coulomb or Stribeck friction. The noise tells: it is as white as sensors
//! make it, and has been through the same filter. Where its power falls as behind a low-pass, and the declared model is clearly
//! the better account once its columns go through that filter, all columns do.

mod noise_density;

use self::noise_density::NoiseDensity;
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
    let suspects = suspects(stretches);
    if suspects.is_empty() {
        return None;
    }
    let rows = Rows::new(start, stretches, &suspects, cancel);
    let before = rows.chi_square(&rows.data());
    let tried = suspects.into_iter().filter_map(|filter| rows.refined(filter));
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
    fn new(start: &'a AugmentedModel, stretches: &[Stretch], filters: &[RecordedFilter], cancel: &'a CancelFlag) -> Self {
        let coarse: Vec<Stretch> = stretches.iter().map(Stretch::as_coarse).collect();
        let step = |s: &Stretch| filters.iter().map(|filter| s.step(*filter)).max().unwrap_or(1);
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
    fn refined(&self, filter: RecordedFilter) -> Option<(f64, RecordedFilter)> {
        let settings = SETTINGS.recorded_filter;
        let at = |x: f64| RecordedFilter {
            cutoff_hz: x.exp(),
            ..filter
        };
        let around = settings.around.map(|factor| (factor * filter.cutoff_hz).ln());
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

/// Filters of every kind that the noise of all joints goes with, where it is far from white.
fn suspects(stretches: &[Stretch]) -> Vec<RecordedFilter> {
    let unfiltered = |s: &Stretch| s.periods.len() >= 2 && s.is_plain();
    if !stretches.iter().all(unfiltered) {
        return Vec::new();
    }
    let settings = SETTINGS.recorded_filter;
    let density = NoiseDensity::new(&stretches[0]);
    let white = density.white();
    let phases = [Phase::Zero, Phase::Causal];
    let kinds = settings
        .orders
        .into_iter()
        .flat_map(|order| phases.map(|phase| (order, phase)));
    let best = kinds.filter_map(|(order, phase)| density.best(order, phase));
    let clear = best.filter(|fit| white - fit.deviance > settings.not_white);
    // What differs slowly between the periods falls with the frequency too, and is no noise behind a filter.
    let alike = clear.filter(|fit| fit.misfit < settings.misfit + 1.0 / density.weight());
    alike.map(|fit| fit.filter).collect()
}
