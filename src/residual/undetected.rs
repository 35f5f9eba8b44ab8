//! What every robot may have and the data did not show: how large it could be all the same.

use super::candidate::{Candidate, columns_of};
use super::dependence::estimate;
use super::report::{ReportedParameter, Undetected};
use super::system::{Data, System};

/// Torque offset and rotor inertia of every joint that the model does not have, each by itself beside it. Nothing is told of one that base parameters hide.
pub(super) fn undetected(data: &Data, system: &System, candidates: &[Candidate]) -> Vec<Undetected> {
    let robot = &system.model.robot;
    let doubts = data.doubts(system);
    let is_open = |c: &&Candidate| {
        let single = c.effect.is_everyday() && c.shapes.is_empty() && c.joints.len() == 1;
        single && !system.model.terms.iter().any(|t| c.is_same_effect(t))
    };
    let told = |c: &Candidate| {
        let joint = c.joints[0];
        let columns = columns_of(data, system, c, &[Vec::new()]);
        let found = estimate(system, &columns, joint, doubts[joint])?;
        let parameter = ReportedParameter::of(c.effect.parameters(c.form, robot, &c.joints), [found]).pop()?;
        Some(Undetected {
            effect: c.effect.code().into(),
            joint: robot.joints()[joint].name.clone(),
            parameter,
        })
    };
    candidates.iter().filter(is_open).filter_map(told).collect()
}
