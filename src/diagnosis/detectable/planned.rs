//! The recording that is planned, as the diagnosis would see it.

use super::plan::Plan;
use crate::diagnosis::selection::{Candidate, Folds, candidates, hypotheses, own_candidate};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{AugmentedModel, Data, NoiseModel, NoiseSource, Stretch, System, spans};
use crate::trajectory::Trajectory;
use nalgebra::{DMatrix, DVector};

/// One period of every trajectory. A sample stands for several of the log where that has more than a diagnosis works with, or
/// than are needed here.
pub(super) fn stretches(plan: &Plan) -> Vec<Stretch> {
    let most = (SETTINGS.detectable.most_rows / (plan.series.len() * plan.torque_noise.len()).max(1)) as f64;
    let of = |series: &&crate::trajectory::FourierSeries| {
        let period = 1.0 / series.fundamental_hz;
        let samples = (period * plan.rate_hz.min(SETTINGS.detectable.rows_per_second))
            .round()
            .clamp(8.0, most.max(8.0));
        let rate = samples / period;
        Stretch::of_planned(series.sample(rate), 1.0 / rate)
    };
    plan.series.iter().map(of).collect()
}

/// White noise of the mean over the periods, of so many samples of the log as one of `stretches` stands for.
pub(super) fn noise(plan: &Plan, stretches: &[Stretch]) -> Vec<NoiseModel> {
    let together = stretches.first().map_or(1.0, |s| s.interval * plan.rate_hz);
    let of = |std_dev: &f64| NoiseModel {
        source: NoiseSource::Periods,
        degrees_of_freedom: 1.0,
        ..NoiseModel::white(std_dev / (plan.periods * together).sqrt())
    };
    plan.torque_noise.iter().map(of).collect()
}

/// Data, the model that the search starts from, and its candidates.
pub(super) struct Planned<'a> {
    pub data: &'a Data<'a>,
    pub system: System,
    pub candidates: Vec<Candidate>,
    /// Logarithm of the rows that the log has: what one parameter costs.
    pub log_rows: f64,
    pub chance: f64,
    /// Whether the torques of the model are known.
    pub has_values: bool,
    /// Of the declared model, fold by fold: its normal matrix, and the covariance by the data of the others.
    pub folds: Vec<[DMatrix<f64>; 2]>,
}

impl<'a> Planned<'a> {
    pub fn new(plan: &Plan<'a>, data: &'a Data<'a>) -> Self {
        let model: AugmentedModel = plan.model.clone();
        let has_values = model.values.iter().any(|v| *v != 0.0);
        let system = data.linearise(model);
        let mut spans = spans(data.stretches);
        let interval = 1.0 / plan.rate_hz.min(SETTINGS.detectable.rows_per_second);
        spans.iter_mut().for_each(|s| s.interval = interval);
        // As in a diagnosis the own ones come first: of two that explain the same they are named.
        let own = plan.own.iter().filter(|own| !own.is_declared());
        let mut candidates: Vec<Candidate> = own
            .map(|own| own_candidate(own, &spans))
            .chain(candidates(&system.model, &spans, false))
            .collect();
        candidates.retain(|c| !system.model.terms.iter().any(|t| c.is_same_effect(t)));
        candidates.retain(|c| has_values || !needs_values(c));
        let rows: f64 = (0..data.noise.len()).map(|j| system.rows(j) as f64).sum();
        let together = data.stretches.first().map_or(1.0, |s| s.interval / interval);
        Self {
            data,
            candidates,
            log_rows: (rows * together).max(2.0).ln(),
            chance: plan.chance,
            has_values,
            folds: folds(&system),
            system,
        }
    }

    /// What the gain of a candidate with so many parameters costs: below it there is no evidence.
    pub fn price(&self, candidate: &Candidate, cost: usize) -> f64 {
        cost as f64 * self.log_rows + 2.0 * (tried(candidate) as f64).ln()
    }

    /// The gain that it must have: for evidence, and beyond chance.
    pub fn threshold(&self, candidate: &Candidate, cost: usize) -> f64 {
        let tried = hypotheses(&self.candidates, candidate.effect.code());
        let by_chance = super::power::quantile(self.chance / tried, cost);
        by_chance.max(self.price(candidate, cost))
    }
}

fn folds(system: &System) -> Vec<[DMatrix<f64>; 2]> {
    let folds = Folds::new(system, &vec![Vec::new(); system.blocks.len()]);
    let bases = folds.bases(system.covariance.nrows());
    let by_others = bases.iter().map(|base| {
        let variances = base.outside().map(|(_, variance)| variance).collect();
        &base.directions * DMatrix::from_diagonal(&DVector::from_vec(variances)) * base.directions.transpose()
    });
    let by_others: Vec<DMatrix<f64>> = by_others.collect();
    folds
        .normal
        .into_iter()
        .zip(by_others)
        .map(|(own, others)| [own, others])
        .collect()
}

/// Shapes of its grid.
pub(super) fn tried(candidate: &Candidate) -> usize {
    candidate.shapes.iter().map(|s| s.grid.len()).product()
}

/// Whether its columns are made of torques that the model predicts.
pub(super) fn needs_values(candidate: &Candidate) -> bool {
    candidate.is_distortion() || candidate.effect.reads_torques()
}
