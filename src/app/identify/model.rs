//! Files of the identified robot, read back and compared.

use crate::app::{Code, Error};
use crate::dynamics::inverse_dynamics;
use crate::identification::physical::PhysicalFit;
use crate::io::{IdentifyRequest, robot_value, urdf, urdf_gravity};
use crate::model::{ChainEnds, LinkPrior, Robot, Rounding, from_urdf_rounded};
use crate::parameters::Layout;
use crate::residual::Fitted;
use nalgebra::DVector;
use serde_json::{Value, json};

/// The identified robot, each form read back and compared with what was identified.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelFiles {
    /// A robot document whose priors are the identified parameters, and the base parameters beside it.
    pub json: Value,
    pub urdf: String,
}

/// The robot with the identified parameters as its priors; `None` if they are no bodies.
fn identified_robot(robot: &Robot, fit: &PhysicalFit) -> Option<Robot> {
    let links = fit.links(&Layout::standard(robot))?;
    let joints = robot.joints().iter().zip(links).map(|(joint, link)| {
        // Interior points end within rounding of a bound: friction of −1e-12 is none.
        let prior = LinkPrior {
            inertia: link.inertia,
            viscous: link.viscous.max(0.0),
            coulomb: link.coulomb.max(0.0),
        };
        crate::model::Joint {
            prior: Some(prior),
            ..joint.clone()
        }
    });
    Robot::new(robot.name(), robot.gravity(), joints.collect(), robot.friction()).ok()
}

pub(super) fn model_files(
    request: &IdentifyRequest,
    declared: &Robot,
    found: &Fitted,
    fit: &PhysicalFit,
) -> Result<Option<ModelFiles>, Error> {
    let Some(robot) = identified_robot(declared, fit) else {
        return Ok(None);
    };
    let robot_json = robot_value(&robot);
    let files = ModelFiles {
        json: model_value(request, &robot_json, found),
        urdf: urdf(&robot),
    };
    let internal = |what: &str, e: String| Error::new(Code::Internal, format!("the {what} model does not read back: {e}"));
    let parsed = crate::io::Parsed {
        value: robot_json,
        problems: Vec::new(),
    };
    let from_json = crate::io::robot_document_rounded(&parsed, Rounding::AsWritten)
        .map_err(|e| internal("JSON", format!("{e:?}")))?
        .robot;
    let from_xml = from_urdf_rounded(
        &files.urdf,
        urdf_gravity(&robot),
        robot.friction(),
        ChainEnds::default(),
        Rounding::AsWritten,
    )
    .map_err(|e| internal("URDF", e.to_string()))?
    .robot;
    for (what, read) in [("JSON", from_json), ("URDF", from_xml)] {
        let error = torque_difference(&robot, &read);
        if error.is_nan() || error > 1e-9 {
            return Err(internal(what, format!("its torques differ by {error:e} of their size")));
        }
    }
    Ok(Some(files))
}

/// The JSON model: the robot with its parameters, the offsets, and the base parameters as estimated.
fn model_value(request: &IdentifyRequest, robot: &Value, found: &Fitted) -> Value {
    let (base, estimate) = (&found.base, &found.estimate);
    let offsets = request.offset.then(|| {
        (0..request.robot.joint_count())
            .map(|j| estimate.values[found.term_range(j).start])
            .collect::<Vec<f64>>()
    });
    let value = |c: usize| estimate.is_determined(c).then_some(estimate.values[c]);
    let one = |c: usize| json!({"name": base.names[c], "value": value(c), "unit": base.units[c]});
    json!({"robot": robot, "offsets": offsets, "base_parameters": (0..base.len()).map(one).collect::<Vec<_>>()})
}

/// Largest difference of torques between two robots at a few states, relative to the largest torque. Both are the same numbers in
/// other frames, so that only the rounding of angles written as text (1e-16 each) separates them.
fn torque_difference(a: &Robot, b: &Robot) -> f64 {
    if a.joint_count() != b.joint_count() {
        return f64::INFINITY;
    }
    let layout = Layout::standard(a);
    let (Some(phi), Some(psi)) = (layout.prior(a), layout.prior(b)) else {
        return f64::INFINITY;
    };
    let (mut worst, mut largest) = (0.0f64, f64::MIN_POSITIVE);
    for k in 0..10 {
        let state = |phase: f64, size: f64| -> Vec<f64> {
            (0..a.joint_count())
                .map(|j| size * (phase + 1.7 * (k * 7 + j) as f64).sin())
                .collect()
        };
        let (q, qd, qdd) = (state(0.0, 2.0), state(1.0, 1.0), state(2.0, 3.0));
        let one = DVector::from(inverse_dynamics(a, &layout, phi.as_slice(), &q, &qd, &qdd));
        let two = DVector::from(inverse_dynamics(b, &layout, psi.as_slice(), &q, &qd, &qdd));
        worst = worst.max((&one - two).amax());
        largest = largest.max(one.amax());
    }
    worst / largest
}
