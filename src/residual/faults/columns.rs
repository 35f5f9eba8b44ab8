//! Faults of whole columns, weighed by the rigid model: sign, order, unit.

use super::sign::{friction_power, physical_sign};
use super::{DataFault, FaultKind, Remedy};
use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks};
use crate::model::Robot;
use crate::parameters::Layout;
use crate::residual::AugmentedModel;
use crate::residual::system::pseudo_inverse;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

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

/// Positions that no arm reaches in radians: more than three turns of travel, and within two turns when read as degrees.
fn degrees(robot: &Robot, motion: &Motion) -> Vec<DataFault> {
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
    vec![DataFault {
        fault: FaultKind::UnitMismatch,
        joints,
        detail,
        remedy: Remedy::Nothing,
    }]
}

/// How many times less a hypothesis must leave before it is believed: one joint's wrong column leaves most of that joint's torque, noise and
/// missing effects a few percent of it.
const CLEARLY: f64 = 4.0;

/// Several faults at once: each must leave so many times less than without it.
const PART: f64 = 1.5;
/// A joint with parameters mostly its own leaves hardly less when turned rightly: that must show in the thousand rows or so, and friction has a say
/// afterwards.
const TURN: f64 = 1.1;
/// Arms of up to so many joints have all patterns of signs tried; longer ones one joint at a time.
const MOST_EXHAUSTED: usize = 12;

/// Two explanations whose rests differ by less are alike; the one about torque columns, which can be turned round, is taken.
const ALIKE: f64 = 1.2;

/// Every torque column in every joint's row, with the base regressor projected out: sums of squares of all hypotheses at once.
struct Projection {
    joints: usize,
    /// `⟨P e_row(a) tau(b), P e_row(c) tau(d)⟩` at `(a n + b, c n + d)`.
    products: DMatrix<f64>,
    /// `G⁺ Wᵀ e_row(a) tau(b)` as columns a n + b: what least squares makes of it.
    solutions: DMatrix<f64>,
}

impl Projection {
    /// With a level and a spring of the joint `sprung` beside the rigid body, where there is one.
    fn new(robot: &Robot, motion: &Motion, torque: &[Vec<f64>], sprung: Option<usize>) -> Self {
        let n = robot.joint_count();
        let model = AugmentedModel::declared(robot);
        let set = ColumnSet::new(robot, &Layout::standard(robot), &model.base.kept);
        let samples = motion.samples();
        let mut rows = RowBlocks::new(&set, samples);
        rows.fill(&Chain::new(robot), &set, motion, Coulomb::Sign);
        let rigid = set.len();
        let p = rigid + if sprung.is_some() { 2 } else { 0 };
        // Rows weigh by the inverse of what their torque is made of, so that strong joints do not drown weak ones.
        let weight: Vec<f64> = torque
            .iter()
            .map(|t| 1.0 / (t.iter().map(|v| v * v).sum::<f64>() / samples as f64).sqrt().max(1e-12))
            .collect();
        let blocks: Vec<DMatrix<f64>> = (0..n)
            .map(|j| {
                let mut m = DMatrix::zeros(samples, p);
                for (values, &at) in rows.block(j).chunks_exact(rows.stride()).zip(set.row(j)) {
                    m.column_mut(at).copy_from_slice(&values[..samples]);
                }
                if sprung == Some(j) {
                    m.column_mut(rigid).fill(1.0);
                    m.column_mut(rigid + 1).copy_from_slice(motion.positions(j));
                }
                m * weight[j]
            })
            .collect();
        let normal = blocks.iter().map(|b| b.tr_mul(b)).fold(DMatrix::zeros(p, p), |a, b| a + b);
        let inverse = pseudo_inverse(&normal, 1e-10);
        let tau = DMatrix::from_fn(samples, n, |s, j| torque[j][s]);
        let mut cross = DMatrix::zeros(p, n * n);
        for (a, block) in blocks.iter().enumerate() {
            cross.columns_mut(a * n, n).copy_from(&(block.tr_mul(&tau) * weight[a]));
        }
        let own = tau.tr_mul(&tau);
        let solutions = &inverse * &cross;
        let mut products = -cross.tr_mul(&solutions);
        for a in 0..n {
            let mut corner = products.view_mut((a * n, a * n), (n, n));
            corner += &own * (weight[a] * weight[a]);
        }
        Self {
            joints: n,
            products,
            solutions,
        }
    }

