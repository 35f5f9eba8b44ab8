//! Torque columns in another order or with other signs, held against what the rigid model leaves with them.

use crate::cancel::CancelFlag;
use crate::diagnosis::settings::SETTINGS;
use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks};
use crate::model::Robot;
use crate::parameters::Layout;
use crate::preparation::{exclusions, resolution};
use crate::regression::{AugmentedModel, folds_in_time, pseudo_inverse, shares, transposed_product, with_constant};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// A further model column: its values on the rows of some joints.
pub(crate) type Extra = Vec<(usize, Vec<f64>)>;

/// Motion and torques of a log, thinned out, and which joints' torques take part.
pub(crate) struct Sampled<'a> {
    pub robot: &'a Robot,
    pub motion: Motion,
    /// n × N.
    pub torque: Vec<Vec<f64>>,
    pub active: Vec<bool>,
    /// Looked at with every hypothesis.
    pub cancel: CancelFlag,
}

impl<'a> Sampled<'a> {
    pub fn new(robot: &'a Robot, motion: Motion, torque: Vec<Vec<f64>>, cancel: &CancelFlag) -> Self {
        let still = |j: usize| motion.velocities(j).iter().all(|v| *v == 0.0);
        let still: Vec<bool> = (0..robot.joint_count()).map(still).collect();
        let excluded = exclusions(&torque, &vec![true; motion.samples()], &still);
        Self {
            robot,
            motion,
            torque,
            active: excluded.iter().map(Option::is_none).collect(),
            cancel: cancel.clone(),
        }
    }

    /// The same torques along another motion.
    pub fn with(&self, motion: Motion) -> Self {
        Self {
            robot: self.robot,
            motion,
            torque: self.torque.clone(),
            active: self.active.clone(),
            cancel: self.cancel.clone(),
        }
    }

    /// Motion and torques for another robot.
    pub fn of<'b>(&self, robot: &'b Robot) -> Sampled<'b> {
        Sampled {
            robot,
            motion: self.motion.clone(),
            torque: self.torque.clone(),
            active: self.active.clone(),
            cancel: self.cancel.clone(),
        }
    }
}

/// Every torque column in every joint's row, with the base regressor projected out: sums of squares of all hypotheses at once.
pub(crate) struct Projection {
    joints: usize,
    /// `⟨P e_row(a) tau(b), P e_row(c) tau(d)⟩` at `(a n + b, c n + d)`.
    products: DMatrix<f64>,
    /// `G⁺ Wᵀ e_row(a) tau(b)` as columns a n + b: what least squares makes of it.
    solutions: DMatrix<f64>,
    /// `G⁺`.
    inverse: DMatrix<f64>,
    /// Rows of every joint, weighted.
    blocks: Vec<DMatrix<f64>>,
    /// N × n.
    torque: DMatrix<f64>,
    weight: Vec<f64>,
    /// Standard parameters that the first columns belong to.
    pub kept: Vec<usize>,
}

