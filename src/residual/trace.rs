//! The whole course: from stretches of data to a report and an augmented model.

use super::between::{self, BetweenFinding, Separated};
use super::border::{RivalTerm, border};
use super::candidate::candidates;
use super::confirm::{confirmed, honest_covariance};
use super::model::reported;
use super::remainder;
use super::report::Outcome;
use super::rivals::{Contest, rivals, settled};
use super::select::{Accepted, Selected, Threshold, select};
use super::stretch::spans;
use super::system::{Data, Prior, System};
use super::trend::trends;
use super::unsteady::{joined, remainder_of};
use super::{
    AugmentedModel, Evidence, Finding, JointFit, NoiseModel, NoiseSource, ReportedParameter, ResidualReport, Rival, RmsPair,
    Stretch, Term, Verdict,
};
use crate::model::Robot;
use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// What can be asked of the tracing.
#[derive(Debug, Clone)]
pub struct TraceOptions {
    /// Largest chance of a false finding in one log. One in a thousand: a false finding is worse than a miss, because somebody will
    /// compensate for it.
    pub chance: f64,
    /// An existing model and its information, when the question is what has changed since.
    pub existing: Option<(AugmentedModel, Prior)>,
    /// A bound on the search: friction laws of one joint have at most three parts beside viscous and Coulomb (Bittencourt & Gunnarsson 2012).
    pub most_effects_per_joint: usize,
}

