//! The whole course: from stretches of data to a report and an augmented model.

use super::between::{self, Separated};
use super::border::{RivalTerm, border};
use super::candidate::candidates;
use super::confirm::{Searched, honest_covariance, searched};
use super::estimate::estimated;
use super::findings::{Told, between_findings, findings};
use super::held_out::{Judge, decide};
use super::misfit::{at_rest, fits, rms};
use super::perturbation::survivals;
use super::remainder::unaccounted;
use super::report::{Estimates, HeldOutVerdict, Outcome};
use super::rivals::Contest;
use super::select::Threshold;
use super::stretch::spans;
use super::system::{Data, Prior, System};
use super::trend::trends;
use super::undetected::{nuisance, undetected};
use super::unsteady::{joined, remainder_of};
use super::{AugmentedModel, Finding, NoiseModel, NoiseSource, NotTested, ResidualReport, Rival, Stretch, Term, Verdict};
use crate::identification::{CancelFlag, Estimator, Explained, folds_both_ways, folds_in_time, shares, with_constant};
use crate::model::Robot;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// What can be asked of the tracing.
#[derive(Debug, Clone)]
pub struct TraceOptions {
    /// Largest chance of a false finding in one log. One in a thousand: a false finding is worse than a miss, because somebody will
    /// compensate for it.
    pub chance: f64,
    /// An existing model and its information, when the question is what has changed since.
    pub existing: Option<(AugmentedModel, Prior)>,
    /// Whether a torque offset of every joint belongs to the declared model: it is fitted, and is no finding.
    pub offsets: bool,
    /// A bound on the search: friction laws of one joint have at most three parts beside viscous and Coulomb (Bittencourt & Gunnarsson 2012).
    pub most_effects_per_joint: usize,
    /// Whether effects are looked for; otherwise the declared model is estimated and its lack of fit reported.
    pub search: bool,
    /// How rows weigh in the estimate that is handed out.
    pub estimator: Estimator,
    /// Leaves the tracing when it is set, as [`CancelFlag::leave_if_set`] does: within [`CancelFlag::run`].
    pub cancel: CancelFlag,
}

impl Default for TraceOptions {
    fn default() -> Self {
        Self {
            chance: 1e-3,
            existing: None,
            offsets: false,
            most_effects_per_joint: 3,
            search: true,
            estimator: Estimator::Weighted,
            cancel: CancelFlag::default(),
        }
    }
}

impl TraceOptions {
    /// The model that the search starts from.
    fn start(&self, robot: &Robot) -> AugmentedModel {
        let existing = self.existing.as_ref().map(|(model, _)| model.clone());
        let mut start = existing.unwrap_or_else(|| AugmentedModel::declared(robot));
        if self.offsets {
            start.terms.extend((0..robot.joint_count()).map(Term::offset));
        }
        start
    }
}

/// Report, model and noise.
pub type Traced = Outcome;

