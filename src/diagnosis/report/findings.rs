//! Accepted effects as findings: values with deviations, errors before and after, and what should be known about them.

use super::lack_of_fit::rms;
use super::parameter::{ReportedParameter, joint_names};
use super::result::{Change, Covered, Evaluated, Evidence, Finding, FindingHeldOut, RmsPair};
use crate::diagnosis::alternatives::Contest;
use crate::diagnosis::replicates::BetweenFinding;
use crate::diagnosis::selection::Accepted;
use crate::diagnosis::settings::SETTINGS;
use crate::diagnosis::stability::Survival;
use crate::effects::law::is_law;
use crate::model::Robot;
use crate::regression::{AugmentedModel, Data, Estimator, Stretch, Term, estimated, reported};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Drift and contacts as findings; the error before is that of the data as measured.
pub(crate) fn between_findings(
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

/// What a finding is made of: the effects in the order of the decision, those that stay first.
pub(crate) struct FindingInputs<'a> {
    pub data: &'a Data<'a>,
    pub estimator: Estimator,
    /// The model without the effects, and the final one.
    pub declared: &'a AugmentedModel,
    /// Offsets that are estimated beside the effects without being findings.
    pub nuisance: &'a [Term],
    pub last: &'a AugmentedModel,
    /// Covariances of the effects' parameters: of those that stay by the final estimate, of the others by the fit that had them.
    pub covariances: Vec<DMatrix<f64>>,
    /// Terms of all effects, in the same order.
    pub terms: Vec<Term>,
    pub stay: usize,
    pub held_out: Vec<FindingHeldOut>,
    pub accepted: Vec<Accepted>,
    pub contests: Vec<Contest>,
    /// Of the effects that stay.
    pub survivals: Vec<Vec<Survival>>,
}

/// One finding per effect; before and after by fitting the model with the effects up to it, and of those that do not stay with
/// all that stay and it. `measured` are the stretches that errors are of, and the held-out ones.
pub(crate) fn findings(inputs: &FindingInputs, measured: [&[Stretch]; 2]) -> Vec<Finding> {
    // Nuisance offsets come with the first offset that was found.
    let first = inputs.terms[..inputs.stay]
        .iter()
        .position(|t| t.effect.code() == "torque_offset");
    let with = |terms: Vec<Term>| {
        let mut model = inputs.declared.clone();
        if terms.len() > first.unwrap_or(0) {
            model.terms.extend(inputs.nuisance.iter().cloned());
        }
        model.terms.extend(terms);
        estimated_model(inputs.data, model, inputs.estimator)
    };
    let errors = |count: usize| {
        let model = match count {
            0 => inputs.declared.clone(),
            all if all == inputs.stay => inputs.last.clone(),
            some if some < inputs.stay => with(inputs.terms[..some].to_vec()),
            // Beyond those that stay: all of them and this one.
            one => with(
                inputs.terms[..inputs.stay]
                    .iter()
                    .chain([&inputs.terms[one - 1]])
                    .cloned()
                    .collect(),
            ),
        };
        rms(&model, measured[0], measured[1])
    };
    let errors: Vec<RmsPair> = (0..inputs.terms.len() + 1)
        .into_par_iter()
        .with_max_len(1)
        .map(errors)
        .collect();
    let one = |i: usize| finding(inputs, i, errors[i.min(inputs.stay)].clone(), errors[i + 1].clone());
    (0..inputs.terms.len()).map(one).collect()
}

/// The model fitted by `estimator`, without what is known of it.
fn estimated_model(data: &Data, model: AugmentedModel, estimator: Estimator) -> AugmentedModel {
    match estimator {
        Estimator::Weighted => data.fit(model).model,
        _ => estimated(data, &model, estimator).model,
    }
}

/// Values and deviations of what a term reports, its coefficients made physically consistent.
pub fn reported_parameters(robot: &Robot, term: &Term, covariance: &DMatrix<f64>) -> Vec<ReportedParameter> {
    let mut term = term.clone();
    let k = term.coefficients.len();
    if let Some(information) = covariance.view((0, 0), (k, k)).into_owned().try_inverse().filter(|_| k > 0) {
        term.coefficients = term.effect.consistent(&term.coefficients, &information);
    }
    let names = term.effect.parameters(term.form, robot, &term.joints);
    ReportedParameter::of(names, reported(&term, covariance))
}

fn finding(inputs: &FindingInputs, at: usize, rms_before: RmsPair, rms_after: RmsPair) -> Finding {
    let robot = &inputs.last.robot;
    let (term, accepted, contest) = (&inputs.terms[at], &inputs.accepted[at], &inputs.contests[at]);
    Finding {
        effect: accepted.effect.clone(),
        joints: joint_names(robot, &term.acts_on()),
        formula: term.effect.formula(term.form, &term.joints),
        covered: covered(inputs, term),
        parameters: reported_parameters(robot, term, &inputs.covariances[at]),
        rms_before,
        rms_after,
        evidence: Evidence {
            gain: accepted.gain,
            log_evidence_ratio: accepted.evidence,
            p_value: accepted.p_value,
            held_out_blocks: Evaluated::Value(accepted.held_out.blocks),
            held_out_periods: accepted.held_out.periods.into(),
        },
        note: note(contest, &inputs.held_out[at], provisional(term, accepted.gain)),
        held_out: inputs.held_out[at].clone(),
        in_model: at < inputs.stay,
        rivals: contest.rivals.clone(),
        survivals: inputs.survivals.get(at).cloned().unwrap_or_default(),
    }
}

/// Weak laws: that something is there is beyond doubt, which formula it has is not.
fn provisional(term: &Term, gain: f64) -> Option<String> {
    let weak = gain < SETTINGS.laws.provisional && is_law(&term.effect);
    weak.then(|| "the formula is provisional: with so little evidence the structure may be another".to_string())
}

/// Ranges of the variables of a formula.
fn covered(inputs: &FindingInputs, term: &Term) -> Vec<Covered> {
    let Some(formula) = term.effect.formula(term.form, &term.joints) else {
        return Vec::new();
    };
    let robot = &inputs.last.robot;
    let joints = 0..robot.joint_count();
    let range = |variable: String, unit: String, values: &dyn Fn(&Stretch) -> Vec<f64>| {
        let all = inputs.data.stretches.iter().flat_map(values);
        let [low, high] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        Covered {
            variable,
            low,
            high,
            unit,
        }
    };
    let of = |j: usize| {
        let unit = robot.joints()[j].position_unit();
        [
            range(format!("q{}", j + 1), unit.into(), &|s| s.motion.positions(j).to_vec()),
            range(format!("qd{}", j + 1), format!("{unit}/s"), &|s| {
                s.motion.velocities(j).to_vec()
            }),
            range(format!("qdd{}", j + 1), format!("{unit}/s^2"), &|s| {
                s.motion.accelerations(j).to_vec()
            }),
        ]
    };
    let all = joints.flat_map(of);
    all.filter(|c| formula.variables.contains(&c.variable)).collect()
}

/// What should be known about a finding: that another explains more, or what held-out data say against it.
fn note(contest: &Contest, held_out: &FindingHeldOut, provisional: Option<String>) -> Option<String> {
    let against = match held_out.change {
        Change::Same => Some("the error on held-out data did not change beyond chance".to_string()),
        Change::Worse => Some("the error on held-out data rose beyond chance: the effect is not in the model".to_string()),
        Change::Better | Change::NotTested => None,
    };
    let said: Vec<String> = contest.note.clone().into_iter().chain(provisional).chain(against).collect();
    (!said.is_empty()).then(|| said.join("; "))
}