impl Default for TraceOptions {
    fn default() -> Self {
        Self {
            chance: 1e-3,
            existing: None,
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
        .map_or_else(|| AugmentedModel::declared(robot), |(model, _)| model.clone());
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
    let fixed = start.terms.len();
    let selected = select(&data, start.clone(), &list, &threshold);
    let (selected, mut contests) = settled(&data, selected, fixed, &list, &threshold);
    let data = data.with_noise(selected.noise.clone());
    let (selected, rest) = remainder::examine(&data, selected, fixed, &list, &threshold);
    if rest.is_some() || selected.accepted.len() != contests.len() {
        contests = rivals(&data, &selected, fixed, &list, &threshold);
    }
    unsteady.extend(trends(&data, &selected.system, options.chance));
    let rest = joined(rest, remainder_of(robot, &unsteady));
    let data = fine.with_noise(data.noise);
    let Selected {
        system, mut accepted, ..
    } = selected;
    let system = data.fit(system.model);
    let system = confirmed(&data, system, fixed, &mut accepted, &mut contests, options.chance);
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
        lack_of_fit_after: after,
        rms_before: before_rms,
        rms_after: rms(&system.model, stretches, held_out),
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

/// Drift and contacts as findings; the error before is that of the data as measured.
fn between_findings(
    robot: &Robot,
    between: Vec<BetweenFinding>,
    model: &AugmentedModel,
    measured: &[Stretch],
    cleaned: &[Stretch],
    held_out: &[Stretch],
) -> Vec<Finding> {
    if between.is_empty() {
        return Vec::new();
    }
    let (before, after) = (rms(model, measured, held_out), rms(model, cleaned, held_out));
    between
        .into_iter()
        .map(|mut b| {
            b.rms = Some((before.clone(), after.clone()));
            b.finding(robot, &before)
        })
        .collect()
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

/// Lack of fit per joint: F of the whitened residual's mean square against the noise.
fn fits(data: &Data, system: &System) -> Vec<JointFit> {
    (0..data.noise.len())
        .map(|j| {
            let noise = &data.noise[j];
            let freedom = (system.rows(j) as f64 - system.spent(j)).max(1.0);
            let statistic = system.joint_chi_square(j) / freedom;
            let p_value = FisherSnedecor::new(freedom, noise.degrees_of_freedom.max(1.0)).map_or(f64::NAN, |f| f.sf(statistic));
            let (sum, count, repetitions) = raw_residual(data, system, j);
            JointFit {
                joint: system.model.robot.joints()[j].name.clone(),
                statistic,
                p_value,
                degrees_of_freedom: [freedom, noise.degrees_of_freedom],
                residual_rms: (sum / count.max(1.0)).sqrt(),
                expected_rms: noise.std_dev / repetitions.sqrt(),
            }
        })
        .collect()
}

/// Sum of squares of the mean residual of a joint, rows, and repetitions.
fn raw_residual(data: &Data, system: &System, joint: usize) -> (f64, f64, f64) {
    let (mut sum, mut count) = (0.0, 0.0);
    for (stretch, (e, blocks)) in data.stretches.iter().zip(system.evaluated.iter().zip(&system.blocks)) {
        let rows = blocks[joint]
            .rows
            .iter()
            .zip(stretch.torque[joint].iter().zip(&e.torque[joint]));
        for (_, (y, f)) in rows.filter(|(keep, _)| **keep) {
            sum += (y - f) * (y - f);
            count += 1.0;
        }
    }
    (sum, count, data.stretches.first().map_or(1, Stretch::repetitions) as f64)
}

/// RMS of single measurements about a model, per joint.
pub(super) fn rms(model: &AugmentedModel, identification: &[Stretch], held_out: &[Stretch]) -> RmsPair {
    RmsPair {
        identification: rms_over(model, identification),
        held_out: rms_over(model, held_out),
    }
}

fn rms_over(model: &AugmentedModel, stretches: &[Stretch]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); if stretches.is_empty() { 0 } else { stretches[0].joints() }];
    for stretch in stretches {
        let e = model.evaluate(stretch, None);
        for (j, total) in sums.iter_mut().enumerate() {
            let keep = stretch.kept(&e.motion, j);
            let single = [stretch.torque.clone()];
            let records = if stretch.periods.is_empty() {
                &single[..]
            } else {
                &stretch.periods[..]
            };
            for record in records {
                for s in (0..keep.len()).filter(|&s| keep[s]) {
                    total.0 += (record[j][s] - e.torque[j][s]).powi(2);
                    total.1 += 1.0;
                }
            }
        }
    }
    sums.into_iter()
        .map(|(sum, count): (f64, f64)| (sum / count.max(1.0)).sqrt())
        .collect()
}

/// One finding per accepted effect; before and after by fitting the model with the effects up to it. Errors are those on the stretches told.
fn findings(
    data: &Data,
    told: [&[Stretch]; 2],
    start: &AugmentedModel,
    last: &System,
    accepted: &[Accepted],
    contests: &[Contest],
) -> Vec<Finding> {
    let fixed = start.terms.len();
    let errors = |model: AugmentedModel| rms(&data.fit(model).model, told[0], told[1]);
    let mut before = errors(start.clone());
    let mut list = Vec::new();
    for (i, a) in accepted.iter().enumerate() {
        let mut model = start.clone();
        model.terms.extend(last.model.terms[fixed..=fixed + i].iter().cloned());
        let after = errors(model);
        list.push(finding(last, fixed + i, a, &contests[i], before, after.clone()));
        before = after;
    }
    list
}

fn finding(last: &System, at: usize, accepted: &Accepted, contest: &Contest, rms_before: RmsPair, rms_after: RmsPair) -> Finding {
    let robot = &last.model.robot;
    let term_joints = &last.model.terms[at].joints;
    let joints: Vec<usize> = if term_joints.is_empty() {
        (0..robot.joint_count()).collect()
    } else {
        term_joints.clone()
    };
    let covariance = honest_covariance(last, at);
    let mut term = last.model.terms[at].clone();
    let k = term.coefficients.len();
    if let Some(information) = covariance.view((0, 0), (k, k)).into_owned().try_inverse().filter(|_| k > 0) {
        term.coefficients = term.effect.consistent(&term.coefficients, &information);
    }
    let values = reported(&term, &covariance);
    let names = term.effect.parameters(term.form, robot, &term.joints);
    let parameters = names
        .into_iter()
        .zip(values)
        .map(|(info, (value, std_dev))| ReportedParameter {
            name: info.name,
            value,
            unit: info.unit,
            std_dev,
        })
        .collect();
    Finding {
        effect: accepted.effect.into(),
        joints: joint_names(robot, &term.joints),
        parameters,
        note: note(contest, &joints, &rms_before, &rms_after),
        rms_before,
        rms_after,
        evidence: Evidence {
            gain: accepted.gain,
            log_evidence_ratio: accepted.evidence,
            p_value: accepted.p_value,
            held_out_blocks: accepted.held_out.blocks,
            held_out_periods: accepted.held_out.periods,
        },
        rivals: contest.rivals.clone(),
    }
}

/// What should be known about a finding: that another explains more, or that it did not help on data that it was not fitted to.
fn note(contest: &Contest, joints: &[usize], before: &RmsPair, after: &RmsPair) -> Option<String> {
    let sum = |rms: &RmsPair| joints.iter().filter_map(|&j| rms.held_out.get(j)).map(|v| v * v).sum::<f64>();
    let worse = (sum(after) > sum(before)).then(|| "the error on held-out data did not fall".to_string());
    let said: Vec<String> = contest.note.clone().into_iter().chain(worse).collect();
    (!said.is_empty()).then(|| said.join("; "))
}

/// Names of the joints; all of them for an effect of the whole robot.
pub(super) fn joint_names(robot: &Robot, joints: &[usize]) -> Vec<String> {
    let name = |j: usize| robot.joints()[j].name.clone();
    if joints.is_empty() {
        (0..robot.joint_count()).map(name).collect()
    } else {
        joints.iter().map(|&j| name(j)).collect()
    }
}
