//! Which way gravity points: a hypothesis over the whole sphere, weighed before signs and order of the torque columns.
//!
//! The regressor is linear in gravity, so that sums of squares for all directions come from one quadratic form ([`form`]). Fourteen directions (axes and
//! space diagonals) are starting points; those that leave least are refined. On slow motions the opposite direction fits nearly as well, with all first
//! moments turned round: then it decides that masses are positive and lie along the arm ([`vote`]).

mod evidence;
mod form;
mod refine;
mod vote;

pub use self::refine::{Gravity, trace_mounted};

use self::evidence::Gain;
use self::form::Form;
use self::vote::Bodies;
use crate::dynamics::Motion;
use crate::identification::CancelFlag;
use crate::model::Robot;
use nalgebra::Vector3;

/// A direction of gravity that is not the declared one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mounting {
    /// Gravity in the base frame [m/s²].
    pub gravity: Vector3<f64>,
    /// Angle to the declared direction (rad).
    pub angle: f64,
    /// How many times less the model leaves with it (sums of squares).
    pub ratio: f64,
}

/// Angle from which a direction is another mounting, and not a base that is out of level (rad): 10°. Feet and tables are level to a degree or two; an encoder
/// offset of a few degrees looks like a tilt of a few degrees.
pub const OTHER_MOUNTING: f64 = 0.1745;

/// How many times less another direction must leave than any signs and any order of the torque columns under the declared one. Noise brings 1.2 about with
/// a hundred independent rows once in 10 000 logs (two parameters: `rows · ln 1.2 > χ²₂`), and logs have more; below it two directions are alike. What a misfit
/// brings, whose rows go together, is weighed by [`Gain`].
const CLEARLY: f64 = 1.2;

/// Share of the torque's scatter that the best direction must explain at least, beyond what every joint's own columns do: where the model says nothing,
/// it says nothing of gravity.
const EXPLAINED: f64 = 0.5;

/// Twice the log of a likelihood ratio below which two directions are alike: two standard deviations, of as many independent values as there are samples, whatever the number
/// of joints.
const ALIKE: f64 = 4.0;

/// Direction by which a vote is decisive: the angle between two torques is below 60° or above 120°.
const DECISIVE: f64 = 0.5;

/// Directions that are refined: the best starting points, in case the very best is a side valley.
const REFINED: usize = 3;

/// Where gravity points by the data, if that is not (nearly) where the robot's description has it. Motion and torque (n × N) of every log.
///
/// `None` too for a robot declared without gravity, and where the data do not decide.
pub fn mounting(robot: &Robot, logs: &[(&Motion, &[Vec<f64>])]) -> Option<Mounting> {
    mounting_until(robot, logs, &CancelFlag::default())
}

/// The same, left when `cancel` is set, as by [`CancelFlag::leave_if_set`]: within [`CancelFlag::run`].
pub fn mounting_until(robot: &Robot, logs: &[(&Motion, &[Vec<f64>])], cancel: &CancelFlag) -> Option<Mounting> {
    let size = robot.gravity().norm();
    if size.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    let declared = robot.gravity() / size;
    let form = Form::new(robot, logs, cancel)?;
    let level = Fitted::near(&form, declared);
    let mut found: Vec<Fitted> = starts().iter().map(|&u| Fitted::at(&form, u)).collect();
    found.sort_by(|a, b| a.rest.total_cmp(&b.rest));
    found.truncate(REFINED);
    found.push(Fitted::at(&form, declared));
    let mut found: Vec<Fitted> = found.into_iter().map(|f| f.refined(&form)).collect();
    found.sort_by(|a, b| a.rest.total_cmp(&b.rest));
    let least = found[0].rest;
    if least > EXPLAINED * form.without_body() {
        return None;
    }
    // The opposite of every candidate is one as well: it may leave hardly more.
    let opposite: Vec<Fitted> = found.iter().map(|f| Fitted::at(&form, -f.direction).refined(&form)).collect();
    found.extend(opposite);
    let near = found.into_iter().filter(|f| f.rest < CLEARLY * least);
    let bodies = Bodies::new(robot, logs);
    let vote = |f: &Fitted| bodies.vote(&form, f.direction, &f.signs);
    let mut voted: Vec<(f64, Fitted)> = near.map(|f| (vote(&f), f)).collect();
    // Votes count where one is clearly for and the fit's first choice clearly against.
    voted.sort_by(|a, b| a.1.rest.total_cmp(&b.1.rest));
    let chosen = if voted[0].0 < -DECISIVE {
        voted.iter().find(|v| v.0 > DECISIVE).unwrap_or(&voted[0])
    } else {
        &voted[0]
    };
    // What the arm does not show of gravity (along parallel axes, say) is as declared.
    let best = chosen.1.clone().toward(&form, declared);
    let angle = best.direction.angle(&declared);
    if angle < OTHER_MOUNTING {
        return None;
    }
    let ratio = level.rest.min(form.best_columns(declared)) / best.rest.max(f64::MIN_POSITIVE);
    // Where the declared direction fits alike it stands, whatever the masses say: with little inertia in a log their signs are those of its misfit.
    if ratio <= CLEARLY {
        return None;
    }
    let gain = Gain::of(&form, &best, &level);
    gain.is_no_accident().then(|| Mounting {
        gravity: best.direction * size,
        angle,
        ratio,
    })
}

