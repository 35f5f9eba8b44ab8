//! Limits along the path that bind all joints together: what a joint's torque may be depends on the motion of the others.
//!
//! Unlike the limits of one joint's motion they are no convex set of its coefficients. The search adds the square of what exceeds
//! them to the criterion, and every local solve ends by drawing the whole motion towards rest until they hold; so what is handed
//! back meets them whatever the weight of the square was.

use super::problem::ProblemSpec;
use crate::model::{FieldProblem, counted};
use crate::parameters::{BaseParameters, Layout};

/// Torque limits, met by the model that the robot's prior link parameters make.
#[derive(Debug, Clone, PartialEq)]
pub struct TorqueLimits {
    /// Largest torque of every joint [N·m or N]; for `None` the efforts of the robot's joints.
    pub limits: Option<Vec<f64>>,
    /// Torques stay below the limit over this factor, at least 1: prior parameters are never right.
    pub safety_factor: f64,
}

/// Factor where none is asked for: catalogue and CAD parameters of links are seldom wrong by more than a quarter in torque.
pub const DEFAULT_SAFETY_FACTOR: f64 = 1.25;

/// Checked limits and the model that predicts torques.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TorqueSet {
    /// Base parameters, of the prior link parameters.
    pub base: Vec<f64>,
    /// Limit over safety factor [N·m or N]; infinite for a joint without limit.
    pub allowed: Vec<f64>,
}

impl TorqueSet {
    /// `None` where no torque limits are asked for, or where `found` now says what is wrong with them.
    pub fn new(spec: &ProblemSpec, layout: &Layout, base: &BaseParameters, found: &mut Vec<FieldProblem>) -> Option<Self> {
        let asked = spec.torque.as_ref()?;
        let before = found.len();
        let factor = asked.safety_factor;
        if !(factor.is_finite() && factor >= 1.0) {
            let detail = format!("is {factor}; torques stay below limit / safety_factor, so it is at least 1");
            found.push(FieldProblem::new("/constraints/torque/safety_factor", detail));
        }
        let limits = limits(spec, asked, found);
        let prior = layout.prior(&spec.robot);
        if prior.is_none() {
            let hint = "give every joint `prior` link parameters (mass, centre of mass, inertia), a URDF with inertials, or an identified model";
            let detail = "torques can only be limited with a model, and the robot has no link parameters";
            found.push(FieldProblem::new("/constraints/torque", detail).with_hint(hint));
        }
        (found.len() == before).then(|| Self {
            base: base.project(prior.expect("checked").as_slice()).as_slice().to_vec(),
            allowed: limits.into_iter().map(|l| l / factor).collect(),
        })
    }
}

fn limits(spec: &ProblemSpec, asked: &TorqueLimits, found: &mut Vec<FieldProblem>) -> Vec<f64> {
    let joints = spec.robot.joints();
    let Some(given) = &asked.limits else {
        if joints.iter().all(|j| j.limits.effort.is_none()) {
            let detail = "asks for the robot's own torque limits, and no joint has an `effort` limit";
            let hint = "give `limits.effort` of the joints, or `constraints.torque.limits`";
            found.push(FieldProblem::new("/constraints/torque", detail).with_hint(hint));
        }
        return joints.iter().map(|j| j.limits.effort.unwrap_or(f64::INFINITY)).collect();
    };
    if given.len() != joints.len() {
        let detail = format!(
            "has {}, the robot has {}",
            counted(given.len(), "value"),
            counted(joints.len(), "joint")
        );
        found.push(FieldProblem::new("/constraints/torque/limits", detail));
    }
    for (i, &limit) in given.iter().enumerate() {
        if !(limit.is_finite() && limit > 0.0) {
            let detail = format!("is {limit}; a torque limit is a positive number of N m or N");
            found.push(FieldProblem::new(format!("/constraints/torque/limits/{i}"), detail));
        }
    }
    given.clone()
}