/// Traces what `robot`'s declared model leaves over on `stretches`. `held_out` is only ever predicted: it fits nothing, and has the last word on what
/// stays in the model.
pub fn trace(robot: &Robot, stretches: &[Stretch], held_out: &[Stretch], options: &TraceOptions) -> Traced {
    let start = options.start(robot);
    let prior = options.existing.as_ref().map(|(_, prior)| prior);
    let Separated {
        steady,
        explained,
        found: between,
        mut unsteady,
    } = match options.search {
        true => between::separate(robot, stretches, options.chance),
        false => Separated::nothing(stretches),
    };
    let measured = stretches;
    let stretches = &steady[..];
    // What to add is found on the coarse forms, which have the same rows; values and errors are those of all samples.
    let coarse: Vec<Stretch> = stretches.iter().map(Stretch::as_coarse).collect();
    let mut data = Data::new(&coarse, Vec::new(), prior).for_comparison().until(&options.cancel);
    data.noise = floor(robot, &data, &start);
    let fine = Data::new(stretches, data.noise.clone(), prior).until(&options.cancel);
    let first = fine.fit(start.clone());
    let lack_of_fit = fits(&fine, &first);
    let threshold = Threshold {
        chance: options.chance,
        share: 0.05,
        generalises: 0.5,
        most_effects: options.most_effects_per_joint * robot.joint_count(),
    };
    let not_tested = not_tested(robot, stretches);
    let share = explained_on(&AugmentedModel::declared(robot), measured);
    // Noise lacks nothing that an effect could be.
    let explains = options.existing.is_some() || share.is_more_than_a_constant();
    let search = options.search && explains;
    let mut list = match search {
        true => candidates(&start, &spans(stretches), prior.is_some()),
        false => Vec::new(),
    };
    list.retain(|c| c.joints.iter().all(|&j| stretches.iter().any(|s| s.has_rows(j))));
    let Searched {
        data,
        system: searched,
        fixed,
        accepted,
        contests,
        remainder: rest,
    } = searched(&data, &fine, start.clone(), &list, &threshold);
    if search {
        unsteady.extend(trends(&data, &searched, options.chance));
    }
    let floor: Vec<f64> = data.noise.iter().map(|n| n.std_dev).collect();
    let judge = Judge {
        logs: held_out,
        floor: &floor,
    };
    let withheld: Vec<DMatrix<f64>> = (0..accepted.len()).map(|i| honest_covariance(&searched, fixed + i)).collect();
    let named: Vec<Term> = searched.model.terms[fixed..].to_vec();
    let decision = decide(&data, searched, fixed, &judge);
    let estimates = prior.is_none().then(|| Estimates {
        found: estimated(&data, &decision.system.model, options.estimator),
        declared: estimated(&data, &start, options.estimator),
    });
    let system = match &estimates {
        Some(estimates) => data.linearise(estimates.found.model.clone()),
        None => decision.system,
    };
    let before = match &estimates {
        Some(estimates) => data.linearise(estimates.declared.model.clone()),
        None => data.fit(start.clone()),
    };
    let stay = decision.stay;
    let rest = match stay < accepted.len() {
        true => rest.or_else(|| unaccounted(&data, &system)),
        false => rest,
    };
    let rest = joined(rest, remainder_of(robot, &unsteady)).filter(|_| explains);
    let names: Vec<String> = robot.joints().iter().map(|j| j.name.clone()).collect();
    let held_out_report = match stay {
        0 => judge.nothing(&names, &judge.errors(&data, &system)),
        _ => judge.whole(&names, &judge.errors(&data, &before), &judge.errors(&data, &system)),
    };
    let verdict = match explains {
        true => verdict(
            stay + between.len(),
            rest.is_some(),
            stay < accepted.len() || held_out_report.verdict == HeldOutVerdict::NotConfirmed,
        ),
        false => Verdict::Unexplained,
    };
    let in_order = |at: usize| decision.order[at];
    let told = Told {
        data: &data,
        estimator: options.estimator,
        declared: &before.model,
        nuisance: &system.model.terms[start.terms.len()..fixed],
        last: &system.model,
        covariances: (0..accepted.len())
            .map(|at| match &estimates {
                Some(estimates) if at < stay => estimates.found.term_covariance(fixed + at),
                None if at < stay => honest_covariance(&system, fixed + at),
                _ => withheld[in_order(at)].clone(),
            })
            .collect(),
        terms: (0..accepted.len())
            .map(|at| match at < stay {
                true => system.model.terms[fixed + at].clone(),
                false => named[in_order(at)].clone(),
            })
            .collect(),
        stay,
        held_out: decision.tests,
        accepted: (0..accepted.len()).map(|at| accepted[in_order(at)].clone()).collect(),
        contests: (0..accepted.len()).map(|at| contests[in_order(at)].clone()).collect(),
        survivals: match prior {
            None => survivals(stretches, &system.model, fixed, &data.noise, &options.cancel),
            Some(_) => Vec::new(),
        },
    };
    // Drift and contacts are explained, though no part of the model. What nothing explains was kept from the fits, and stays in the errors.
    let told_of = if between.is_empty() { measured } else { &explained[..] };
    let mut all: Vec<Finding> = between_findings(robot, between, &before.model, measured, &explained, held_out);
    all.extend(findings(&told, [told_of, held_out]));
    let covariance = |at: usize| match &estimates {
        Some(estimates) => estimates.found.term_covariance(at),
        None => honest_covariance(&system, at),
    };
    let mut not_found = nuisance(&system.model, start.terms.len()..fixed, covariance);
    not_found.extend(undetected(&data, &system, &list));
    let report = ResidualReport {
        noise_floor: data.noise.iter().map(floor_of).collect(),
        noise_source: source(&data.noise),
        lack_of_fit,
        verdict,
        held_out: held_out_report,
        data_faults: Vec::new(),
        findings: all,
        remainder: rest,
        undetected: not_found,
        explains_nothing: !explains,
        not_tested,
        lack_of_fit_after: fits(&data, &system),
        rms_before: rms(&before.model, measured, held_out),
        rms_after: rms(&system.model, told_of, held_out),
        at_rest: at_rest(&before.model, &system.model, measured, held_out),
    };
    let mut rival_terms = vec![Vec::new(); fixed];
    rival_terms.extend(told.contests[..stay].iter().map(|c| rival_terms_of(&data, &system, c)));
    Outcome {
        report,
        rival_terms,
        rate_hz: rate(stretches),
        information: data.known(&system),
        model: system.model,
        explained: share,
        noise: data.noise,
        estimates,
    }
}

