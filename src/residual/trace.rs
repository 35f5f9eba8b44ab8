//! The whole course: from stretches of data to a report and an augmented model.

use super::between::{self, Separated};
use super::border::{RivalTerm, border};
use super::candidate::candidates;
use super::confirm::{Searched, searched};
use super::findings::{between_findings, findings};
use super::misfit::{at_rest, fits, rms};
use super::report::Outcome;
use super::rivals::Contest;
use super::select::Threshold;
use super::stretch::spans;
use super::system::{Data, Prior, System};
use super::trend::trends;
use super::undetected::undetected;
use super::unsteady::{joined, remainder_of};
use super::{AugmentedModel, Finding, NoiseModel, NoiseSource, ResidualReport, Rival, Stretch, Term, Verdict};
use crate::model::Robot;
use nalgebra::DVector;

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
}

impl Default for TraceOptions {
    fn default() -> Self {
        Self {
            chance: 1e-3,
            existing: None,
            offsets: false,
            most_effects_per_joint: 3,
        }
    }
}

/// Report, model and noise.
pub type Traced = Outcome;

/// Traces what `robot`'s declared model leaves over on `stretches`. `held_out` is only ever predicted: it chooses nothing.
pub fn trace(robot: &Robot, stretches: &[Stretch], held_out: &[Stretch], options: &TraceOptions) -> Traced {
    let start = options
        .existing
        .as_ref()
        .map_or_else(|| declared(robot, stretches, options), |(model, _)| model.clone());
    let prior = options.existing.as_ref().map(|(_, prior)| prior);
    let Separated {
        steady,
        explained,
        found: between,
        mut unsteady,
    } = between::separate(robot, stretches, options.chance);
    let measured = stretches;
    let stretches = &steady[..];
    // What to add is found on the coarse forms, which have the same rows; values and errors are those of all samples.
    let coarse: Vec<Stretch> = stretches.iter().map(Stretch::as_coarse).collect();
    let mut data = Data::new(&coarse, Vec::new(), prior).for_comparison();
    data.noise = floor(robot, &data, &start);
    let fine = Data::new(stretches, data.noise.clone(), prior);
    let first = fine.fit(start.clone());
    let lack_of_fit = fits(&fine, &first);
    let threshold = Threshold {
        chance: options.chance,
        share: 0.05,
        generalises: 0.5,
        most_effects: options.most_effects_per_joint * robot.joint_count(),
    };
    let list = candidates(&start, &spans(stretches), prior.is_some());
    let Searched {
        data,
        system,
        accepted,
        contests,
        remainder: rest,
    } = searched(&data, &fine, start.clone(), &list, &threshold);
    unsteady.extend(trends(&data, &system, options.chance));
    let rest = joined(rest, remainder_of(robot, &unsteady));
    let after = fits(&data, &system);
    let verdict = verdict(accepted.len() + between.len(), rest.is_some());
    // What nothing explains was kept from the fits, and stays in the errors.
    let stretches = &explained[..];
    let before_rms = rms(&first.model, stretches, held_out);
    let findings = findings(&data, [stretches, held_out], &start, &system, &accepted, &contests);
    let mut all: Vec<Finding> = between_findings(robot, between, &first.model, measured, stretches, held_out);
    all.extend(findings);
    let report = ResidualReport {
        noise_floor: data.noise.iter().map(|n| n.std_dev).collect(),
        noise_source: source(&data.noise),
        lack_of_fit,
        verdict,
        data_faults: Vec::new(),
        findings: all,
        remainder: rest,
        undetected: undetected(&data, &system, &list),
        lack_of_fit_after: after,
        rms_before: before_rms,
        rms_after: rms(&system.model, stretches, held_out),
        at_rest: at_rest(&first.model, &system.model, stretches, held_out),
    };
    let mut rival_terms = vec![Vec::new(); start.terms.len()];
    rival_terms.extend(contests.iter().map(|c| rival_terms_of(&data, &system, c)));
    Outcome {
        report,
        rival_terms,
        rate_hz: rate(stretches),
        information: data.known(&system),
        model: system.model,
        noise: data.noise,
    }
}

/// The declared model, its offsets as terms of their own.
fn declared(robot: &Robot, stretches: &[Stretch], options: &TraceOptions) -> AugmentedModel {
    let mut model = AugmentedModel::declared(robot);
    let all = candidates(&model, &spans(stretches), false);
    let offsets = all.iter().filter(|c| options.offsets && c.effect.code() == "torque_offset");
    model.terms.extend(offsets.map(|c| c.term(&[0.0], &[])));
    model
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

fn verdict(findings: usize, something_left: bool) -> Verdict {
    match (findings, something_left) {
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
    let unit = NoiseModel {
        source: NoiseSource::Residual,
        std_dev: 1.0,
        autoregression: Vec::new(),
        innovation: 1.0,
        degrees_of_freedom: 1.0,
    };
    let mut noise = vec![unit; model.robot.joint_count()];
    for _ in 0..2 {
        let weighted = data.with_noise(noise);
        let system = weighted.fit(model.clone());
        noise = weighted.left_as_noise(&system);
    }
    noise
}