    fn places(&self, order: &[usize]) -> Vec<usize> {
        (0..self.joints).map(|a| a * self.joints + order[a]).collect()
    }

    /// Sum of squares left with these columns and signs.
    fn rest(&self, order: &[usize], signs: &[f64]) -> f64 {
        let at = self.places(order);
        (0..self.joints)
            .map(|a| {
                (0..self.joints)
                    .map(|b| signs[a] * signs[b] * self.products[(at[a], at[b])])
                    .sum::<f64>()
            })
            .sum()
    }

    /// The order and signs that leave clearly less than the columns as they are: one exchange after the other, each with its best signs, until
    /// none helps.
    fn best(&self) -> (Vec<usize>, Vec<f64>) {
        let identity: Vec<usize> = (0..self.joints).collect();
        let plain = self.rest(&identity, &vec![1.0; self.joints]);
        let mut order = identity.clone();
        let (mut score, mut signs) = self.signed(&order);
        loop {
            let exchanges = (0..self.joints).flat_map(|a| (a + 1..self.joints).map(move |b| (a, b)));
            let tried = exchanges.map(|(a, b)| {
                let mut swapped = order.clone();
                swapped.swap(a, b);
                let (score, signs) = self.signed(&swapped);
                (score, swapped, signs)
            });
            match tried.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some(best) if best.0 < score / PART => (score, order, signs) = best,
                _ => break,
            }
        }
        if plain > CLEARLY * self.rest(&order, &signs) {
            (order, signs)
        } else {
            (identity, vec![1.0; self.joints])
        }
    }

    /// The best signs for an order, and what they leave times [`TURN`] for every joint turned. All joints turned are as good as none, so that the
    /// sign of the last is free.
    fn signed(&self, order: &[usize]) -> (f64, Vec<f64>) {
        let n = self.joints;
        let weigh = |signs: Vec<f64>| {
            let turned = signs.iter().filter(|s| **s < 0.0).count();
            let fewer = if 2 * turned > n {
                signs.iter().map(|s| -s).collect()
            } else {
                signs
            };
            (self.rest(order, &fewer) * TURN.powi(turned.min(n - turned) as i32), fewer)
        };
        let of = |mask: usize| {
            (0..n)
                .map(|j| if mask >> j & 1 == 1 { -1.0 } else { 1.0 })
                .collect::<Vec<f64>>()
        };
        let masks: Vec<usize> = match n {
            0..=MOST_EXHAUSTED => (0..1 << (n - 1)).collect(),
            _ => std::iter::once(0).chain((0..n).map(|j| 1 << j)).collect(),
        };
        let all = masks.into_iter().map(|mask| weigh(of(mask)));
        all.min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("no joint turned is one of them")
    }

    /// Base parameters on the given columns.
    fn values(&self, order: &[usize], signs: &[f64]) -> DVector<f64> {
        let at = self.places(order);
        (0..self.joints)
            .map(|a| self.solutions.column(at[a]) * signs[a])
            .fold(DVector::zeros(self.solutions.nrows()), |a, b| a + b)
    }

    /// A joint whose parameters are mostly its own fits nearly as well with its torque turned; but its friction then drives. Such a joint is turned
    /// where friction says so against the other joints' and the fit hardly gets worse. What would call the joint's own sign wrong is not believed against
    /// friction, however well it fits.
    fn dissipating(&self, robot: &Robot, motion: &Motion, order: &[usize], signs: &[f64]) -> Vec<f64> {
        let mut signs = signs.to_vec();
        let power = |signs: &[f64]| friction_power(robot, motion, &self.values(order, signs));
        let majority = power(&signs).iter().map(|p| p.signum()).sum::<f64>();
        let majority = if majority < 0.0 { -1.0 } else { 1.0 };
        for j in 0..self.joints {
            let mut turned = signs.clone();
            turned[j] = -turned[j];
            let against = power(&signs)[j] * majority < 0.0 && power(&turned)[j] * majority > 0.0;
            let claimed = signs[j] * majority < 0.0;
            if against && (claimed || self.rest(order, &turned) < TURN * self.rest(order, &signs)) {
                signs = turned;
            }
        }
        signs
    }

    /// Least squares fits all signs turned at once just as well: friction that would drive, inertia below zero, or a prior that says the
    /// opposite decide.
    fn global_sign(&self, robot: &Robot, motion: &Motion, order: &[usize], signs: &[f64]) -> Vec<f64> {
        let vote = physical_sign(robot, motion, &self.values(order, signs));
        signs.iter().map(|s| s * vote).collect()
    }
}

