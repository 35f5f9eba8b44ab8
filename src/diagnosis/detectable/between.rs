//! Friction that drifts while the log is recorded, and a touch: seen between the periods.

use super::plan::Plan;
use super::planned::Planned;
use super::power::{noncentrality, quantile};
use super::sizes::{Hidden, Visible};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::{ParameterInfo, by_code};
use crate::regression::Stretch;
use statrs::distribution::{ContinuousCDF, Normal};

/// Parameters of a drift: viscous, Coulomb, time constant.
const PARAMETERS: usize = 3;

/// Change over the log of viscous and of Coulomb friction of every joint, fading with the middle one of the time constants that
/// are tried; of the trajectory that shows it best. Nothing with fewer periods than a diagnosis looks between.
pub(super) fn drifts(plan: &Plan, planned: &Planned) -> Vec<Visible> {
    let joints = 0..planned.data.noise.len();
    if plan.periods < SETTINGS.detectable.fewest_periods {
        return Vec::new();
    }
    joints.flat_map(|j| [0, 1].map(|at| drift(plan, planned, j, at))).collect()
}

fn drift(plan: &Plan, planned: &Planned, joint: usize, parameter: usize) -> Visible {
    let effect = by_code("friction_drift").expect("is in the list");
    let model = &planned.system.model;
    let courses = SETTINGS.replicates.drift_courses;
    let course = courses[courses.len() / 2];
    let shown = planned.data.stretches.iter().enumerate().map(|(i, stretch)| {
        let rows = &planned.system.blocks[i][joint].rows;
        // The noise is that of the mean over the periods; here every period counts by itself.
        let noise = planned.data.noise[joint].innovation * plan.periods.sqrt();
        square(stretch, rows, joint, parameter, plan.periods, course) / (noise * noise)
    });
    let tries = (courses.len() * model.robot.joint_count()) as f64;
    let threshold = quantile(planned.chance / tries, PARAMETERS);
    let wanted = noncentrality(threshold, PARAMETERS, SETTINGS.detectable.power);
    let size = (wanted / shown.fold(0.0, f64::max)).sqrt();
    let length = |s: &Stretch| plan.periods * s.interval * s.motion.samples() as f64;
    let constant = planned.data.stretches.first().map_or(f64::NAN, |s| course * length(s));
    Visible {
        effect: effect.code().into(),
        joints: vec![joint],
        parameter: effect.parameters(0, &model.robot, &[joint])[parameter].clone(),
        sign: 1.0,
        assumed: vec![(ParameterInfo::new("time_constant", "s"), constant)],
        size: if size.is_finite() { Ok(size) } else { Err(Hidden::NoTorque) },
        signal: usize::MAX,
    }
}

/// Time (s) that a touch is assumed to last: somebody bumps into the arm.
const TOUCH_S: f64 = 1.0;

/// Torque of a touch of one second on one joint.
pub(super) fn touches(plan: &Plan, planned: &Planned) -> Vec<Visible> {
    if plan.periods < SETTINGS.detectable.fewest_periods {
        return Vec::new();
    }
    (0..planned.data.noise.len()).map(|j| touch(plan, planned, j)).collect()
}

/// It has to be beyond chance against the median over the periods, which leans towards the touched one by its share, and above
/// the noise of single measurements beside the other periods.
fn touch(plan: &Plan, planned: &Planned, joint: usize) -> Visible {
    let effect = by_code("external_contact").expect("is in the list");
    let robot = &planned.system.model.robot;
    let stretch = &planned.data.stretches[0];
    let period = stretch.interval * stretch.motion.samples() as f64;
    let lasts = TOUCH_S.min(0.5 * period);
    // Rows of the log, of which one here stands for several.
    let each = stretch.interval * plan.rate_hz;
    let rows = (each * lasts / stretch.interval).max(1.0);
    let single = planned.data.noise[joint].innovation * (plan.periods * each).sqrt();
    let unfair = 1.0 + 0.5 * std::f64::consts::PI / plan.periods;
    let threshold = quantile(planned.chance / windows(stretch, plan.periods), robot.joint_count());
    let wanted = noncentrality(threshold, robot.joint_count(), SETTINGS.detectable.power);
    let beyond_chance = single * (wanted * unfair / rows).sqrt();
    let z = Normal::standard().inverse_cdf(SETTINGS.detectable.power);
    // The level beside the other periods has the noise of both.
    let felt = single * (1.0 + z * ((1.0 + 1.0 / (plan.periods - 1.0)) / rows).sqrt());
    let infos = effect.parameters(0, robot, &[joint]);
    Visible {
        effect: effect.code().into(),
        joints: vec![joint],
        parameter: infos[2].clone(),
        sign: 1.0,
        assumed: vec![(ParameterInfo::new("duration", "s"), lasts)],
        size: Ok(beyond_chance.max(felt)),
        signal: usize::MAX,
    }
}

/// Intervals of all periods that are tried: of lengths at a ratio of 3/2, a quarter of their length apart.
fn windows(stretch: &Stretch, periods: f64) -> f64 {
    let rows = stretch.motion.samples() as f64;
    let length = rows * periods;
    let mut width = (SETTINGS.replicates.shortest_contact / stretch.interval).max(4.0);
    let mut count = 1.0;
    while width <= rows {
        count += (length - width).max(0.0) / (width / 4.0).max(1.0);
        width *= 1.5;
    }
    count
}

/// Sum over all rows of all periods of the square of what a change by one over the log deviates from its mean over the periods.
fn square(stretch: &Stretch, rows: &[bool], joint: usize, parameter: usize, periods: f64, course: f64) -> f64 {
    let period = stretch.interval * stretch.motion.samples() as f64;
    let constant = course * periods * period;
    let count = periods as usize;
    // Σ_p (g_p − ḡ)² of g_p = exp(−(t + p P)/T) is that at t = 0 times exp(−2 t/T).
    let courses: Vec<f64> = (0..count).map(|p| (-(p as f64) * period / constant).exp()).collect();
    let mean = courses.iter().sum::<f64>() / periods;
    let scatter: f64 = courses.iter().map(|g| (g - mean) * (g - mean)).sum();
    let swing = 1.0 - (-1.0 / course).exp();
    let speeds = stretch.motion.velocities(joint);
    let of = |(s, v): (usize, &f64)| {
        let friction = if parameter == 0 { *v } else { v.signum() };
        (-2.0 * s as f64 * stretch.interval / constant).exp() * friction * friction
    };
    let sum: f64 = speeds.iter().enumerate().filter(|(s, _)| rows[*s]).map(of).sum();
    sum * scatter / (swing * swing)
}
