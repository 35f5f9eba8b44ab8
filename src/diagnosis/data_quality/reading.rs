//! Position columns that are meant otherwise: in degrees, or exchanged.

use super::fault::{DataFault, FaultKind, Remedy};
use super::order::{Projection, Sampled};
use super::permuted::{reordered, swapped};
use crate::dynamics::Motion;
use crate::model::{Robot, decimals};
use rayon::prelude::*;

/// Positions that no arm reaches in radians: more than three turns of travel, and within two turns when read as degrees.
pub(crate) fn degrees(robot: &Robot, motion: &Motion) -> Vec<DataFault> {
    let turn = 2.0 * std::f64::consts::PI;
    let suspicious = |j: usize| {
        let joint = &robot.joints()[j];
        let q = motion.positions(j);
        let (low, high) = q
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
        let beyond = joint
            .limits
            .position
            .map(|[l, h]| low < l - 0.5 * turn || high > h + 0.5 * turn);
        let fits = joint
            .limits
            .position
            .is_none_or(|[l, h]| low.to_radians() >= l - 0.1 && high.to_radians() <= h + 0.1);
        joint.is_revolute() && fits && beyond.unwrap_or(high - low > 3.0 * turn) && (high - low).to_radians() < 2.0 * turn
    };
    let joints: Vec<String> = (0..robot.joint_count())
        .filter(|&j| suspicious(j))
        .map(|j| robot.joints()[j].name.clone())
        .collect();
    if joints.is_empty() {
        return Vec::new();
    }
    let detail = format!(
        "positions of {} look like degrees: give the unit in `columns`",
        joints.join(", ")
    );
    vec![DataFault::new(FaultKind::UnitMismatch, joints, detail, Remedy::Nothing)]
}

/// How the position columns could be meant otherwise.
#[derive(Debug, Clone)]
pub(crate) enum Reading {
    Exchanged(usize, usize),
    Degrees(Vec<usize>),
    /// Position and torque of joint j both stand in the columns of joint `order[j]`.
    Permuted(Vec<usize>),
}

impl Reading {
    fn of(&self, motion: &Motion) -> Motion {
        let state = |j: usize, s: usize| match self {
            Self::Exchanged(a, b) if j == *a => motion.get(*b, s),
            Self::Exchanged(a, b) if j == *b => motion.get(*a, s),
            Self::Permuted(order) => motion.get(order[j], s),
            Self::Degrees(joints) if joints.contains(&j) => motion.get(j, s).map(f64::to_radians),
            _ => motion.get(j, s),
        };
        Motion::from_fn(motion.joints(), motion.samples(), state)
    }

    /// The columns that the torques of the joints stand in.
    pub fn torque_order(&self, joints: usize) -> Vec<usize> {
        match self {
            Self::Permuted(order) => order.clone(),
            _ => (0..joints).collect(),
        }
    }

    /// What leaves `less` times less than the columns as they are.
    pub fn named(&self, robot: &Robot, less: f64) -> DataFault {
        let name = |j: &usize| robot.joints()[*j].name.clone();
        let less = decimals(less, 0);
        let (fault, joints, detail) = match self {
            Self::Exchanged(a, b) => {
                let joints = vec![name(a), name(b)];
                let detail = format!("with the position columns of {} exchanged", joints.join(" and "));
                (
                    FaultKind::JointOrder,
                    joints,
                    format!("{detail} the model leaves {less} times less: check the mapping"),
                )
            }
            Self::Permuted(order) => return reordered(robot, order, &format!("leaves {less} times less")),
            Self::Degrees(joints) => {
                let joints: Vec<String> = joints.iter().map(name).collect();
                let detail = format!("with the positions of {} read as degrees", joints.join(", "));
                (
                    FaultKind::UnitMismatch,
                    joints,
                    format!("{detail} the model leaves {less} times less: give the unit in `columns`"),
                )
            }
        };
        DataFault::new(fault, joints, detail, Remedy::Nothing)
    }
}

/// Whether a joint may have been written in degrees: as radians its positions leave its limits, or, where it has none, travel
/// more than half a turn. What stays inside as radians is a motion of a degree or two as degrees, which nobody records; and a
/// strong spring on a joint whose weight is shrunk so far that gravity is a straight line fits better than the truth without the
/// spring.
fn may_be_degrees(robot: &Robot, motion: &Motion, joint: usize) -> bool {
    let of = &robot.joints()[joint];
    let q = motion.positions(joint);
    let (low, high) = q
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    let outside = match of.limits.position {
        Some([least, most]) => low < least || high > most,
        None => high - low > std::f64::consts::PI,
    };
    of.is_revolute() && outside
}

/// The reading of the columns that leaves least, each with its own regressor: two positions exchanged, with their torques or
/// without, one or all in degrees, or all columns in another `order`. Only readings that explain more than a constant count.
pub(crate) fn read_otherwise(sampled: &Sampled, order: Option<Vec<usize>>) -> Option<(f64, Reading)> {
    let n = sampled.robot.joint_count();
    let turning: Vec<usize> = (0..n)
        .filter(|&j| may_be_degrees(sampled.robot, &sampled.motion, j))
        .collect();
    let exchanges = (0..n).flat_map(|a| (a + 1..n).map(move |b| Reading::Exchanged(a, b)));
    let single = turning.iter().map(|&j| Reading::Degrees(vec![j]));
    let all = (turning.len() > 1).then(|| Reading::Degrees(turning.clone()));
    let readings: Vec<Reading> = exchanges
        .chain(single)
        .chain(all)
        .chain(order.map(Reading::Permuted))
        .collect();
    let projected = |motion: &Reading| Projection::new(&sampled.with(motion.of(&sampled.motion)), &[]);
    let best = |motion: Reading| {
        let projection = projected(&motion);
        // The motion of two positions exchanged is that of two joints exchanged.
        let with_torques = match motion {
            Reading::Exchanged(a, b) => Some(Reading::Permuted(swapped(n, a, b))),
            _ => None,
        };
        let weighed = |reading: Reading| (projection.rest(&reading.torque_order(n), &vec![1.0; n]), reading);
        let both = std::iter::once(motion.clone()).chain(with_torques).map(weighed);
        let (rest, reading) = both.min_by(|x, y| x.0.total_cmp(&y.0))?;
        Some((rest, motion, reading))
    };
    let mut tried: Vec<_> = readings.into_par_iter().filter_map(best).collect();
    // The best that explains the torques is asked for: hardly ever more than one has to be tried.
    tried.sort_by(|x, y| x.0.total_cmp(&y.0));
    let explains =
        |(_, motion, reading): &(f64, Reading, Reading)| projected(motion).explains(&reading.torque_order(n), &vec![1.0; n]);
    tried.into_iter().find(explains).map(|(rest, _, reading)| (rest, reading))
}
