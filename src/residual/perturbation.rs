//! Whether what was found survives changes of the data that should not matter.
//!
//! A cause is there in either half of a log and behind any sensible filter; what only one cut-off or one part of the data shows may be their doing. The final
//! model is fitted anew to the changed data, and every effect of it tested as the search tests it.

use super::coarse::coarse_filter;
use super::confirm::doubt;
use super::judge::is_physical;
use super::system::{Data, System};
use super::{AugmentedModel, NoiseModel, Stretch};
use crate::identification::filter::LowPass;
use crate::identification::{CancelFlag, PreparedLog};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;

/// A change of the data that should not matter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Perturbation {
    /// Torques rounded to six digits.
    SixDigits,
    /// Every second row left out.
    EverySecondRow,
    /// The first half of the rows, or of the periods, alone.
    FirstHalf,
    SecondHalf,
    /// The cut-off of the row filter a quarter lower, or higher.
    LowerCutoff,
    HigherCutoff,
}

/// What became of an effect under one change.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Survival {
    pub perturbation: Perturbation,
    /// Whether the effect is still beyond doubt, physical and of the same sign.
    pub survives: bool,
}

/// Chance of an effect of that size without a cause from which it is in doubt: the search asks for far more, but half of the data holds half of the evidence.
const DOUBTFUL: f64 = 1e-2;
/// Part of the cut-off that it is moved by.
const CUTOFF_STEP: f64 = 0.25;

const ALL: [Perturbation; 6] = [
    Perturbation::SixDigits,
    Perturbation::EverySecondRow,
    Perturbation::FirstHalf,
    Perturbation::SecondHalf,
    Perturbation::LowerCutoff,
    Perturbation::HigherCutoff,
];

/// Per term of `model` from number `first` on, what became of it under every change that these data allow.
pub(super) fn survivals(
    stretches: &[Stretch],
    model: &AugmentedModel,
    first: usize,
    noise: &[NoiseModel],
    cancel: &CancelFlag,
) -> Vec<Vec<Survival>> {
    let terms = first..model.terms.len();
    if terms.is_empty() {
        return Vec::new();
    }
    let under = |&perturbation: &Perturbation| {
        cancel.leave_if_set();
        let changed: Vec<Stretch> = stretches.iter().map(|s| perturbation.of(s)).collect::<Option<_>>()?;
        // Rows further apart, or behind another filter, have noise of another course, where it is measured.
        let measured: Option<Vec<NoiseModel>> = (0..noise.len()).map(|j| NoiseModel::from_periods(&changed, j)).collect();
        let noise = measured.unwrap_or_else(|| noise.to_vec());
        let data = Data::new(&changed, noise, None).for_comparison().until(cancel);
        let system = data.fit(model.clone());
        let each = terms.clone().map(|at| is_still_there(&system, model, at));
        Some((perturbation, each.collect::<Vec<bool>>()))
    };
    let found: Vec<_> = ALL.par_iter().with_max_len(1).filter_map(under).collect();
    let of = |i: usize| {
        let one = |(perturbation, survive): &(Perturbation, Vec<bool>)| Survival {
            perturbation: *perturbation,
            survives: survive[i],
        };
        found.iter().map(one).collect()
    };
    (0..terms.len()).map(of).collect()
}

fn is_still_there(system: &System, model: &AugmentedModel, at: usize) -> bool {
    let values = |m: &AugmentedModel| -> Vec<f64> {
        let term = &m.terms[at];
        match term.is_distortion() {
            true => term.shape[..term.free_shapes].to_vec(),
            false => term.coefficients.clone(),
        }
    };
    let alike: f64 = values(&system.model).iter().zip(values(model)).map(|(a, b)| a * b).sum();
    alike > 0.0 && is_physical(system, at) && doubt(system, at) < DOUBTFUL
}

