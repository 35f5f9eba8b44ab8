//! Laws: compact formulas in the joints' positions and speeds, for what no listed effect explains.
//!
//! A closed family of forms ([`LawForm`]), found by the search of [`diagnosis`](crate::diagnosis) and never tried by name:
//! conservative ones are the gradient of one energy and act on every joint in it; the others are products of a function of
//! position and one of speed, or friction that depends on another joint's speed. A law is an effect like any other: [`Law`] gives
//! its columns, the number of the form says which formula it is.

mod form;
mod formula;
mod functions;
mod units;

pub use form::{Class, LawForm};
pub use formula::{formula, statements};
pub use functions::{OfPosition, OfSpeed};

use super::{About, AnyEffect, Column, Effect, Formula, ParameterInfo, PlotVariable, Scene, Shape, Span, Statements, Written};
use crate::model::Robot;

/// `tau_j += f(q, qd; c, shape)` for one of the forms of [`LawForm::all`]; `joints` is what [`LawForm`] says of its places.
pub struct Law;

/// Whether an effect is a law, and no listed one.
pub fn is_law(effect: &AnyEffect) -> bool {
    effect.code() == Law.code()
}

impl Effect for Law {
    fn code(&self) -> &'static str {
        "law"
    }

    fn about(&self) -> About {
        About {
            name: "Law",
            phrase: "a law",
            meaning: "A formula in positions, speeds and further quantities of the log, found where no listed effect explains the residual, with its \
                      constants and the range that the log covers.",
            over: PlotVariable::Position,
            identifiable: "over the range of the variables that the motion covers, and only there",
            rivals: &[],
            source: "Brunton, Proctor & Kutz 2016 (sparse search); Golub & Pereyra 1973 (variable projection)",
        }
    }

    /// Those of all forms.
    fn places(&self, robot: &Robot) -> Vec<Vec<usize>> {
        let mut all: Vec<Vec<usize>> = LawForm::all().iter().flat_map(|f| f.places(robot)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn places_of(&self, form: usize, robot: &Robot) -> Vec<Vec<usize>> {
        LawForm::numbered(form).places(robot)
    }

    fn acts_on(&self, form: usize, joints: &[usize]) -> Vec<usize> {
        LawForm::numbered(form).acts_on(joints)
    }

    fn forms(&self) -> usize {
        LawForm::all().len()
    }

    fn shapes(&self, form: usize, joints: &[usize], spans: &[Span]) -> Vec<Shape> {
        LawForm::numbered(form).shapes(joints, spans)
    }

    fn columns(&self, form: usize, scene: &Scene, joints: &[usize], shape: &[f64]) -> Vec<Column> {
        LawForm::numbered(form).columns(scene, joints, shape)
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let (q, v) = (|j: usize| format!("q[{j}]"), |j: usize| format!("qd[{j}]"));
        Some(Statements {
            torque: statements(LawForm::numbered(w.form), w.joints, &w.reported, &q, &v),
            inertia: Vec::new(),
        })
    }

    fn parameters(&self, form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        units::parameters(LawForm::numbered(form), robot, joints)
    }

    fn positive(&self, form: usize) -> &'static [usize] {
        match LawForm::numbered(form) {
            LawForm::PinSpring | LawForm::Spring { .. } | LawForm::Damper => &[0],
            _ => &[],
        }
    }

    fn is_friction(&self, form: usize) -> bool {
        LawForm::numbered(form).is_friction()
    }

    fn reported(&self, form: usize, coefficients: &[f64], shape: &[f64]) -> Vec<f64> {
        LawForm::numbered(form).reported(coefficients, shape)
    }

    fn formula(&self, form: usize, joints: &[usize]) -> Option<Formula> {
        Some(formula(LawForm::numbered(form), joints))
    }
}

#[cfg(test)]
mod tests;
