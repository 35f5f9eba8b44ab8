//! Wrong data, not wrong physics: what is checked before any effect is blamed.
//!
//! Faults of single samples (garbage, frozen, clipped, repeated times) are looked for in the columns themselves. Faults of whole columns
//! (sign, order, unit) are hypotheses about the data that the rigid model can weigh: the sum of squares that least squares leaves, for
//! every sign and every exchange of torque columns, is a quadratic form in the columns projected once.

use super::AugmentedModel;
use super::system::pseudo_inverse;
use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks, inverse_dynamics_batch};
use crate::model::Robot;
use crate::parameters::{Layout, ParameterKind};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    TorqueSign,
    JointOrder,
    UnitMismatch,
    BadSamples,
}

impl FaultKind {
    /// Name in documents.
    pub fn code(self) -> &'static str {
        match self {
            Self::TorqueSign => "torque_sign",
            Self::JointOrder => "joint_order",
            Self::UnitMismatch => "unit_mismatch",
            Self::BadSamples => "bad_samples",
        }
    }
}

/// A fault, named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DataFault {
    pub fault: FaultKind,
    /// Joints whose columns are concerned.
    pub joints: Vec<String>,
    /// What was seen, and what to do.
    pub detail: String,
}

/// A log as recorded: rows in the order of the file, before anything is repaired.
#[derive(Debug, Clone, PartialEq)]
pub struct RawLog {
    /// (s); empty where the log has none.
    pub time: Vec<f64>,
    /// Per joint.
    pub q: Vec<Vec<f64>>,
    /// Per joint.
    pub tau: Vec<Vec<f64>>,
}

/// Faults of the samples of a log, from the columns alone.
pub fn sample_faults(robot: &Robot, log: &RawLog) -> Vec<DataFault> {
    let mut found = Vec::new();
    let bad = |joints: Vec<String>, detail: String| DataFault {
        fault: FaultKind::BadSamples,
        joints,
        detail,
    };
    if let Some(detail) = time_faults(&log.time) {
        found.push(bad(Vec::new(), detail));
    }
    let garbage = garbage_rows(log);
    if !garbage.is_empty() {
        let detail = format!(
            "{} rows hold numbers that do not belong to a motion, the first is row {}: leave them out",
            garbage.len(),
            garbage[0] + 1
        );
        found.push(bad(Vec::new(), detail));
    }
    let clean = |column: &[f64]| -> Vec<f64> {
        (0..column.len())
            .filter(|s| garbage.binary_search(s).is_err())
            .map(|s| column[s])
            .collect()
    };
    if let Some((first, length)) = frozen_rows(log) {
        found.push(bad(
            Vec::new(),
            format!(
                "all columns stand still for {length} rows from row {}: the recording froze, leave the interval out",
                first + 1
            ),
        ));
    }
    for (j, joint) in robot.joints().iter().enumerate() {
        for (what, column) in [("torque", clean(&log.tau[j])), ("position", clean(&log.q[j]))] {
            let others_move = log.q.iter().enumerate().any(|(i, q)| i != j && !is_constant(&clean(q)));
            let detail = if is_constant(&column) && (what == "torque" || others_move && !is_constant(&clean(&log.tau[j]))) {
                Some(format!(
                    "the {what} column of {} is constant: not connected, or not recorded",
                    joint.name
                ))
            } else if what == "torque" {
                clipped(&column).map(|(level, count)| {
                    format!("{count} torque samples of {} lie at {level:.4}: the signal is clipped there, leave them out or lower the load", joint.name)
                })
            } else {
                None
            };
            found.extend(detail.map(|d| bad(vec![joint.name.clone()], d)));
        }
    }
    found
}