/// A direction with the signs of the torque columns that fit best.
#[derive(Debug, Clone)]
struct Fitted {
    direction: Vector3<f64>,
    signs: Vec<f64>,
    /// Sum of squares left.
    rest: f64,
}

impl Fitted {
    fn at(form: &Form, direction: Vector3<f64>) -> Self {
        let (rest, signs) = form.signed(direction);
        Self { direction, signs, rest }
    }

    /// The declared direction, out of level by as much as feet and tables are, and the columns as they are.
    fn near(form: &Form, declared: Vector3<f64>) -> Self {
        let plain = vec![1.0; form.joints];
        let start = Self {
            direction: declared,
            rest: form.rest(declared, &plain),
            signs: plain,
        };
        start.within(form, |u| u.angle(&declared) < OTHER_MOUNTING)
    }

    fn refined(self, form: &Form) -> Self {
        let there = self.within(form, |_| true);
        Self::at(form, there.direction)
    }

    /// The direction nearest to the declared one among those that fit like this one.
    fn toward(mut self, form: &Form, declared: Vector3<f64>) -> Self {
        let most = self.rest * (ALIKE / form.samples as f64).exp();
        let mut step = 0.25;
        while step > 2e-5 {
            let here = self.direction.angle(&declared);
            let near = around(&self.direction, step).filter(|u| u.angle(&declared) < here);
            let alike = near.map(|u| (form.rest(u, &self.signs), u)).filter(|t| t.0 <= most);
            match alike.min_by(|a, b| a.1.angle(&declared).total_cmp(&b.1.angle(&declared))) {
                Some((rest, direction)) => (self.rest, self.direction) = (rest, direction),
                None => step *= 0.5,
            }
        }
        self
    }

    /// Compass search: steps of the sphere in eight directions, halved when none helps, from half the way between two starting points down to a
    /// thousandth of a degree.
    fn within(mut self, form: &Form, allowed: impl Fn(&Vector3<f64>) -> bool) -> Self {
        let mut step = 0.25;
        while step > 2e-5 {
            let tried = around(&self.direction, step)
                .filter(&allowed)
                .map(|u| (form.rest(u, &self.signs), u));
            match tried.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((rest, direction)) if rest < self.rest => (self.rest, self.direction) = (rest, direction),
                _ => step *= 0.5,
            }
        }
        self
    }
}

/// Eight directions at an angle of `step` to one.
fn around(u: &Vector3<f64>, step: f64) -> impl Iterator<Item = Vector3<f64>> {
    let x = u.cross(&smallest_axis(u)).normalize();
    let (u, y) = (*u, u.cross(&x));
    (0..8).map(move |k| {
        let (s, c) = (k as f64 * std::f64::consts::FRAC_PI_4).sin_cos();
        (u * f64::cos(step) + (x * c + y * s) * f64::sin(step)).normalize()
    })
}

fn smallest_axis(u: &Vector3<f64>) -> Vector3<f64> {
    Vector3::ith(u.iamin(), 1.0)
}

/// Axes and space diagonals, both ways.
fn starts() -> Vec<Vector3<f64>> {
    let ends = [-1.0, 1.0];
    let axes = (0..3).flat_map(|i| ends.map(|s| Vector3::ith(i, s)));
    let diagonals = (0..8).map(|k| Vector3::from_fn(|i, _| ends[k >> i & 1]).normalize());
    axes.chain(diagonals).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_no_direction_is_far_from_a_start() {
        let starts = starts();
        assert_eq!(starts.len(), 14);
        for k in 0..1000 {
            // Fibonacci's spiral covers the sphere evenly.
            let z = 1.0 - 2.0 * (k as f64 + 0.5) / 1000.0;
            let (s, c) = (2.399_963 * k as f64).sin_cos();
            let u = Vector3::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z);
            let nearest = starts.iter().map(|v| v.angle(&u)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.8, "{nearest}");
        }
    }
}
