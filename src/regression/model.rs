//! The declared model with effects added: its terms and its parameters.

use crate::dynamics::{Coulomb, Motion};
use crate::effects::{AnyEffect, EffectKind, Scene, Span, by_code};
use crate::model::Robot;
use crate::parameters::BaseParameters;
use nalgebra::{DMatrix, DVector, Rotation3};

/// An effect with its values.
#[derive(Clone)]
pub struct Term {
    /// Which effect.
    pub effect: AnyEffect,
    /// Which of its forms, from 0.
    pub form: usize,
    /// Joints that it acts on, from 0, in the order of the effect's own.
    pub joints: Vec<usize>,
    /// Of the columns.
    pub coefficients: Vec<f64>,
    /// Shape parameters, or the parameters of a distortion.
    pub shape: Vec<f64>,
    /// How many of the shape parameters are estimated, from the first.
    pub free_shapes: usize,
    /// Where each of them may lie.
    pub bounds: Vec<[f64; 2]>,
}

impl std::fmt::Debug for Term {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}[{}]{:?} c={:?} s={:?}",
            self.effect.code(),
            self.form,
            self.joints,
            self.coefficients,
            self.shape
        )
    }
}

impl Term {
    /// A constant torque on one joint [N·m or N].
    pub fn constant(joint: usize, size: f64) -> Self {
        Self {
            coefficients: vec![size],
            ..Self::offset(joint)
        }
    }

    /// A constant torque on one joint, zero as yet.
    pub(crate) fn offset(joint: usize) -> Self {
        Self {
            effect: by_code("torque_offset").expect("is in the list").into(),
            form: 0,
            joints: vec![joint],
            coefficients: vec![0.0],
            shape: Vec::new(),
            free_shapes: 0,
            bounds: Vec::new(),
        }
    }

    pub(crate) fn is_distortion(&self) -> bool {
        self.effect.kind() == EffectKind::Distortion
    }

    /// The joints whose torque it changes; none for an effect of the whole robot.
    pub fn acts_on(&self) -> Vec<usize> {
        self.effect.acts_on(self.form, &self.joints)
    }

    /// Number of estimated parameters.
    pub fn parameters(&self) -> usize {
        self.coefficients.len() + self.free_shapes
    }

    /// Whether joints, coefficients and shapes are as many as the effect has on this robot.
    pub fn is_complete(&self, robot: &Robot) -> bool {
        let place = self.effect.places_of(self.form, robot).contains(&self.joints);
        let bounded = self.bounds.len() >= self.free_shapes && self.free_shapes <= self.shape.len();
        if self.is_distortion() {
            return place && bounded && self.coefficients.is_empty() && self.shape.len() == self.effect.steps().len();
        }
        let span = Span {
            range: 1.0,
            highest: 0.5,
            speed: 1.0,
            interval: 1e-3,
            speed_error: 0.0,
        };
        let spans = vec![span; robot.joint_count()];
        let still = Motion::zeros(robot.joint_count(), 2);
        let rest = vec![vec![0.0; 2]; robot.joint_count()];
        let scene = Scene {
            robot,
            motion: &still,
            rigid: &rest,
            declared: &rest,
            interval: span.interval,
            periodic: false,
            coulomb: Coulomb::Sign,
        };
        place
            && bounded
            && self.shape.len() == self.effect.shapes(self.form, &self.joints, &spans).len()
            && self.coefficients.len() == self.effect.columns(self.form, &scene, &self.joints, &self.shape).len()
    }
}

/// Base parameters and effects.
#[derive(Debug, Clone)]
pub struct AugmentedModel {
    /// The robot as declared.
    pub robot: Robot,
    /// Base parameters that the model has.
    pub base: BaseParameters,
    /// Values of the base parameters.
    pub values: DVector<f64>,
    /// Effects with their values.
    pub terms: Vec<Term>,
}

