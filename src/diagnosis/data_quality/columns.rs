//! Faults of whole columns, weighed by the rigid model: sign, order, unit.

use super::compensated::{compensated, lacks_gravity_of_priors, rest_without_gravity, weightless};
use super::currents::other_units;
use super::fault::{DataFault, FaultKind, Remedy};
use super::order::{Projection, Sampled};
use super::permuted::{alphabetical, order_of_priors};
use super::reading::{degrees, read_otherwise};
use super::sign::Physics;
use crate::cancel::CancelFlag;
use crate::diagnosis::settings::SETTINGS;
use crate::dynamics::Motion;
use crate::model::{Robot, decimals};

/// Torque columns, their signs and order, their unit and whether gravity is in them, and the unit and order of the positions,
/// weighed by the rigid model along the motion. Joints whose torque takes no part are neither accused nor witnesses, and nothing
/// is accused where the model explains no more than a constant.
///
/// `torque`: n × N. Of long motions every so many samples are taken.
pub fn column_faults(robot: &Robot, motion: &Motion, torque: &[Vec<f64>]) -> Vec<DataFault> {
    column_faults_until(robot, motion, torque, &CancelFlag::default())
}

/// The same, left when `cancel` is set, as by [`CancelFlag::leave_if_set`]: within [`CancelFlag::run`].
pub fn column_faults_until(robot: &Robot, motion: &Motion, torque: &[Vec<f64>], cancel: &CancelFlag) -> Vec<DataFault> {
    let found = degrees(robot, motion);
    if !found.is_empty() {
        return found;
    }
    let step = (motion.samples() / SETTINGS.data_quality.samples).max(1);
    let thinned = Motion::from_fn(robot.joint_count(), motion.samples().div_ceil(step), |j, s| {
        motion.get(j, s * step)
    });
    let torque = torque.iter().map(|t| t.iter().step_by(step).copied().collect()).collect();
    let sampled = Sampled::new(robot, thinned, torque, cancel);
    if !sampled.active.contains(&true) {
        return Vec::new();
    }
    let projection = Projection::new(&sampled, &[]);
    let n = robot.joint_count();
    let identity: Vec<usize> = (0..n).collect();
    let plain = projection.rest(&identity, &vec![1.0; n]);
    let (order, signs) = projection.best();
    let by_torque = projection.rest(&order, &signs);
    // Whatever leaves least is the fault; torque columns first, where nothing else leaves clearly less.
    let least = by_torque + projection.floor();
    if let Some(fault) = other_reading(&sampled, plain, least) {
        return vec![fault];
    }
    if let Some(fault) = by_priors(&sampled, plain) {
        return vec![fault];
    }
    // What the model does not explain says nothing of order and signs.
    if !projection.explains(&order, &signs) {
        return Vec::new();
    }
    let mut found = Vec::new();
    if order != identity {
        found.push(exchanged_torques(robot, &order, plain / by_torque.max(f64::MIN_POSITIVE)));
    }
    let physics = Physics::new(&sampled, &projection);
    let signs = physics.dissipating(&order, &signs);
    let signs = physics.global_sign(&order, &signs);
    let rest = projection.rest(&order, &signs);
    let signs = not_sprung(&sampled, &order, signs, rest);
    found.extend(turned_torques(robot, &signs));
    found
}

/// The columns meant otherwise, or torques without gravity, where that leaves clearly less than the columns as they are, which
/// leave `plain`, and than any order and signs of the torque columns, which leave `least`.
fn other_reading(sampled: &Sampled, plain: f64, least: f64) -> Option<DataFault> {
    let robot = sampled.robot;
    let floating = weightless(robot);
    let less = |rest: f64| plain / rest.max(f64::MIN_POSITIVE);
    let readings = read_otherwise(sampled, alphabetical(robot)).map(|(rest, reading)| (rest, reading.named(robot, less(rest))));
    let without_gravity = rest_without_gravity(sampled, &floating).map(|rest| {
        let evidence = format!("without gravity the model leaves {} times less", decimals(less(rest), 0));
        (rest, compensated(robot, &evidence))
    });
    let best = readings.into_iter().chain(without_gravity).min_by(|x, y| x.0.total_cmp(&y.0));
    best.filter(|(rest, _)| plain > SETTINGS.data_quality.clearly_better * rest && least > SETTINGS.data_quality.alike * rest)
        .map(|(_, fault)| fault)
}

/// What the rigid model alone does not show, but the prior parameters of the links do.
fn by_priors(sampled: &Sampled, plain: f64) -> Option<DataFault> {
    let robot = sampled.robot;
    let compensated_by_priors = || {
        let n = robot.joint_count();
        let floating = weightless(robot);
        let explains = || Projection::new(sampled, &[]).explains(&(0..n).collect::<Vec<_>>(), &vec![1.0; n]);
        (lacks_gravity_of_priors(sampled, &floating) && explains())
            .then(|| compensated(robot, "next to nothing of what the links' prior parameters weigh is in them"))
    };
    order_of_priors(sampled)
        .or_else(|| other_units(sampled, plain))
        .or_else(compensated_by_priors)
}

/// Torque columns in another order.
fn exchanged_torques(robot: &Robot, order: &[usize], less: f64) -> DataFault {
    let name = |j: usize| robot.joints()[j].name.clone();
    let moved = (0..order.len()).filter(|&j| order[j] != j).map(name).collect();
    let detail = format!(
        "with the torque columns taken in the order {} the model leaves {} times less: check the mapping",
        order.iter().map(|&k| name(k)).collect::<Vec<_>>().join(", "),
        decimals(less, 0),
    );
    DataFault::new(FaultKind::JointOrder, moved, detail, Remedy::Nothing)
}

fn turned_torques(robot: &Robot, signs: &[f64]) -> Option<DataFault> {
    let flipped: Vec<String> = (0..signs.len())
        .filter(|&j| signs[j] < 0.0)
        .map(|j| robot.joints()[j].name.clone())
        .collect();
    let detail = format!(
        "the torque of {} has the opposite sign of what the motion takes: set `sign` to -1 in `columns`",
        flipped.join(", ")
    );
    (!flipped.is_empty()).then(|| DataFault::new(FaultKind::TorqueSign, flipped, detail, Remedy::Turn))
}

/// The signs without those of single joints that a level and a spring explain clearly better than a column turned round, which
/// leaves `rest`: a strong spring pulls like gravity turned round.
fn not_sprung(sampled: &Sampled, order: &[usize], mut signs: Vec<f64>, rest: f64) -> Vec<f64> {
    let turned: Vec<usize> = (0..signs.len()).filter(|&j| signs[j] < 0.0).collect();
    // All of them turned is no question of one joint.
    if turned.len() == signs.len() {
        return signs;
    }
    for j in turned {
        let mut right = signs.clone();
        right[j] = 1.0;
        let level = vec![(j, vec![1.0; sampled.motion.samples()])];
        let spring = vec![(j, sampled.motion.positions(j).to_vec())];
        if SETTINGS.data_quality.alike * Projection::new(sampled, &[level, spring]).rest(order, &right) < rest {
            signs = right;
        }
    }
    signs
}