fn time_faults(time: &[f64]) -> Option<String> {
    let not_finite = time.iter().filter(|t| !t.is_finite()).count();
    let repeated = time.windows(2).filter(|w| w[1] == w[0]).count();
    let backwards = time.windows(2).filter(|w| w[1] < w[0]).count();
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let usual = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    // Half a sample more than two steps: one row at least is missing. A repeated stamp makes the next step two long, which is no gap.
    let missing = steps.iter().filter(|d| **d > 2.5 * usual).count();
    let said: Vec<String> = [
        (not_finite, "not numbers"),
        (repeated, "repeated"),
        (backwards, "going back"),
        (missing, "followed by a gap"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{count} {what}"))
    .collect();
    (!said.is_empty()).then(|| {
        format!(
            "time stamps: {}; drop repeated rows and split the log at gaps",
            said.join(", ")
        )
    })
}

/// Rows that jump away from both neighbours by far more than neighbours differ, or are not finite.
///
/// Twenty times the 99th percentile of the steps: motion and white noise stay below two, a dropped row or a stray packet is in the hundreds.
fn garbage_rows(log: &RawLog) -> Vec<usize> {
    let rows = log.q[0].len();
    let mut bad = vec![false; rows];
    for column in log.q.iter().chain(&log.tau) {
        let mut steps: Vec<f64> = column
            .windows(2)
            .map(|w| (w[1] - w[0]).abs())
            .filter(|d| d.is_finite())
            .collect();
        if steps.is_empty() {
            continue;
        }
        let at = (steps.len() * 98) / 100;
        let usual = *steps.select_nth_unstable_by(at, f64::total_cmp).1;
        let limit = (20.0 * usual).max(1e-9);
        for s in 0..rows {
            let value = column[s];
            let neighbours = [s.checked_sub(1), (s + 1 < rows).then_some(s + 1)];
            let far = neighbours
                .into_iter()
                .flatten()
                .filter(|&n| column[n].is_finite() && !bad[n])
                .all(|n| (value - column[n]).abs() > limit);
            bad[s] |= !value.is_finite() || far && usual > 0.0;
        }
    }
    (0..rows).filter(|&s| bad[s]).collect()
}

/// The longest run of rows in which no column changes, where that is far longer than the runs of a log whose rows are merely polled twice.
fn frozen_rows(log: &RawLog) -> Option<(usize, usize)> {
    let rows = log.q[0].len();
    let same = |s: usize| log.q.iter().chain(&log.tau).all(|c| c[s] == c[s - 1]);
    let mut runs: Vec<(usize, usize)> = Vec::new();
    let mut start = 0;
    for s in 1..=rows {
        if s == rows || !same(s) {
            runs.push((s - start, start));
            start = s;
        }
    }
    let longest = *runs.iter().max_by_key(|r| r.0)?;
    let mut lengths: Vec<usize> = runs.iter().map(|r| r.0).collect();
    lengths.sort_unstable();
    let usual = lengths[lengths.len() * 99 / 100];
    // Ten rows, and five times what 99 of 100 runs are: polling repeats rows once or twice.
    (longest.0 >= 10 && longest.0 > 5 * usual && longest.0 < rows).then_some((longest.1, longest.0))
}

fn is_constant(column: &[f64]) -> bool {
    column.windows(2).all(|w| w[0] == w[1])
}

/// An end of the range at which samples pile up: more there than a noisy signal puts into the hundredth of the range next to it, ten at least.
fn clipped(column: &[f64]) -> Option<(f64, usize)> {
    let (low, high) = column
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    let range = high - low;
    let mut distinct: Vec<f64> = column.to_vec();
    distinct.sort_by(f64::total_cmp);
    distinct.dedup();
    for level in [high, low] {
        let at = column.iter().filter(|v| **v == level).count();
        let near = column
            .iter()
            .filter(|v| **v != level && (**v - level).abs() <= 0.01 * range)
            .count();
        // Coarse steps put many samples on every level; then the level next to the end has as many.
        let next = distinct
            .iter()
            .filter(|v| **v != level)
            .fold(f64::INFINITY, |d, v| d.min((v - level).abs()));
        let on_next = column
            .iter()
            .filter(|v| ((**v - level).abs() - next).abs() <= 1e-12 * range)
            .count();
        if at >= 10 && at > 2 * near.min(at) && at > 3 * on_next {
            return Some((level, at));
        }
    }
    None
}

/// Torque columns, their signs and order, and the unit of the positions, weighed by the rigid model along the motion.
///
/// `motion` and `torque` (n × N) may be thinned out: some hundred samples carry the question.
pub fn column_faults(robot: &Robot, motion: &Motion, torque: &[Vec<f64>]) -> Vec<DataFault> {
    let mut found = degrees(robot, motion);
    if !found.is_empty() {
        return found;
    }
    let projection = Projection::new(robot, motion, torque);
    let n = robot.joint_count();
    let identity: Vec<usize> = (0..n).collect();
    let ones = vec![1.0; n];
    let (order, signs) = projection.best(&identity, &ones);
    let name = |j: usize| robot.joints()[j].name.clone();
    let moved: Vec<usize> = (0..n).filter(|&j| order[j] != j).collect();
    let plain = projection.rest(&identity, &ones);
    if !moved.is_empty() {
        let detail = format!(
            "with the torque columns taken in the order {} the model leaves {:.0} times less: check the mapping",
            order.iter().map(|&k| name(k)).collect::<Vec<_>>().join(", "),
            plain / projection.rest(&order, &signs).max(f64::MIN_POSITIVE)
        );
        found.push(DataFault {
            fault: FaultKind::JointOrder,
            joints: moved.iter().map(|&j| name(j)).collect(),
            detail,
        });
    } else if let Some(fault) = swapped_positions(robot, motion, torque, plain) {
        return vec![fault];
    }
    let signs = projection.dissipating(robot, motion, &order, &signs);
    let signs = projection.global_sign(robot, motion, &order, &signs);
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
        });
    }
    found
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
    }]
}

