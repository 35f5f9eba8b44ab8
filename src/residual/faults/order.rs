//! Torque columns in another order or with other signs, held against what the rigid model leaves with them.

use super::columns::CLEARLY;
use super::sign::{friction_power, physical_sign};
use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks};
use crate::model::Robot;
use crate::parameters::Layout;
use crate::residual::AugmentedModel;
use crate::residual::projection::pseudo_inverse;
use nalgebra::{DMatrix, DVector};

/// Several faults at once: each must leave so many times less than without it.
const PART: f64 = 1.5;

/// A joint with parameters mostly its own leaves hardly less when turned rightly: that must show in the thousand rows or so, and friction has a say
/// afterwards.
const TURN: f64 = 1.1;
/// Arms of up to so many joints have all patterns of signs tried; longer ones one joint at a time.
const MOST_EXHAUSTED: usize = 12;

/// Every torque column in every joint's row, with the base regressor projected out: sums of squares of all hypotheses at once.
pub(super) struct Projection {
    joints: usize,
    /// `⟨P e_row(a) tau(b), P e_row(c) tau(d)⟩` at `(a n + b, c n + d)`.
    products: DMatrix<f64>,
    /// `G⁺ Wᵀ e_row(a) tau(b)` as columns a n + b: what least squares makes of it.
    solutions: DMatrix<f64>,
}

impl Projection {
    /// With a level and a spring of the joint `sprung` beside the rigid body, where there is one.
    pub fn new(robot: &Robot, motion: &Motion, torque: &[Vec<f64>], sprung: Option<usize>) -> Self {
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
    pub fn rest(&self, order: &[usize], signs: &[f64]) -> f64 {
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
    pub fn dissipating(&self, robot: &Robot, motion: &Motion, order: &[usize], signs: &[f64]) -> Vec<f64> {
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
    pub fn global_sign(&self, robot: &Robot, motion: &Motion, order: &[usize], signs: &[f64]) -> Vec<f64> {
        let vote = physical_sign(robot, motion, &self.values(order, signs));
        signs.iter().map(|s| s * vote).collect()
    }
}
