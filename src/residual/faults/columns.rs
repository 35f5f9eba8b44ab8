//! Faults of whole columns, weighed by the rigid model: sign, order, unit.

use super::order::Projection;
use super::reading::{degrees, read_otherwise};
use super::{DataFault, FaultKind, Remedy};
use crate::dynamics::Motion;
use crate::model::Robot;

/// Samples that carry the question of a whole column: some hundred, spread over the motion.
const SAMPLES: usize = 500;

/// Torque columns, their signs and order, and the unit of the positions, weighed by the rigid model along the motion.
///
/// `torque`: n × N. Of long motions every so many samples are taken.
pub fn column_faults(robot: &Robot, motion: &Motion, torque: &[Vec<f64>]) -> Vec<DataFault> {
    let found = degrees(robot, motion);
    if !found.is_empty() {
        return found;
    }
    let step = (motion.samples() / SAMPLES).max(1);
    let motion = &Motion::from_fn(robot.joint_count(), motion.samples().div_ceil(step), |j, s| {
        motion.get(j, s * step)
    });
    let torque: Vec<Vec<f64>> = torque.iter().map(|t| t.iter().step_by(step).copied().collect()).collect();
    let torque = &torque[..];
    let projection = Projection::new(robot, motion, torque, None);
    let n = robot.joint_count();
    let identity: Vec<usize> = (0..n).collect();
    let plain = projection.rest(&identity, &vec![1.0; n]);
    let (order, signs) = projection.best();
    let by_torque = projection.rest(&order, &signs);
    // Whatever leaves least is the fault; torque columns first, where nothing else leaves clearly less.
    let by_position =
        read_otherwise(robot, motion, torque).filter(|(rest, _)| plain > CLEARLY * rest && by_torque > ALIKE * rest);
    if let Some((rest, fault)) = by_position {
        return vec![fault.named(robot, plain / rest.max(f64::MIN_POSITIVE))];
    }
    let name = |j: usize| robot.joints()[j].name.clone();
    let moved: Vec<usize> = (0..n).filter(|&j| order[j] != j).collect();
    let mut found = Vec::new();
    if !moved.is_empty() {
        let detail = format!(
            "with the torque columns taken in the order {} the model leaves {:.0} times less: check the mapping",
            order.iter().map(|&k| name(k)).collect::<Vec<_>>().join(", "),
            plain / by_torque.max(f64::MIN_POSITIVE)
        );
        found.push(DataFault {
            fault: FaultKind::JointOrder,
            joints: moved.iter().map(|&j| name(j)).collect(),
            detail,
            remedy: Remedy::Nothing,
            parameters: Vec::new(),
        });
    }
    let signs = projection.dissipating(robot, motion, &order, &signs);
    let signs = projection.global_sign(robot, motion, &order, &signs);
    let rest = projection.rest(&order, &signs);
    let signs = not_sprung(robot, motion, torque, &order, signs, rest);
    let flipped: Vec<String> = (0..n).filter(|&j| signs[j] < 0.0).map(name).collect();
    if !flipped.is_empty() {
        let detail = format!(
            "the torque of {} has the opposite sign of what the motion takes: set `sign` to -1 in `columns`",
            flipped.join(", ")
        );
        found.push(DataFault {
            fault: FaultKind::TorqueSign,
            joints: flipped,
            detail,
            remedy: Remedy::Turn,
            parameters: Vec::new(),
        });
    }
    found
}

/// The signs without those of single joints that a level and a spring explain clearly better than a column turned round, which leaves `rest`: a strong
/// spring pulls like gravity turned round.
fn not_sprung(robot: &Robot, motion: &Motion, torque: &[Vec<f64>], order: &[usize], mut signs: Vec<f64>, rest: f64) -> Vec<f64> {
    let turned: Vec<usize> = (0..signs.len()).filter(|&j| signs[j] < 0.0).collect();
    // All of them turned is no question of one joint.
    if turned.len() == signs.len() {
        return signs;
    }
    for j in turned {
        let mut right = signs.clone();
        right[j] = 1.0;
        if ALIKE * Projection::new(robot, motion, torque, Some(j)).rest(order, &right) < rest {
            signs = right;
        }
    }
    signs
}

/// How many times less a hypothesis must leave before it is believed: one joint's wrong column leaves most of that joint's torque, noise and
/// missing effects a few percent of it.
pub(super) const CLEARLY: f64 = 4.0;

/// Two explanations whose rests differ by less are alike; the one about torque columns, which can be turned round, is taken.
const ALIKE: f64 = 1.2;