/// Whether the declared model explains the torques at all: of stretches with periods, one half of them predicts the other.
fn explained_on(model: &AugmentedModel, stretches: &[Stretch]) -> Explained {
    let p = model.values.len();
    let folds = stretches.iter().flat_map(|stretch| {
        let rows = model.base_rows(stretch);
        let kept: Vec<Vec<bool>> = (0..stretch.joints()).map(|j| stretch.kept(&stretch.motion, j)).collect();
        let part = |torque: &[Vec<f64>], range: Range<usize>| {
            let joint = |j: usize| {
                let at: Vec<usize> = range.clone().filter(|&s| kept[j][s]).collect();
                let matrix = DMatrix::from_fn(at.len(), rows[j].len(), |r, c| rows[j][c].1[at[r]]);
                let own: Vec<f64> = at.iter().map(|&s| torque[j][s]).collect();
                let columns = rows[j].iter().map(|c| c.0).chain([p + j]).collect();
                with_constant(&matrix, &own, at.len(), columns)
            };
            (0..stretch.joints()).map(joint).collect()
        };
        let count = stretch.periods.len();
        if count < 2 {
            return folds_in_time(stretch.rows(), |range| part(&stretch.torque, range));
        }
        let [even, odd] = [0, 1].map(|half| {
            let mean = stretch.mean_over(&(half..count).step_by(2).collect::<Vec<_>>());
            part(&mean, 0..stretch.rows())
        });
        folds_both_ways(even, odd)
    });
    shares(&folds.collect::<Vec<_>>())
}

/// Standard deviation of one measurement; NaN, which documents have as null, where a joint has none.
fn floor_of(noise: &NoiseModel) -> f64 {
    if noise.is_absent() { f64::NAN } else { noise.std_dev }
}

/// Joints that no log says anything of, and why.
fn not_tested(robot: &Robot, stretches: &[Stretch]) -> Vec<NotTested> {
    let of = |j: usize| {
        let reason = stretches.iter().find_map(|s| s.excluded[j]);
        NotTested {
            joint: robot.joints()[j].name.clone(),
            reason: reason.map_or_else(|| "no row of it is left".into(), |e| e.to_string()),
        }
    };
    let silent = |j: &usize| stretches.iter().all(|s| !s.has_rows(*j));
    (0..robot.joint_count()).filter(silent).map(of).collect()
}

/// Rivals as they were fitted, with what the data say of them beside the final model.
fn rival_terms_of(data: &Data, system: &System, contest: &Contest) -> Vec<RivalTerm> {
    let of = |(rival, (term, base_values)): (&Rival, &(Term, DVector<f64>))| {
        let (cross, own) = border(data, system, term);
        RivalTerm {
            term: term.clone(),
            base_values: base_values.clone(),
            evidence: rival.evidence,
            cross,
            own,
        }
    };
    contest.rivals.iter().zip(&contest.fitted).map(of).collect()
}

/// Rows of a fit per second of the motion.
fn rate(stretches: &[Stretch]) -> f64 {
    let of = |s: &Stretch| s.rows() as f64 / (s.motion.samples() as f64 * s.interval);
    stretches.first().map_or(f64::NAN, of)
}

impl Outcome {
    /// The model and what is known about it, for tracing what changes afterwards. The remainder's stand-in terms stay out of it.
    pub fn existing(&self) -> (AugmentedModel, Prior) {
        (
            self.model.clone(),
            Prior {
                mean: self.model.vector(),
                information: self.information.clone(),
            },
        )
    }
}

/// `doubtful`: an effect did not stay, or held-out data do not confirm what stays. Then not all is explained, whatever the fit says.
fn verdict(findings: usize, something_left: bool, doubtful: bool) -> Verdict {
    match (findings, something_left || doubtful) {
        (0, false) => Verdict::NothingMissing,
        (_, false) => Verdict::Explained,
        (0, true) => Verdict::Unexplained,
        (_, true) => Verdict::PartlyExplained,
    }
}

fn source(noise: &[NoiseModel]) -> String {
    match noise.first().map(|n| n.source) {
        Some(NoiseSource::Periods) => "scatter between periods".into(),
        _ => "the residual's own course from sample to sample: weaker, what the model lacks can pass for noise".into(),
    }
}

/// The noise of every joint: from the periods where there are at least two, otherwise from what the model leaves.
pub(super) fn floor(robot: &Robot, data: &Data, model: &AugmentedModel) -> Vec<NoiseModel> {
    let from_periods: Option<Vec<NoiseModel>> = (0..robot.joint_count())
        .map(|j| NoiseModel::from_periods(data.stretches, j))
        .collect();
    from_periods.unwrap_or_else(|| residual_noise(data, model))
}

/// Noise taken from the residual of an ordinary fit, weights refined once by the noise found.
fn residual_noise(data: &Data, model: &AugmentedModel) -> Vec<NoiseModel> {
    let mut noise = vec![NoiseModel::white(1.0); model.robot.joint_count()];
    for _ in 0..2 {
        let weighted = data.with_noise(noise);
        let system = weighted.fit(model.clone());
        noise = weighted.left_as_noise(&system);
    }
    noise
}