impl Perturbation {
    /// The stretch after the change, in its coarse form; `None` where the change has no meaning for it.
    fn of(self, stretch: &Stretch) -> Option<Stretch> {
        let coarse = || stretch.as_coarse();
        match self {
            Self::SixDigits => Some(coarse().with_torques(six_digits)),
            Self::EverySecondRow => Some(coarse().every_second_row()),
            Self::FirstHalf => coarse().half(0),
            Self::SecondHalf => coarse().half(1),
            Self::LowerCutoff => stretch.with_cutoff(1.0 - CUTOFF_STEP).map(|s| s.as_coarse()),
            Self::HigherCutoff => stretch.with_cutoff(1.0 + CUTOFF_STEP).map(|s| s.as_coarse()),
        }
    }
}

fn six_digits(v: f64) -> f64 {
    format!("{v:.5e}").parse().unwrap_or(v)
}

impl Stretch {
    fn with_torques(mut self, change: impl Fn(f64) -> f64) -> Self {
        let periods = self.periods.iter_mut().flatten();
        periods.chain(self.torque.iter_mut()).flatten().for_each(|v| *v = change(*v));
        self
    }

    /// The same with half of its rows.
    fn every_second_row(mut self) -> Self {
        fn half<T: Copy>(all: &mut Vec<T>) {
            *all = all.iter().step_by(2).copied().collect();
        }
        // Rows next to a reversal are left out before the filter hides which they are.
        self.usable = (0..self.joints()).map(|j| self.kept(&self.motion, j)).collect();
        self.torque.iter_mut().chain(self.periods.iter_mut().flatten()).for_each(half);
        self.usable.iter_mut().chain(&mut self.resting).for_each(half);
        half(&mut self.samples);
        let filter = self.filter.take();
        let rows = move |x: &[f64]| -> Vec<f64> {
            let all = filter.as_ref().map_or_else(|| x.to_vec(), |f| f(x));
            all.into_iter().step_by(2).collect()
        };
        Self {
            filter: Some(Arc::new(rows)),
            periodic: false,
            coarse: None,
            unfiltered: None,
            ..self
        }
    }

    /// The same with the rows alone that `keep` says, by number and count.
    fn with_rows(mut self, keep: impl Fn(usize, usize) -> bool) -> Self {
        let count = self.rows();
        let marks = self.usable.iter_mut().flat_map(|u| u.iter_mut().enumerate());
        marks.for_each(|(s, u)| *u &= keep(s, count));
        self
    }

    /// One half of the periods, or of the rows where there are none. Of an odd number of periods the one in the middle belongs to both.
    fn half(self, which: usize) -> Option<Self> {
        let count = self.periods.len();
        if count == 0 {
            return Some(self.with_rows(|s, all| (2 * s >= all) == (which == 1)));
        }
        if count < 4 {
            return None;
        }
        let part: Vec<usize> = match which {
            0 => (0..count.div_ceil(2)).collect(),
            _ => (count / 2..count).collect(),
        };
        Some(Self {
            torque: self.mean_over(&part),
            periods: part.iter().map(|&p| self.periods[p].clone()).collect(),
            starts: part.iter().map(|&p| self.starts[p]).collect(),
            ..self
        })
    }

    /// The same log behind a filter with `factor` times the cut-off; `None` where it goes through none, or repeats.
    fn with_cutoff(&self, factor: f64) -> Option<Self> {
        let source = self.source.as_ref()?;
        let old = source.row_filter.columns.as_ref()?;
        let filter = LowPass::butterworth(old.order, factor * old.cutoff_hz, old.rate_hz).ok()?;
        let mut prepared = PreparedLog::clone(source);
        prepared.row_filter.torque = Some(filter.clone());
        prepared.row_filter.columns = Some(filter);
        let step = prepared.row_filter.decimation as f64 / factor;
        prepared.row_filter.decimation = step.round().max(1.0) as usize;
        let fine = Self::of(&prepared, Vec::new(), self.starts.clone());
        let coarse = coarse_filter(&prepared.row_filter).map(|(first, step, filter)| fine.thinned(first, step, filter));
        Some(Self { coarse, ..fine })
    }
}

/// What a stretch of a log that does not repeat is made from, for other filters.
pub(super) fn source_of(prepared: &PreparedLog) -> Option<Arc<PreparedLog>> {
    (!prepared.is_periodic() && prepared.row_filter.columns.is_some()).then(|| Arc::new(prepared.clone()))
}
