//! The whole course: from stretches of data to a report and an augmented model.

use super::held_out::{Judge, decide};
use super::outcome::{Diagnosis, Estimates};
use super::search::{Searched, searched};
use super::stability::survivals;
use crate::cancel::CancelFlag;
use crate::diagnosis::alternatives::{Contest, RivalTerm, border};
use crate::diagnosis::nonparametric::unaccounted;
use crate::diagnosis::replicates::separate;
use crate::diagnosis::replicates::{Separated, joined, remainder_of, trends};
use crate::diagnosis::report::{
    Finding, HeldOutVerdict, NotTested, ResidualReport, Rival, Told, Verdict, at_rest, between_findings, findings, fits,
    nuisance, rms, undetected,
};
use crate::diagnosis::selection::{Threshold, candidates, honest_covariance};
use crate::model::Robot;
use crate::regression::{
    AugmentedModel, Data, Estimator, NoiseModel, NoiseSource, Prior, Stretch, System, Term, estimated, explained_share, floor,
    spans,
};
use nalgebra::{DMatrix, DVector};

/// What can be asked of the tracing.
#[derive(Debug, Clone)]
pub struct DiagnosisOptions {
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

impl Default for DiagnosisOptions {
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

impl DiagnosisOptions {
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

/// Traces what `robot`'s declared model leaves over on `stretches`. `held_out` is only ever predicted: it fits nothing, and has the last word on what
/// stays in the model.
pub fn diagnose(robot: &Robot, stretches: &[Stretch], held_out: &[Stretch], options: &DiagnosisOptions) -> Diagnosis {
    let start = options.start(robot);
    let prior = options.existing.as_ref().map(|(_, prior)| prior);
    let Separated {
        steady,
        explained,
        found: between,
        mut unsteady,
    } = match options.search {
        true => separate(robot, stretches, options.chance),
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
    let share = explained_share(&AugmentedModel::declared(robot), measured);
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
    Diagnosis {
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
