//! Accepted effects told as findings: values with deviations, errors before and after, and what should be known about them.

use super::between::BetweenFinding;
use super::confirm::honest_covariance;
use super::misfit::rms;
use super::model::reported;
use super::rivals::Contest;
use super::select::Accepted;
use super::system::{Data, System};
use super::{AugmentedModel, Evidence, Finding, ReportedParameter, RmsPair, Stretch};
use crate::model::Robot;
use rayon::prelude::*;

/// Drift and contacts as findings; the error before is that of the data as measured.
pub(super) fn between_findings(
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

/// One finding per accepted effect; before and after by fitting the model with the effects up to it, from `start` to `last`. `told` are the stretches that
/// errors are told of.
pub(super) fn findings(
    data: &Data,
    told: [&[Stretch]; 2],
    start: &AugmentedModel,
    last: &System,
    accepted: &[Accepted],
    contests: &[Contest],
) -> Vec<Finding> {
    let fixed = start.terms.len();
    let with = |count: usize| {
        if count == accepted.len() {
            return last.model.clone();
        }
        let mut model = start.clone();
        model.terms.extend(last.model.terms[fixed..fixed + count].iter().cloned());
        data.fit(model).model
    };
    let errors: Vec<RmsPair> = (0..accepted.len() + 1)
        .into_par_iter()
        .with_max_len(1)
        .map(|count| rms(&with(count), told[0], told[1]))
        .collect();
    let one = |(i, a): (usize, &Accepted)| finding(last, fixed + i, a, &contests[i], errors[i].clone(), errors[i + 1].clone());
    accepted.iter().enumerate().map(one).collect()
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
    let parameters = ReportedParameter::of(names, values);
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