impl AugmentedModel {
    /// The declared model with all parameters zero.
    pub fn declared(robot: &Robot) -> Self {
        // A base that is not level makes parameters of the first links act that gravity along their axes hides; their columns are
        // zero until a tilt is in the model.
        let anyhow = Rotation3::from_euler_angles(0.1, 0.07, 0.05) * robot.gravity();
        let base = BaseParameters::exact(&robot.with_gravity(anyhow));
        let values = DVector::zeros(base.len());
        Self {
            robot: robot.clone(),
            base,
            values,
            terms: Vec::new(),
        }
    }

    /// The model with a constant torque of this size on every joint.
    pub fn with_offsets(mut self, offsets: &[f64]) -> Self {
        let term = |(joint, &size): (usize, &f64)| Term::constant(joint, size);
        self.terms.extend(offsets.iter().enumerate().map(term));
        self
    }

    /// Number of estimated parameters.
    pub fn parameters(&self) -> usize {
        self.values.len() + self.terms.iter().map(Term::parameters).sum::<usize>()
    }

    /// First parameter of term `at` in the order of [`Self::vector`].
    pub fn offset_of(&self, at: usize) -> usize {
        self.values.len() + self.terms[..at].iter().map(Term::parameters).sum::<usize>()
    }

    /// Number of effects of single joints that act on this one.
    pub fn effects_on(&self, joint: usize) -> usize {
        let acts = |t: &&Term| !t.joints.is_empty() && t.acts_on().contains(&joint);
        self.terms.iter().filter(acts).count()
    }

    /// All parameters: base, then per term the coefficients and the free shapes.
    pub fn vector(&self) -> DVector<f64> {
        let mut all: Vec<f64> = self.values.iter().copied().collect();
        for term in &self.terms {
            all.extend(&term.coefficients);
            all.extend(&term.shape[..term.free_shapes]);
        }
        DVector::from_vec(all)
    }

    /// The model with its parameters moved by `step`, shapes kept where they may lie.
    pub fn moved(&self, step: &DVector<f64>) -> Self {
        let mut there = self.clone();
        let b = self.values.len();
        there.values += step.rows(0, b);
        let mut at = b;
        for term in &mut there.terms {
            for c in &mut term.coefficients {
                *c += step[at];
                at += 1;
            }
            for i in 0..term.free_shapes {
                term.shape[i] = (term.shape[i] + step[at]).clamp(term.bounds[i][0], term.bounds[i][1]);
                at += 1;
            }
        }
        there
    }
}

/// Standard deviations of what a term reports, from the covariance of its coefficients and free shapes.
pub fn reported(term: &Term, covariance: &DMatrix<f64>) -> Vec<(f64, f64)> {
    let k = term.coefficients.len();
    let point: Vec<f64> = term
        .coefficients
        .iter()
        .chain(&term.shape[..term.free_shapes])
        .copied()
        .collect();
    let at = |x: &[f64]| {
        let shape: Vec<f64> = x[k..].iter().chain(&term.shape[term.free_shapes..]).copied().collect();
        term.effect.reported(term.form, &x[..k], &shape)
    };
    let values = at(&point);
    let mut jacobian = DMatrix::zeros(values.len(), point.len());
    for c in 0..point.len() {
        // A thousandth of a standard deviation: the map is smooth over that.
        let step = (1e-3 * covariance[(c, c)].max(0.0).sqrt())
            .max(1e-9 * point[c].abs())
            .max(f64::MIN_POSITIVE);
        let mut there = point.clone();
        there[c] += step;
        at(&there)
            .iter()
            .enumerate()
            .for_each(|(r, v)| jacobian[(r, c)] = (v - values[r]) / step);
    }
    let spread = &jacobian * covariance * jacobian.transpose();
    values
        .iter()
        .enumerate()
        .map(|(r, &v)| (v, spread[(r, r)].max(0.0).sqrt()))
        .collect()
}
