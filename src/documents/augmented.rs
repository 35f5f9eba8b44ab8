//! An augmented model as JSON: the effects found, the base parameters they were fitted with, and how well all of them are known,
//! so that a later log can be asked what has changed since.

use super::cursor::Cursor;
use super::own_effects::{self, written};
use super::requests;
use super::residual::LawDocument;
use crate::diagnosis::{Diagnosis, RivalTerm};
use crate::effects::{AnyEffect, ParameterInfo, by_code};
use crate::model::{INPUT_LIMITS, Robot, counted};
use crate::regression::{AugmentedModel, Prior, Term};
use nalgebra::{DMatrix, DVector};
use serde::Deserialize;
use serde_json::Value;
use std::sync::Arc;

/// An augmented model with all that a design for it needs.
#[derive(Debug, Clone)]
pub struct ReadModel {
    /// The declared model with the effects that were found, as regressions and predictions use it.
    pub model: AugmentedModel,
    /// Base parameters with their covariance: what a further log is combined with.
    pub prior: Prior,
    /// Standard deviation of the torque noise of every joint in slow signals [N·m or N], and rows per second that it is of.
    pub noise: Option<(Vec<f64>, f64)>,
    /// Of every effect, the rivals that the data do not exclude.
    pub rivals: Vec<Vec<RivalTerm>>,
}

/// The model as `requests::AugmentedModel`, as JSON.
pub fn augmented_value(model: &AugmentedModel, information: &DMatrix<f64>) -> Value {
    serde_json::to_value(written_model(model, information)).expect("plain numbers and words")
}

/// `model` with its information matrix (inverse covariance of base values, then coefficients and free shapes effect by effect).
fn written_model(model: &AugmentedModel, information: &DMatrix<f64>) -> requests::AugmentedModel {
    requests::AugmentedModel {
        effects: model.terms.iter().map(|t| written_effect(&model.robot, t)).collect(),
        base_values: model.values.as_slice().to_vec(),
        information: rows(information),
        noise: None,
    }
}

/// The model of a diagnosis with its noise, and with the rivals of every effect.
pub fn written_diagnosis(diagnosis: &Diagnosis) -> requests::AugmentedModel {
    let robot = &diagnosis.model.robot;
    let mut written = written_model(&diagnosis.model, &diagnosis.information);
    written.noise = diagnosis.rate_hz.is_finite().then(|| requests::ModelNoise {
        std_dev: diagnosis.noise.iter().map(|n| n.slow_std_dev()).collect(),
        rate_hz: diagnosis.rate_hz,
    });
    for (effect, rivals) in written.effects.iter_mut().zip(&diagnosis.rival_terms) {
        effect.rivals = Some(rivals.iter().map(|r| written_rival(robot, r)).collect());
    }
    written
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|r| r.iter().copied().collect()).collect()
}

fn written_rival(robot: &Robot, rival: &RivalTerm) -> requests::RivalEffect {
    let effect = written_effect(robot, &rival.term);
    requests::RivalEffect {
        effect: effect.effect,
        joints: effect.joints,
        form: effect.form,
        coefficients: effect.coefficients,
        shape: effect.shape,
        free_shapes: effect.free_shapes,
        bounds: effect.bounds,
        parameters: effect.parameters,
        law: effect.law,
        definition: effect.definition,
        evidence: rival.evidence,
        base_values: rival.base_values.as_slice().to_vec(),
        cross: rows(&rival.cross),
        own: rows(&rival.own),
    }
}