/// How the position columns could be meant otherwise.
#[derive(Debug, Clone)]
enum Reading {
    Exchanged(usize, usize),
    Degrees(Vec<usize>),
}

impl Reading {
    fn of(&self, motion: &Motion) -> Motion {
        let state = |j: usize, s: usize| match self {
            Self::Exchanged(a, b) if j == *a => motion.get(*b, s),
            Self::Exchanged(a, b) if j == *b => motion.get(*a, s),
            Self::Degrees(joints) if joints.contains(&j) => motion.get(j, s).map(f64::to_radians),
            _ => motion.get(j, s),
        };
        Motion::from_fn(motion.joints(), motion.samples(), state)
    }

    fn named(&self, robot: &Robot, less: f64) -> DataFault {
        let name = |j: &usize| robot.joints()[*j].name.clone();
        let (fault, joints, detail) = match self {
            Self::Exchanged(a, b) => {
                let joints = vec![name(a), name(b)];
                let detail = format!("with the position columns of {} exchanged", joints.join(" and "));
                (
                    FaultKind::JointOrder,
                    joints,
                    format!("{detail} the model leaves {less:.0} times less: check the mapping"),
                )
            }
            Self::Degrees(joints) => {
                let joints: Vec<String> = joints.iter().map(name).collect();
                let detail = format!("with the positions of {} read as degrees", joints.join(", "));
                (
                    FaultKind::UnitMismatch,
                    joints,
                    format!("{detail} the model leaves {less:.0} times less: give the unit in `columns`"),
                )
            }
        };
        DataFault {
            fault,
            joints,
            detail,
            remedy: Remedy::Nothing,
        }
    }
}

/// Whether a joint may have been written in degrees: as radians its positions leave its limits, or, where it has none, travel more than half a turn.
/// What stays inside as radians is a motion of a degree or two as degrees, which nobody records; and a strong spring on a joint whose weight is shrunk
/// so far that gravity is a straight line fits better than the truth without the spring.
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

/// The reading of the position columns that leaves least, each with its own regressor: two exchanged, one or all in degrees.
fn read_otherwise(robot: &Robot, motion: &Motion, torque: &[Vec<f64>]) -> Option<(f64, Reading)> {
    let n = robot.joint_count();
    let turning: Vec<usize> = (0..n).filter(|&j| may_be_degrees(robot, motion, j)).collect();
    let exchanges = (0..n).flat_map(|a| (a + 1..n).map(move |b| Reading::Exchanged(a, b)));
    let single = turning.iter().map(|&j| Reading::Degrees(vec![j]));
    let all = (turning.len() > 1).then(|| Reading::Degrees(turning.clone()));
    let readings: Vec<Reading> = exchanges.chain(single).chain(all).collect();
    let rest = |reading: Reading| {
        let projection = Projection::new(robot, &reading.of(motion), torque, None);
        (projection.rest(&(0..n).collect::<Vec<_>>(), &vec![1.0; n]), reading)
    };
    let tried: Vec<(f64, Reading)> = readings.into_par_iter().map(rest).collect();
    tried.into_iter().min_by(|x, y| x.0.total_cmp(&y.0))
}
