//! Any effect of the list, made by its own columns: what an effect without a simulation of its own is simulated by.

use crate::dynamics::{Coulomb, Motion};
use crate::effects::{Effect, EffectKind, Scene, Shape, Span, by_code};
use crate::model::Robot;
use serde::Deserialize;

/// `tau += C(motion; shape) coefficients`, C being the columns that the search for the effect has as well. A wrong column is
/// wrong in both: where there is a simulation by other means, such as [`JointSpring`](super::HiddenEffect::JointSpring), tests
/// take that.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListedEffect {
    /// Code of the effect.
    pub code: String,
    /// Which of its forms.
    #[serde(default)]
    pub form: usize,
    /// Numbers of its joints, from 0.
    pub joints: Vec<usize>,
    /// In the order of its columns, in SI units.
    pub coefficients: Vec<f64>,
    /// Values of its shape parameters, in SI units.
    #[serde(default)]
    pub shape: Vec<f64>,
}

/// A part of an experiment.
pub(super) struct Part<'a> {
    pub robot: &'a Robot,
    pub motor: &'a Motion,
    pub rigid: &'a [&'a [f64]],
    pub interval: f64,
}

/// Shape parameters where a joint moves over 2 rad or m at up to 1.5 rad/s or m/s; how many there are does not depend on the
/// motion.
fn shapes(effect: &dyn Effect, form: usize, robot: &Robot, joints: &[usize]) -> Vec<Shape> {
    let span = Span {
        range: 2.0,
        highest: 1.0,
        speed: 1.5,
        interval: 0.01,
        speed_error: 0.0,
    };
    effect.shapes(form, joints, &vec![span; robot.joint_count()])
}

impl ListedEffect {
    /// The simplest form of an effect on a joint, well visible in noise of `noise` where the joint carries about `load` [N·m or
    /// N]; `None` where it cannot be there.
    pub fn example(code: &str, robot: &Robot, joint: usize, [noise, load]: [f64; 2]) -> Option<Self> {
        let effect = by_code(code)?;
        let joints = effect.places(robot).into_iter().find(|place| place.first() == Some(&joint))?;
        let shape: Vec<f64> = shapes(effect, 0, robot, &joints)
            .iter()
            .map(|s| s.grid[s.grid.len() / 2])
            .collect();
        let count = effect.parameters(0, robot, &joints).len() - shape.len();
        let example = Self {
            code: code.into(),
            form: 0,
            coefficients: effect.example(count, noise, load),
            shape,
            joints,
        };
        example.misfit(robot).is_none().then_some(example)
    }

    fn effect(&self) -> Option<&'static dyn Effect> {
        by_code(&self.code)
    }

    /// What is wrong with it on a robot, in words.
    pub fn misfit(&self, robot: &Robot) -> Option<String> {
        let Some(effect) = self.effect() else {
            return Some(format!("has the code `{}`, which no effect has", self.code));
        };
        if effect.kind() != EffectKind::Additive {
            return Some(format!("`{}` adds no columns: it has a form of its own here", self.code));
        }
        if self.form >= effect.forms() {
            return Some(format!(
                "has form {}; `{}` has forms up to {}",
                self.form,
                self.code,
                effect.forms() - 1
            ));
        }
        if !effect.places_of(self.form, robot).contains(&self.joints) {
            return Some(format!("`{}` cannot be on these joints", self.code));
        }
        let shapes = shapes(effect, self.form, robot, &self.joints).len();
        let coefficients = effect.parameters(self.form, robot, &self.joints).len() - shapes;
        let wanted = [
            ("coefficients", &self.coefficients, coefficients),
            ("shape", &self.shape, shapes),
        ];
        let wrong = wanted.iter().find(|(_, have, want)| have.len() != *want);
        wrong.map(|(what, have, want)| format!("has {} entries in `{what}`, expected {want}", have.len()))
    }

    /// Onto the torques of all joints, which have friction already.
    pub(super) fn add(&self, part: &Part, tau: &mut [Vec<f64>]) {
        let effect = self.effect().expect("was checked");
        let rigid: Vec<Vec<f64>> = part.rigid.iter().map(|row| row.to_vec()).collect();
        let columns = {
            let scene = Scene {
                robot: part.robot,
                motion: part.motor,
                rigid: &rigid,
                declared: tau,
                interval: part.interval,
                periodic: false,
                coulomb: Coulomb::Sign,
            };
            effect.columns(self.form, &scene, &self.joints, &self.shape)
        };
        for (column, coefficient) in columns.iter().zip(&self.coefficients) {
            for (joint, values) in &column.rows {
                tau[*joint].iter_mut().zip(values).for_each(|(t, v)| *t += coefficient * v);
            }
        }
    }
}