fn written_effect(robot: &Robot, term: &Term) -> requests::AddedEffect {
    let names = |joints: &[usize]| joints.iter().map(|&j| robot.joints()[j].name.clone()).collect::<Vec<_>>();
    // JSON has no infinity: null is no bound.
    let bound = |b: &[f64; 2]| b.iter().map(|v| v.is_finite().then_some(*v)).collect();
    let values = term.effect.reported(term.form, &term.coefficients, &term.shape);
    let infos = term.effect.parameters(term.form, robot, &term.joints);
    let parameter = |(info, value): (ParameterInfo, f64)| requests::ModelParameter {
        name: info.name,
        value,
        unit: info.unit,
        std_dev: None,
    };
    requests::AddedEffect {
        effect: term.effect.code().into(),
        joints: names(&term.joints),
        form: term.form as u32,
        coefficients: term.coefficients.clone(),
        shape: term.shape.clone(),
        free_shapes: term.free_shapes as u32,
        bounds: term.bounds.iter().map(bound).collect(),
        parameters: Some(infos.into_iter().zip(values).map(parameter).collect()),
        // For readers: what it adds is in `form`.
        law: term
            .effect
            .formula(term.form, &term.joints)
            .map(|formula| LawDocument::new(&formula, &names(&term.acts_on()))),
        definition: term.effect.own().map(|own| written(own.definition())),
        rivals: None,
    }
}

/// Reads what [`augmented_value`] writes; `None` when something is wrong with it, which is then among the findings.
pub fn read_augmented(cursor: &Cursor, robot: &Robot) -> Option<(AugmentedModel, Prior)> {
    read_model_with_effects(cursor, robot).map(|read| (read.model, read.prior))
}

/// Reads what [`written_diagnosis`] writes; noise and rivals may be missing.
pub(super) fn read_model_with_effects(cursor: &Cursor, robot: &Robot) -> Option<ReadModel> {
    let fields = cursor.fields_of::<requests::AugmentedModel>()?;
    let mut model = AugmentedModel::declared(robot);
    let values = fields
        .required("base_values")
        .and_then(|c| c.numbers(Some(model.values.len())));
    let most = INPUT_LIMITS.model_effects;
    let effects = fields.required("effects").and_then(|c| c.items_up_to(most, "effects"))?;
    let terms: Vec<Option<Term>> = effects
        .iter()
        .map(|c| read_effect::<requests::AddedEffect>(c, robot))
        .collect();
    model.terms = terms.into_iter().collect::<Option<Vec<_>>>()?;
    model.values = DVector::from_vec(values?);
    let information = fields
        .required("information")
        .and_then(|c| read_square(&c, model.parameters()))?;
    let size = [model.parameters(), model.values.len()];
    let rivals = effects
        .iter()
        .map(|c| read_rivals(c, robot, size))
        .collect::<Option<Vec<_>>>()?;
    let noise = fields.nullable("noise").and_then(|c| read_noise(&c, robot.joint_count()));
    let mean = model.vector();
    Some(ReadModel {
        model,
        prior: Prior { mean, information },
        noise,
        rivals,
    })
}

fn read_noise(cursor: &Cursor, joints: usize) -> Option<(Vec<f64>, f64)> {
    let fields = cursor.fields_of::<requests::ModelNoise>()?;
    let std_dev = fields.required("std_dev").and_then(|c| c.numbers(Some(joints)))?;
    let rate = fields.required("rate_hz").and_then(|c| c.number())?;
    if !(rate > 0.0 && std_dev.iter().all(|s| *s > 0.0)) {
        cursor.complain("must hold positive numbers");
        return None;
    }
    Some((std_dev, rate))
}

fn read_rivals(effect: &Cursor, robot: &Robot, size: [usize; 2]) -> Option<Vec<RivalTerm>> {
    let fields = effect.fields_of::<requests::AddedEffect>()?;
    let Some(list) = fields.nullable("rivals") else {
        return Some(Vec::new());
    };
    let items = list.items_up_to(INPUT_LIMITS.model_effects, "rivals")?;
    items.iter().map(|c| read_rival(c, robot, size)).collect()
}

fn read_rival(cursor: &Cursor, robot: &Robot, [parameters, base]: [usize; 2]) -> Option<RivalTerm> {
    let term = read_effect::<requests::RivalEffect>(cursor, robot)?;
    let fields = cursor.fields_of::<requests::RivalEffect>()?;
    let k = term.parameters();
    let evidence = fields.required("evidence").and_then(|c| c.number())?;
    let base_values = fields.required("base_values").and_then(|c| c.numbers(Some(base)))?;
    let cross = fields.required("cross").and_then(|c| read_matrix(&c, parameters, k))?;
    let own = fields.required("own").and_then(|c| read_matrix(&c, k, k))?;
    Some(RivalTerm {
        term,
        base_values: DVector::from_vec(base_values),
        evidence,
        cross,
        own,
    })
}

