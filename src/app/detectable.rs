//! What a designed recording would reveal.

use crate::diagnosis::{DiagnosisOptions, Plan, SETTINGS, detectable};
use crate::documents::{Assessed, ExcitationRequest};
use crate::effects::OwnEffect;
use crate::excitation::{Design, Problem};
use crate::model::Robot;
use crate::parameters::Layout;
use crate::regression::{AugmentedModel, Term};
use crate::trajectory::FourierSeries;
use std::sync::Arc;

/// Torque noise of an arm of which nothing is said, as part of the largest torque of each joint: a thousandth. Torque sensors in
/// joints resolve that (0.3 N m of the 320 N m of an iiwa's first joints); motor currents scatter by several times as much.
const NOISE_SHARE: f64 = 1e-3;

/// Fewer do not measure the noise.
const FEWEST_PERIODS: f64 = 2.0;

/// The model that a diagnosis of the recording starts from, and its noise.
pub(super) struct Basis {
    model: AugmentedModel,
    torque_noise: Vec<f64>,
    noise_source: &'static str,
    own: Vec<Arc<OwnEffect>>,
}

impl Basis {
    pub fn new(request: &ExcitationRequest) -> Self {
        let (torque_noise, noise_source) = noise(request);
        Self {
            model: with_declared(model(request), &request.own),
            torque_noise,
            noise_source,
            own: request.own.clone(),
        }
    }

    /// What all trajectories together would reveal; nothing without one, or of an arm with more joints than are assessed.
    pub fn assess<'a>(&'a self, designs: &'a [(Problem, Design)], series: &'a [&'a FourierSeries]) -> Option<Assessed<'a>> {
        let spec = designs.first().filter(|(_, d)| d.criteria.is_some())?.0.spec();
        if spec.robot.joint_count() > SETTINGS.detectable.most_joints {
            return None;
        }
        let plan = Plan {
            model: &self.model,
            series,
            rate_hz: spec.sample_rate_hz,
            periods: spec.knowledge.periods.max(FEWEST_PERIODS),
            torque_noise: &self.torque_noise,
            own: &self.own,
            chance: DiagnosisOptions::default().chance,
        };
        Some(Assessed {
            plan,
            noise_source: self.noise_source,
            found: detectable(&plan),
        })
    }
}

/// Effects of the request's model are known already, at its values; else the declared model at the robot's priors.
fn model(request: &ExcitationRequest) -> AugmentedModel {
    let robot = request.problem.robot();
    let declared = AugmentedModel::declared(robot);
    let known = request.effects.known.as_ref().filter(|k| k.base.names == declared.base.names);
    if let Some(known) = known {
        let (values, terms) = (known.values.clone(), known.terms.clone());
        return AugmentedModel {
            values,
            terms,
            ..declared
        };
    }
    match Layout::standard(robot).prior(robot) {
        Some(phi) => AugmentedModel {
            values: declared.base.project(phi.as_slice()),
            ..declared
        },
        None => declared,
    }
}

/// The model with the declared effects of the robot, which an identification of the recording has from the start, at the middle
/// of what it searches.
fn with_declared(mut model: AugmentedModel, own: &[Arc<OwnEffect>]) -> AugmentedModel {
    let is_known = |effect: &OwnEffect| {
        let names = model.terms.iter().filter_map(|t| t.effect.own());
        names
            .map(|o| &o.definition().name)
            .any(|name| *name == effect.definition().name)
    };
    let declared: Vec<Term> = own.iter().filter(|e| e.is_declared() && !is_known(e)).map(unseen).collect();
    model.terms.extend(declared);
    model
}

/// An own effect without a size.
fn unseen(effect: &Arc<OwnEffect>) -> Term {
    let mut grid = effect.grid();
    let shape = grid.swap_remove(grid.len() / 2);
    Term {
        effect: effect.clone().into(),
        form: 0,
        joints: vec![effect.joint()],
        coefficients: vec![0.0; effect.coefficients()],
        shape,
        // Without a size its shape changes nothing.
        free_shapes: 0,
        bounds: Vec::new(),
    }
}

fn noise(request: &ExcitationRequest) -> (Vec<f64>, &'static str) {
    let robot = request.problem.robot();
    match &request.problem.spec().torque_noise {
        Some(given) if request.document["torque_noise"].is_array() => (given.clone(), "request"),
        Some(of_model) => (of_model.clone(), "model"),
        None => match of_effort(robot) {
            Some(list) => (list, "effort_limits"),
            None => (vec![1.0; robot.joint_count()], "unit"),
        },
    }
}

fn of_effort(robot: &Robot) -> Option<Vec<f64>> {
    let of = |joint: &crate::model::Joint| {
        joint
            .limits
            .effort
            .filter(|e| e.is_finite() && *e > 0.0)
            .map(|e| NOISE_SHARE * e)
    };
    robot.joints().iter().map(of).collect()
}
