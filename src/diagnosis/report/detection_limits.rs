//! What every robot may have and the data did not show: how large it could be all the same.

use super::findings::reported_parameters;
use super::parameter::ReportedParameter;
use super::result::Undetected;
use crate::diagnosis::selection::{Candidate, columns_of};
use crate::regression::{AugmentedModel, Data, System, single_estimate};
use nalgebra::DMatrix;
use std::ops::Range;

/// Torque offset and rotor inertia of every joint that the model does not have, each by itself beside it. Nothing is reported for
/// one that base parameters hide.
pub(crate) fn undetected(data: &Data, system: &System, candidates: &[Candidate]) -> Vec<Undetected> {
    let robot = &system.model.robot;
    let doubts = data.doubts(system);
    let is_open = |c: &&Candidate| {
        let single = c.effect.is_everyday() && c.shapes.is_empty() && c.joints.len() == 1;
        single && !system.model.terms.iter().any(|t| c.is_same_effect(t))
    };
    let reported = |c: &Candidate| {
        let joint = c.joints[0];
        let columns = columns_of(data, system, c, &[Vec::new()]);
        let found = single_estimate(system, &columns, joint, doubts[joint])?;
        let parameter = ReportedParameter::of(c.effect.parameters(c.form, robot, &c.joints), [found]).pop()?;
        Some(Undetected {
            effect: c.effect.code().into(),
            joint: robot.joints()[joint].name.clone(),
            parameter,
            in_model: false,
        })
    };
    candidates.iter().filter(is_open).filter_map(reported).collect()
}

/// The nuisance offsets of the model, terms `range`, with what is known of each.
pub(crate) fn nuisance(
    model: &AugmentedModel,
    range: Range<usize>,
    covariance: impl Fn(usize) -> DMatrix<f64>,
) -> Vec<Undetected> {
    let of = |at: usize| {
        let term = &model.terms[at];
        let parameter = reported_parameters(&model.robot, term, &covariance(at)).pop()?;
        Some(Undetected {
            effect: term.effect.code().into(),
            joint: model.robot.joints()[*term.joints.first()?].name.clone(),
            parameter,
            in_model: true,
        })
    };
    range.filter_map(of).collect()
}
