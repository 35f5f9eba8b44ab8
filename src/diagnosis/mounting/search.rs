//! The direction of gravity that the data ask for.

use super::direction::{Fitted, starts};
use super::evidence::Gain;
use super::form::Form;
use super::vote::Bodies;
use crate::cancel::CancelFlag;
use crate::diagnosis::settings::SETTINGS;
use crate::dynamics::Motion;
use crate::model::Robot;
use nalgebra::Vector3;
use rayon::prelude::*;

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

/// Where gravity points by the data, if that is not (nearly) where the robot's description has it. Motion and torque (n × N) of
/// every log.
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
    let mut found: Vec<Fitted> = starts().par_iter().map(|&u| Fitted::at(&form, u)).collect();
    found.sort_by(|a, b| a.rest.total_cmp(&b.rest));
    found.truncate(SETTINGS.mounting.refined);
    found.push(Fitted::at(&form, declared));
    let mut found: Vec<Fitted> = found.into_par_iter().map(|f| f.refined(&form)).collect();
    found.sort_by(|a, b| a.rest.total_cmp(&b.rest));
    let least = found[0].rest;
    if least > SETTINGS.mounting.least_explained * form.without_body() {
        return None;
    }
    // The opposite of every candidate is one as well: it may leave hardly more.
    let opposite: Vec<Fitted> = found
        .par_iter()
        .map(|f| Fitted::at(&form, -f.direction).refined(&form))
        .collect();
    found.extend(opposite);
    let near = found.into_iter().filter(|f| f.rest < SETTINGS.mounting.near * least);
    let bodies = Bodies::new(robot, logs);
    let vote = |f: &Fitted| bodies.vote(&form, f.direction, &f.signs);
    let mut voted: Vec<(f64, Fitted)> = near.map(|f| (vote(&f), f)).collect();
    // Votes count where one is clearly for and the fit's first choice clearly against.
    voted.sort_by(|a, b| a.1.rest.total_cmp(&b.1.rest));
    let chosen = if voted[0].0 < -SETTINGS.mounting.decisive_vote {
        voted
            .iter()
            .find(|v| v.0 > SETTINGS.mounting.decisive_vote)
            .unwrap_or(&voted[0])
    } else {
        &voted[0]
    };
    // What the arm does not show of gravity (along parallel axes, say) is as declared.
    let best = chosen.1.clone().toward(&form, declared);
    let angle = best.direction.angle(&declared);
    if angle < SETTINGS.mounting.other_mounting {
        return None;
    }
    let ratio = level.rest.min(form.best_columns(declared)) / best.rest.max(f64::MIN_POSITIVE);
    // Where the declared direction fits alike it stands, whatever the masses say: with little inertia in a log their signs are
    // those of its misfit.
    if ratio <= by_noise(form.samples) {
        return None;
    }
    let gain = Gain::of(&form, &best, &level);
    gain.is_no_accident().then(|| Mounting {
        gravity: best.direction * size,
        angle,
        ratio,
    })
}

/// Ratio of two sums of squares that noise alone exceeds with a chance of [`MountingTest::chance_by_noise`]: a direction has two
/// parameters, and `rows · ln ratio` is χ² with as many degrees of freedom, `P(χ²₂ > x) = exp(−x/2)`.
///
/// [`MountingTest::chance_by_noise`]: crate::diagnosis::settings::MountingTest::chance_by_noise
fn by_noise(samples: usize) -> f64 {
    let rows = SETTINGS.mounting.independent * samples as f64;
    (-2.0 * SETTINGS.mounting.chance_by_noise.ln() / rows).exp()
}