impl Projection {
    /// With further columns beside the rigid body.
    pub fn new(sampled: &Sampled, extra: &[Extra]) -> Self {
        sampled.cancel.leave_if_set();
        let (robot, motion, torque) = (sampled.robot, &sampled.motion, &sampled.torque);
        let n = robot.joint_count();
        let kept = AugmentedModel::declared(robot).base.kept;
        let set = ColumnSet::new(robot, &Layout::standard(robot), &kept);
        let samples = motion.samples();
        let mut rows = RowBlocks::new(&set, samples);
        rows.fill(&Chain::new(robot), &set, motion, Coulomb::Sign);
        let rigid = set.len();
        let p = rigid + extra.len();
        // Rows weigh by the inverse of what their torque is made of, so that strong joints do not drown weak ones; those that
        // take no part, nothing.
        let of = |(t, active): (&Vec<f64>, &bool)| match (root_mean_square(t), active) {
            (size, true) if size > 0.0 => 1.0 / size,
            _ => 0.0,
        };
        let weight: Vec<f64> = torque.iter().zip(&sampled.active).map(of).collect();
        let blocks: Vec<DMatrix<f64>> = (0..n)
            .map(|j| {
                let mut m = DMatrix::zeros(samples, p);
                for (values, &at) in rows.block(j).chunks_exact(rows.stride()).zip(set.row(j)) {
                    m.column_mut(at).copy_from_slice(&values[..samples]);
                }
                for (k, column) in extra.iter().enumerate() {
                    for (_, values) in column.iter().filter(|(joint, _)| *joint == j) {
                        m.column_mut(rigid + k).copy_from_slice(values);
                    }
                }
                m * weight[j]
            })
            .collect();
        let normal = blocks
            .iter()
            .fold(DMatrix::zeros(p, p), |sum, b| sum + transposed_product(b, b));
        let inverse = pseudo_inverse(&normal, 1e-10);
        let tau = DMatrix::from_fn(samples, n, |s, j| if sampled.active[j] { torque[j][s] } else { 0.0 });
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
            inverse,
            blocks,
            torque: tau,
            weight,
            kept,
        }
    }

    /// Sum of squares that the recording of the torques leaves: no rest is known to be less.
    pub fn floor(&self) -> f64 {
        let usable = vec![true; self.torque.nrows()];
        let of = |(j, w): (usize, &f64)| (resolution(self.torque.column(j).as_slice(), &usable) * w).powi(2);
        self.torque.nrows() as f64 * self.weight.iter().enumerate().map(of).sum::<f64>()
    }

    /// Whether the model explains more than a constant per joint of these columns.
    pub fn explains(&self, order: &[usize], signs: &[f64]) -> bool {
        let p = self.inverse.nrows();
        let part = |range: Range<usize>| {
            let of = |a: usize| {
                let own = self.blocks[a].rows(range.start, range.len()).into_owned();
                let torque: Vec<f64> = range.clone().map(|s| self.row_torque(a, order, signs, s)).collect();
                let used = if self.weight[a] > 0.0 { range.len() } else { 0 };
                with_constant(&own, &torque, used, (0..p).chain([p + a]).collect())
            };
            (0..self.joints).map(of).collect()
        };
        shares(&folds_in_time(self.torque.nrows(), part)).is_more_than_a_constant()
    }

    /// Weighted torque of row a in sample s.
    fn row_torque(&self, a: usize, order: &[usize], signs: &[f64], s: usize) -> f64 {
        self.weight[a] * signs[a] * self.torque[(s, order[a])]
    }

    /// What every one of `count` stretches of time adds to the solution by its residual: its influence.
    pub fn influences(&self, order: &[usize], signs: &[f64], count: usize) -> Vec<DVector<f64>> {
        let (values, samples) = (self.values(order, signs), self.torque.nrows());
        let residuals: Vec<DVector<f64>> = (0..self.joints)
            .map(|a| DVector::from_fn(samples, |s, _| self.row_torque(a, order, signs, s)) - &self.blocks[a] * &values)
            .collect();
        let of = |b: usize| {
            let (from, to) = (b * samples / count, (b + 1) * samples / count);
            let rows = self.blocks.iter().zip(&residuals);
            let sum = rows.map(|(m, r)| m.rows(from, to - from).tr_mul(&r.rows(from, to - from)));
            &self.inverse * sum.fold(DVector::zeros(values.len()), |a, b| a + b)
        };
        (0..count).map(of).collect()
    }

    /// Sums of what torques along the motion make on every column of the rows: `Wᵀ W'` with W' weighted alike.
    pub fn along(&self, torque: impl Fn(usize, usize) -> f64) -> DVector<f64> {
        let samples = self.torque.nrows();
        let of = |a: usize| self.blocks[a].tr_mul(&DVector::from_fn(samples, |s, _| self.weight[a] * torque(a, s)));
        (0..self.joints)
            .map(of)
            .fold(DVector::zeros(self.inverse.nrows()), |a, b| a + b)
    }

    /// Weighted squares: of what the model makes with `values`, and of torques along the motion.
    pub fn sizes(&self, values: &DVector<f64>, torque: impl Fn(usize, usize) -> f64) -> [f64; 2] {
        let own: f64 = self.blocks.iter().map(|m| (m * values).norm_squared()).sum();
        let other = (0..self.joints).flat_map(|a| (0..self.torque.nrows()).map(move |s| (a, s)));
        [own, other.map(|(a, s)| (self.weight[a] * torque(a, s)).powi(2)).sum()]
    }

    fn places(&self, order: &[usize]) -> Vec<usize> {
        (0..self.joints).map(|a| a * self.joints + order[a]).collect()
    }

    /// Sum of squares left with these columns and signs. Rounding can make that of an exact fit negative, and comparing ratios of
    /// negative numbers would exchange two columns back and forth for ever.
    pub fn rest(&self, order: &[usize], signs: &[f64]) -> f64 {
        let at = self.places(order);
        let left = (0..self.joints).map(|a| {
            (0..self.joints)
                .map(|b| signs[a] * signs[b] * self.products[(at[a], at[b])])
                .sum::<f64>()
        });
        left.sum::<f64>().max(0.0)
    }

    /// The order and signs that leave clearly less than the columns as they are: one exchange after the other, each with its best
    /// signs, until none helps.
    pub fn best(&self) -> (Vec<usize>, Vec<f64>) {
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
                Some(best) if best.0 < score / SETTINGS.data_quality.order_gain => (score, order, signs) = best,
                _ => break,
            }
        }
        if plain > SETTINGS.data_quality.clearly_better * self.rest(&order, &signs) {
            (order, signs)
        } else {
            (identity, vec![1.0; self.joints])
        }
    }

    /// The best signs for an order, and what they leave times `sign_gain` for every joint turned. All joints turned are as good
    /// as none, so that the sign of the last is free.
    fn signed(&self, order: &[usize]) -> (f64, Vec<f64>) {
        let n = self.joints;
        let weigh = |signs: Vec<f64>| {
            let turned = signs.iter().filter(|s| **s < 0.0).count();
            let fewer = if 2 * turned > n {
                signs.iter().map(|s| -s).collect()
            } else {
                signs
            };
            (
                self.rest(order, &fewer) * SETTINGS.data_quality.sign_gain.powi(turned.min(n - turned) as i32),
                fewer,
            )
        };
        let of = |mask: usize| {
            (0..n)
                .map(|j| if mask >> j & 1 == 1 { -1.0 } else { 1.0 })
                .collect::<Vec<f64>>()
        };
        let masks: Vec<usize> = match n {
            _ if n <= SETTINGS.data_quality.exhaustive_joints => (0..1 << (n - 1)).collect(),
            _ => std::iter::once(0).chain((0..n).map(|j| 1 << j)).collect(),
        };
        let all = masks.into_iter().map(|mask| weigh(of(mask)));
        all.min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("no joint turned is one of them")
    }

    /// Parameters on the given columns.
    pub fn values(&self, order: &[usize], signs: &[f64]) -> DVector<f64> {
        let at = self.places(order);
        (0..self.joints)
            .map(|a| self.solutions.column(at[a]) * signs[a])
            .fold(DVector::zeros(self.solutions.nrows()), |a, b| a + b)
    }
}

pub(crate) fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