/// How many times less a hypothesis must leave before it is believed: one joint's wrong column leaves most of that joint's torque, noise and
/// missing effects a few percent of it.
const CLEARLY: f64 = 4.0;

/// Every torque column in every joint's row, with the base regressor projected out: sums of squares of all hypotheses at once.
struct Projection {
    joints: usize,
    /// `⟨P e_row(a) tau(b), P e_row(c) tau(d)⟩` at `(a n + b, c n + d)`.
    products: DMatrix<f64>,
    /// `G⁺ Wᵀ e_row(a) tau(b)` as columns a n + b: what least squares makes of it.
    solutions: DMatrix<f64>,
}

impl Projection {
    fn new(robot: &Robot, motion: &Motion, torque: &[Vec<f64>]) -> Self {
        let n = robot.joint_count();
        let model = AugmentedModel::declared(robot);
        let set = ColumnSet::new(robot, &Layout::standard(robot), &model.base.kept);
        let samples = motion.samples();
        let mut rows = RowBlocks::new(&set, samples);
        rows.fill(&Chain::new(robot), &set, motion, Coulomb::Sign);
        let p = set.len();
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

    /// The order and signs that leave clearly less than the given ones: single flips and exchanges, the best first, until none helps.
    fn best(&self, order: &[usize], signs: &[f64]) -> (Vec<usize>, Vec<f64>) {
        let (mut order, mut signs) = (order.to_vec(), signs.to_vec());
        let mut rest = self.rest(&order, &signs);
        loop {
            let mut options: Vec<(f64, Vec<usize>, Vec<f64>)> = Vec::new();
            for a in 0..self.joints {
                let mut flipped = signs.clone();
                flipped[a] = -flipped[a];
                options.push((self.rest(&order, &flipped), order.clone(), flipped));
                for b in a + 1..self.joints {
                    let (mut swapped, mut with) = (order.clone(), signs.clone());
                    swapped.swap(a, b);
                    with.swap(a, b);
                    options.push((self.rest(&swapped, &with), swapped, with));
                }
            }
            let Some(best) = options.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)) else {
                break;
            };
            // Several faults at once: each alone must still help by a part.
            if best.0 > rest / 1.5 {
                break;
            }
            (rest, order, signs) = best;
        }
        let before = self.rest(&(0..self.joints).collect::<Vec<_>>(), &vec![1.0; self.joints]);
        if before > CLEARLY * rest {
            (order, signs)
        } else {
            ((0..self.joints).collect(), vec![1.0; self.joints])
        }
    }

    /// Base parameters on the given columns.
    fn values(&self, order: &[usize], signs: &[f64]) -> DVector<f64> {
        let at = self.places(order);
        (0..self.joints)
            .map(|a| self.solutions.column(at[a]) * signs[a])
            .fold(DVector::zeros(self.solutions.nrows()), |a, b| a + b)
    }

    /// A joint whose parameters are mostly its own fits nearly as well with its torque turned; but its friction then drives. Such a joint is turned
    /// where friction says so against the other joints' and the fit does not get worse.
    fn dissipating(&self, robot: &Robot, motion: &Motion, order: &[usize], signs: &[f64]) -> Vec<f64> {
        let mut signs = signs.to_vec();
        let power = |signs: &[f64]| friction_power(robot, motion, &self.values(order, signs));
        let majority = power(&signs).iter().map(|p| p.signum()).sum::<f64>();
        let majority = if majority < 0.0 { -1.0 } else { 1.0 };
        for j in 0..self.joints {
            let mut turned = signs.clone();
            turned[j] = -turned[j];
            let against = power(&signs)[j] * majority < 0.0 && power(&turned)[j] * majority > 0.0;
            if against && self.rest(order, &turned) < self.rest(order, &signs) {
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

/// +1 or −1: which sign of the base parameters dissipates energy and has positive inertia.
///
/// With link-side torque sensors friction is small; the kinetic energy of the motion and, where the links have prior parameters, the
/// agreement with their torque are asked as well. Each votes with its share of the torque.
fn physical_sign(robot: &Robot, motion: &Motion, values: &DVector<f64>) -> f64 {
    let layout = Layout::standard(robot);
    let model = AugmentedModel::declared(robot);
    let mut phi = vec![0.0; layout.len()];
    model.base.kept.iter().zip(values.iter()).for_each(|(&at, &v)| phi[at] = v);
    if let Some(prior) = layout.prior(robot) {
        let chain = Chain::new(robot);
        let torque = |phi: &[f64]| inverse_dynamics_batch(&chain, &layout, phi, motion, Coulomb::Sign);
        let (have, want) = (torque(&phi), torque(prior.as_slice()));
        let (dot, a, b) = have
            .iter()
            .zip(&want)
            .fold((0.0, 0.0, 0.0), |(d, a, b), (x, y)| (d + x * y, a + x * x, b + y * y));
        // Priors may be off by half; a correlation of more than a half has a sign.
        if dot.abs() > 0.5 * (a * b).sqrt() {
            return dot.signum();
        }
    }
    let power = friction_power(robot, motion, values);
    let friction = (power.iter().sum::<f64>(), power.iter().map(|p| p.abs()).sum::<f64>());
    let inertia = inertia_share(robot, &layout, &phi, motion);
    let share = |(sum, size): (f64, f64)| if size > 0.0 { sum / size } else { 0.0 };
    if share(friction) + inertia < -0.5 { -1.0 } else { 1.0 }
}

/// Power that the friction of every joint takes out of the motion, summed over the samples.
fn friction_power(robot: &Robot, motion: &Motion, values: &DVector<f64>) -> Vec<f64> {
    let layout = Layout::standard(robot);
    let kept = AugmentedModel::declared(robot).base.kept;
    let mut power = vec![0.0; robot.joint_count()];
    for (&at, &value) in kept.iter().zip(values.iter()) {
        let parameter = layout.parameters()[at];
        let speeds = motion.velocities(parameter.link);
        power[parameter.link] += match parameter.kind {
            ParameterKind::Viscous => speeds.iter().map(|v| value * v * v).sum(),
            ParameterKind::Coulomb => speeds.iter().map(|v| value * v.abs()).sum(),
            ParameterKind::Inertial(_) => 0.0,
        };
    }
    power
}

/// Mean sign of the kinetic energy `½ qdᵀ M qd` along the motion, M from the inertial parameters: −1 … 1.
fn inertia_share(robot: &Robot, layout: &Layout, phi: &[f64], motion: &Motion) -> f64 {
    let n = robot.joint_count();
    let mut bare = phi.to_vec();
    for (at, parameter) in layout.parameters().iter().enumerate() {
        if !matches!(parameter.kind, ParameterKind::Inertial(_)) {
            bare[at] = 0.0;
        }
    }
    // With qd = 0, qdd = the speeds and no gravity, inverse dynamics is M qd.
    let still = Motion::from_fn(n, motion.samples(), |j, s| {
        let [q, qd, _] = motion.get(j, s);
        [q, 0.0, qd]
    });
    let weightless = robot.with_gravity(nalgebra::Vector3::zeros());
    let momentum = inverse_dynamics_batch(&Chain::new(&weightless), layout, &bare, &still, Coulomb::Sign);
    let energy = |s: usize| {
        (0..n)
            .map(|j| momentum[j * motion.stride() + s] * motion.get(j, s)[1])
            .sum::<f64>()
    };
    let (sum, size) = (0..motion.samples())
        .map(energy)
        .fold((0.0, 0.0), |(a, b), e: f64| (a + e, b + e.abs()));
    if size > 0.0 { sum / size } else { 0.0 }
}

/// Two position columns exchanged: tried one exchange at a time, each with its own regressor.
fn swapped_positions(robot: &Robot, motion: &Motion, torque: &[Vec<f64>], plain: f64) -> Option<DataFault> {
    let n = robot.joint_count();
    let tried = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))).filter_map(|(a, b)| {
        let place = |j: usize| {
            if j == a {
                b
            } else if j == b {
                a
            } else {
                j
            }
        };
        let swapped = Motion::from_fn(n, motion.samples(), |j, s| motion.get(place(j), s));
        let projection = Projection::new(robot, &swapped, torque);
        let rest = projection.rest(&(0..n).collect::<Vec<_>>(), &vec![1.0; n]);
        (plain > CLEARLY * rest).then_some((rest, a, b))
    });
    let (rest, a, b) = tried.min_by(|x, y| x.0.total_cmp(&y.0))?;
    let joints: Vec<String> = [a, b].iter().map(|&j| robot.joints()[j].name.clone()).collect();
    let detail = format!(
        "with the position columns of {} exchanged the model leaves {:.0} times less: check the mapping",
        joints.join(" and "),
        plain / rest
    );
    Some(DataFault {
        fault: FaultKind::JointOrder,
        joints,
        detail,
    })
}
