//! Files of the identified robot, read back and compared.

use crate::app::{Code, Error};
use crate::diagnosis::Diagnosis;
use crate::documents::{IdentifyRequest, requests, robot_value, written_diagnosis, written_robot};
use crate::dynamics::inverse_dynamics;
use crate::formats::models::BaseRow;
use crate::formats::{FinalModel, ModelFormat, Patched, urdf, urdf_gravity};
use crate::identification::physical::PhysicalFit;
use crate::model::{ChainEnds, LinkPrior, Robot, Rounding, from_mjcf, from_urdf_rounded};
use crate::parameters::Layout;
use crate::regression::{AugmentedModel, Fitted, Stretch, reported};
use nalgebra::DVector;
use serde_json::Value;

/// The identified robot, the form that others are made of read back and compared with what was identified.
#[derive(Debug, Clone)]
pub struct ModelFiles {
    /// A robot document whose priors are the identified parameters, the effects found, and the base parameters beside it.
    pub json: Value,
    model: FinalModel,
}

impl ModelFiles {
    /// From the JSON model, as it was stored.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn of_json(json: Value) -> Result<Self, Error> {
        let model = FinalModel::read(&json).map_err(|problems| Error::invalid("the model", problems))?;
        Ok(Self { json, model })
    }

    /// The file in a format.
    pub fn text(&self, format: ModelFormat) -> String {
        match format {
            ModelFormat::Json => serde_json::to_string_pretty(&self.json).expect("documents are plain data") + "\n",
            _ => self.model.text(format),
        }
    }

    /// What the file in a format does not hold, a sentence each.
    pub fn remarks(&self, format: ModelFormat) -> Vec<String> {
        self.model.remarks(format.name())
    }

    /// The identified bodies in the user's own URDF file; `base` and `tip` as for the robot.
    ///
    /// # Errors
    /// `invalid_document`: no URDF, or another arm.
    pub fn patched(&self, urdf: &str, base: Option<&str>, tip: Option<&str>) -> Result<Patched, Error> {
        let patched = self.model.patch_urdf(urdf, base, tip);
        patched.map_err(|problems| Error::invalid("the URDF file", problems))
    }
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

/// What an identification has found, and the logs that it is of.
pub(super) struct Found<'a> {
    pub request: &'a IdentifyRequest,
    /// With gravity where the data have it.
    pub robot: &'a Robot,
    pub fitted: &'a Fitted,
    pub fit: &'a PhysicalFit,
    /// The model with base parameters of the bodies.
    pub bodies: &'a AugmentedModel,
    pub diagnosis: &'a Diagnosis,
    pub logs: &'a [Stretch],
    /// Highest cut-off of their row filters [Hz], so that what the model is held against later is of the same band.
    pub band_hz: Option<f64>,
}

pub(super) fn model_files(found: &Found) -> Result<Option<ModelFiles>, Error> {
    let Some(robot) = identified_robot(found.robot, found.fit) else {
        return Ok(None);
    };
    reads_back(&robot)?;
    let mut model = FinalModel::new(robot.clone(), found.fitted.model.terms.clone());
    model.measure(found.bodies, found.logs);
    let written = requests::Model {
        robot: requests::RobotOrName::Robot(requests::Robot::Joints(written_robot(&robot))),
        offsets: offsets(found.request, found.fitted),
        base_parameters: Some(base_rows(found.fitted)),
        augmented: Some(augmented(found)),
        not_in_urdf: Some(model.remarks(ModelFormat::Urdf.name())),
        formats: Some(model.missing.clone()),
        band_hz: found.band_hz,
    };
    let json = serde_json::to_value(written).expect("plain numbers and words");
    let files = ModelFiles::of_json(json);
    let internal = |e: Error| Error::new(Code::Internal, format!("the JSON model does not read back: {}", e.detail));
    files.map(Some).map_err(internal)
}

/// The effects, with deviations of what they report.
fn augmented(found: &Found) -> requests::AugmentedModel {
    let mut written = written_diagnosis(found.diagnosis);
    for (at, (effect, term)) in written.effects.iter_mut().zip(&found.fitted.model.terms).enumerate() {
        let known = reported(term, &found.fitted.term_covariance(at));
        for (parameter, (_, std_dev)) in effect.parameters.iter_mut().flatten().zip(known) {
            parameter.std_dev = Some(std_dev.is_finite().then_some(std_dev));
        }
    }
    written
}

/// The robot as JSON, URDF and MJCF, read back.
fn reads_back(robot: &Robot) -> Result<(), Error> {
    let internal = |what: &str, e: String| Error::new(Code::Internal, format!("the {what} model does not read back: {e}"));
    let parsed = crate::formats::Parsed {
        value: robot_value(robot),
        problems: Vec::new(),
    };
    let from_json = crate::documents::robot_document_rounded(&parsed, Rounding::AsWritten)
        .map_err(|e| internal("JSON", format!("{e:?}")))?
        .robot;
    let whole = (ChainEnds::default(), Rounding::AsWritten);
    let from_xml = from_urdf_rounded(&urdf(robot), urdf_gravity(robot), robot.friction(), whole.0, whole.1)
        .map_err(|e| internal("URDF", e.to_string()))?
        .robot;
    let mjcf = FinalModel::new(robot.clone(), Vec::new()).text(ModelFormat::Mjcf);
    let from_mjcf = from_mjcf(&mjcf, None, robot.friction(), whole.0, whole.1)
        .map_err(|e| internal("MJCF", e.to_string()))?
        .robot;
    for (what, read) in [("JSON", from_json), ("URDF", from_xml), ("MJCF", from_mjcf)] {
        let error = torque_difference(robot, &read);
        if error.is_nan() || error > 1e-9 {
            return Err(internal(what, format!("its torques differ by {error:e} of their size")));
        }
    }
    Ok(())
}

/// Constant torque of every joint, where it was asked for [N·m or N].
fn offsets(request: &IdentifyRequest, found: &Fitted) -> Option<Vec<f64>> {
    let joints = 0..request.robot.joint_count();
    let first = |j: usize| found.estimate.values[found.term_range(j).start];
    request.offset.then(|| joints.map(first).collect())
}

/// The base parameters as estimated.
fn base_rows(found: &Fitted) -> Vec<BaseRow> {
    let (base, estimate) = (&found.base, &found.estimate);
    let known = |c: usize, v: f64| (v.is_finite() && estimate.is_determined(c)).then_some(v);
    let row = |c: usize| BaseRow {
        name: base.names[c].clone(),
        expression: base.expressions[c].to_string(),
        value: known(c, estimate.values[c]),
        std_dev: known(c, estimate.std_dev(c)),
        unit: base.units[c].to_string(),
    };
    (0..base.len()).map(row).collect()
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