fn read_square(cursor: &Cursor, size: usize) -> Option<DMatrix<f64>> {
    read_matrix(cursor, size, size)
}

fn read_matrix(cursor: &Cursor, height: usize, width: usize) -> Option<DMatrix<f64>> {
    let rows = cursor.items()?;
    if rows.len() != height {
        cursor.complain_with(
            format!("has {} rows, expected {height}", rows.len()),
            "one for every base value, coefficient and free shape, in this order",
        );
        return None;
    }
    let read: Vec<Option<Vec<f64>>> = rows.iter().map(|row| row.numbers(Some(width))).collect();
    let rows = read.into_iter().collect::<Option<Vec<_>>>()?;
    Some(DMatrix::from_fn(height, width, |r, c| rows[r][c]))
}

/// `T`: the object that the effect stands in, with further fields.
fn read_effect<T: for<'de> Deserialize<'de>>(cursor: &Cursor, robot: &Robot) -> Option<Term> {
    let fields = cursor.fields_of::<T>()?;
    let code = fields.required("effect")?;
    let effect = match fields.nullable("definition") {
        Some(definition) => read_own(&definition, &code, robot),
        None => by_code(code.string()?).map(AnyEffect::from),
    };
    if effect.is_none() && !fields.has("definition") {
        code.complain_with("is no effect known here", "see the table of effects in the documentation");
    }
    let joints = fields.required("joints").and_then(|c| read_joints(&c, robot));
    let form = fields
        .required("form")
        .and_then(|c| c.whole(0, effect.as_ref().map_or(u64::MAX, |e| e.forms() as u64 - 1)));
    let coefficients = fields.required("coefficients").and_then(|c| c.numbers(None));
    let shape = fields.required("shape").and_then(|c| c.numbers(None));
    let bounds = fields.required("bounds").and_then(|c| read_bounds(&c));
    let free = fields
        .required("free_shapes")
        .and_then(|c| c.whole(0, shape.as_ref().map_or(u64::MAX, |s| s.len() as u64)));
    let term = Term {
        effect: effect?,
        form: form? as usize,
        joints: joints?,
        coefficients: coefficients?,
        shape: shape?,
        free_shapes: free? as usize,
        bounds: bounds?,
    };
    if !term.is_complete(robot) {
        cursor.complain_with(
            "does not have the joints, coefficients and shapes of this effect",
            "take the model as the identification wrote it",
        );
        return None;
    }
    Some(term)
}

/// An own effect by its definition, whose name is the effect's.
fn read_own(definition: &Cursor, code: &Cursor, robot: &Robot) -> Option<AnyEffect> {
    let own = own_effects::read_effect(definition, Some(robot))?;
    if code.string()? != own.definition().name {
        code.complain_with(
            "is not the name of its `definition`",
            "take the model as the identification wrote it",
        );
        return None;
    }
    Some(Arc::new(own).into())
}

fn read_joints(cursor: &Cursor, robot: &Robot) -> Option<Vec<usize>> {
    let one = |c: &Cursor| {
        let name = c.string()?;
        let at = robot.joints().iter().position(|j| j.name == name);
        if at.is_none() {
            c.complain(format!("the robot has no joint `{name}`"));
        }
        at
    };
    let items = cursor.items_up_to(INPUT_LIMITS.joints, "joints")?;
    let read: Vec<Option<usize>> = items.iter().map(one).collect();
    read.into_iter().collect()
}

fn read_bounds(cursor: &Cursor) -> Option<Vec<[f64; 2]>> {
    let end = |c: &Cursor, none: f64| if c.value().is_null() { Some(none) } else { c.number() };
    let pair = |c: &Cursor| {
        let items = c.items()?;
        let [low, high] = &items[..] else {
            c.complain(format!("has {}, expected 2", counted(items.len(), "value")));
            return None;
        };
        Some([end(low, f64::NEG_INFINITY)?, end(high, f64::INFINITY)?])
    };
    let read: Vec<Option<[f64; 2]>> = cursor.items()?.iter().map(pair).collect();
    read.into_iter().collect()
}
