//! Joints whose position and torque columns are exchanged alike: `joint_states` of ROS are in alphabetical order.
//!
//! An arm with two joints exchanged is another arm, which the rigid model fits worse; where it fits nearly as well, the links'
//! prior parameters tell the two apart.

use super::fault::{DataFault, FaultKind, Remedy};
use super::order::{Projection, Sampled, root_mean_square};
use crate::diagnosis::settings::SETTINGS;
use crate::dynamics::{Chain, Coulomb, Motion, inverse_dynamics_batch};
use crate::model::{Robot, decimals};
use crate::parameters::Layout;

/// Two joints of n exchanged.
pub(crate) fn swapped(n: usize, a: usize, b: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n).collect();
    order.swap(a, b);
    order
}

/// Where each joint's columns stand when columns are in the alphabetical order of the names; `None` where that is the order of
/// the arm.
pub(crate) fn alphabetical(robot: &Robot) -> Option<Vec<usize>> {
    let names: Vec<&str> = robot.joints().iter().map(|j| j.name.as_str()).collect();
    let mut sorted = names.clone();
    sorted.sort_unstable();
    let place = |name: &&str| sorted.iter().position(|s| s == name);
    let order: Vec<usize> = names.iter().filter_map(place).collect();
    (order.iter().enumerate().any(|(j, &k)| j != k)).then_some(order)
}

/// Position and torque columns in another order.
pub(crate) fn reordered(robot: &Robot, order: &[usize], evidence: &str) -> DataFault {
    let name = |j: usize| robot.joints()[j].name.clone();
    let names: Vec<String> = order.iter().map(|&k| name(k)).collect();
    let how = match alphabetical(robot).is_some_and(|a| a == order) {
        true => "in the alphabetical order of the joint names, as `joint_states` of ROS are",
        false => "exchanged alike",
    };
    let moved = (0..order.len()).filter(|&j| order[j] != j).map(name).collect();
    let detail = format!(
        "position and torque columns look {how}: taken in the order {} the model {evidence}; check the mapping",
        names.join(", ")
    );
    DataFault::new(FaultKind::JointOrder, moved, detail, Remedy::Nothing)
}

/// The order of position and torque columns in which the links' priors agree with the torques, where they do not as the columns
/// are.
pub(crate) fn order_of_priors(sampled: &Sampled) -> Option<DataFault> {
    let robot = sampled.robot;
    let n = robot.joint_count();
    let identity: Vec<usize> = (0..n).collect();
    let plain = left_by_priors(sampled, &identity)?;
    if plain < SETTINGS.data_quality.priors_disagree {
        return None;
    }
    let (mut best, mut order) = (plain, identity.clone());
    loop {
        let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
        let exchanged = pairs.map(|(a, b)| {
            let mut other = order.clone();
            other.swap(a, b);
            other
        });
        let tried = exchanged
            .chain(alphabetical(robot))
            .filter_map(|o| Some((left_by_priors(sampled, &o)?, o)));
        match tried.min_by(|x, y| x.0.total_cmp(&y.0)) {
            Some((left, other)) if left < 0.9 * best => (best, order) = (left, other),
            _ => break,
        }
    }
    let agrees = best < SETTINGS.data_quality.priors_agree && plain > SETTINGS.data_quality.clearly_better * best;
    if !agrees || order == identity {
        return None;
    }
    let there = sampled.with(permuted(&sampled.motion, &order));
    let (projection, signs) = (Projection::new(&there, &[]), vec![1.0; n]);
    let fits = projection.rest(&order, &signs)
        < SETTINGS.data_quality.order_no_worse * Projection::new(sampled, &[]).rest(&identity, &signs);
    let evidence = format!(
        "with the links' prior parameters predicts the torques ({} % of their square is left, as the columns are {} %)",
        decimals(100.0 * best, 0),
        decimals(100.0 * plain, 0)
    );
    (fits && projection.explains(&order, &signs)).then(|| reordered(robot, &order, &evidence))
}

fn permuted(motion: &Motion, order: &[usize]) -> Motion {
    Motion::from_fn(motion.joints(), motion.samples(), |j, s| motion.get(order[j], s))
}

/// Part of the torques' squares that the prior parameters leave, mean over the joints, for columns in this order; `None` without
/// priors.
fn left_by_priors(sampled: &Sampled, order: &[usize]) -> Option<f64> {
    let robot = sampled.robot;
    let layout = Layout::standard(robot);
    let prior = layout.prior(robot)?;
    let motion = permuted(&sampled.motion, order);
    let predicted = inverse_dynamics_batch(&Chain::new(robot), &layout, prior.as_slice(), &motion, Coulomb::Sign);
    let of = |a: usize| {
        let torque = &sampled.torque[order[a]];
        let own = &predicted[a * motion.stride()..][..torque.len()];
        let off: Vec<f64> = torque.iter().zip(own).map(|(t, p)| t - p).collect();
        (root_mean_square(&off) / root_mean_square(torque)).powi(2)
    };
    let active: Vec<usize> = (0..robot.joint_count()).filter(|&a| sampled.active[order[a]]).collect();
    Some(active.iter().map(|&a| of(a)).sum::<f64>() / active.len().max(1) as f64)
}
