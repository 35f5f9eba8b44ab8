//! Sums of squares that least squares leaves, for any direction of gravity and any signs and order of the torque columns.
//!
//! `Y(g) = Y₀ + Σ gᵢ Yᵢ`, so that normal matrix and right sides are polynomials in g whose coefficients are made once. A level, a
//! spring, a rotor inertia and friction of every joint stand beside the rigid body, lest one of them passes for a direction.

use crate::cancel::CancelFlag;
use crate::diagnosis::settings::SETTINGS;
use crate::dynamics::{Chain, ColumnSet, Coulomb, Motion, RowBlocks};
use crate::model::Robot;
use crate::parameters::{Layout, ParameterKind};
use crate::preparation::{Exclusion, exclusions};
use crate::regression::{AugmentedModel, pseudo_inverse, transposed_product};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Vector3};
use rayon::prelude::*;

/// The quadratic form.
pub(crate) struct Form {
    pub joints: usize,
    pub samples: usize,
    /// Columns of the rigid body; those of the joints come after.
    pub rigid: usize,
    /// Numbers of the rigid body's columns in the standard layout.
    pub kept: Vec<usize>,
    /// `Σ Yₐᵀ Y_b`.
    pub(crate) normal: Vec<Vec<DMatrix<f64>>>,
    /// `Yₐᵀ e_row(j) tau(k)` as columns j n + k.
    pub(crate) right: [DMatrix<f64>; 4],
    /// `tauᵀ tau`, unweighed.
    square: DMatrix<f64>,
    /// Per joint: rows of weightless motion, then of gravity of the declared size along x, y, z; weighed.
    pub(crate) rows: Vec<[DMatrix<f64>; 4]>,
    /// Torques, samples × joints.
    pub(crate) torque: DMatrix<f64>,
    /// Inverse root mean square of every torque: strong joints do not drown weak ones.
    pub weight: Vec<f64>,
    /// Looked at with every direction.
    cancel: CancelFlag,
}

impl Form {
    /// `None` where a torque is missing altogether or nothing was measured.
    pub fn new(robot: &Robot, logs: &[(&Motion, &[Vec<f64>])], cancel: &CancelFlag) -> Option<Self> {
        let (motion, torque) = picked(robot.joint_count(), logs);
        let (n, samples) = (motion.joints(), motion.samples());
        let size = robot.gravity().norm();
        let mean_square = |t: &Vec<f64>| t.iter().map(|v| v * v).sum::<f64>() / samples as f64;
        let still: Vec<bool> = (0..n).map(|j| motion.velocities(j).iter().all(|v| *v == 0.0)).collect();
        let excluded = exclusions(&torque, &vec![true; samples], &still);
        // A torque that takes no part weighs nothing.
        let of = |(t, out): (&Vec<f64>, &Option<Exclusion>)| match out {
            None => mean_square(t).sqrt().recip(),
            Some(_) => 0.0,
        };
        let weight: Vec<f64> = torque.iter().zip(&excluded).map(of).collect();
        if samples == 0 || weight.iter().any(|w| !w.is_finite()) || weight.iter().all(|w| *w == 0.0) {
            return None;
        }
        let model = AugmentedModel::declared(robot);
        let set = ColumnSet::new(robot, &Layout::standard(robot), &model.base.kept);
        let along = |gravity: Vector3<f64>| {
            let mut rows = RowBlocks::new(&set, samples);
            rows.fill(&Chain::new(&robot.with_gravity(gravity)), &set, &motion, Coulomb::Sign);
            rows
        };
        let weightless = along(Vector3::zeros());
        let heavy = [0, 1, 2].map(|i| along(Vector3::ith(i, size)));
        let rigid = set.len();
        let p = rigid + SETTINGS.mounting.own_columns * n;
        let block = |j: usize| -> [DMatrix<f64>; 4] {
            let mut parts: [DMatrix<f64>; 4] = std::array::from_fn(|_| DMatrix::zeros(samples, p));
            let of = |rows: &RowBlocks| -> Vec<(usize, Vec<f64>)> {
                let columns = rows.block(j).chunks_exact(rows.stride()).zip(set.row(j));
                columns.map(|(v, &at)| (at, v[..samples].to_vec())).collect()
            };
            for (at, values) in of(&weightless) {
                parts[0].column_mut(at).copy_from_slice(&values);
            }
            for (i, rows) in heavy.iter().enumerate() {
                for (at, values) in of(rows) {
                    parts[i + 1].column_mut(at).copy_from_slice(&values);
                }
                let bare = parts[0].clone();
                let mut gravity = parts[i + 1].columns_mut(0, rigid);
                gravity -= bare.columns(0, rigid);
            }
            for s in 0..samples {
                let [q, v, a] = motion.get(j, s);
                let own = [1.0, q, a, v, Coulomb::Sign.value(v)];
                own.iter()
                    .enumerate()
                    .for_each(|(k, x)| parts[0][(s, rigid + SETTINGS.mounting.own_columns * j + k)] = *x);
            }
            parts.map(|m| m * weight[j])
        };
        let rows: Vec<[DMatrix<f64>; 4]> = (0..n).into_par_iter().map(block).collect();
        let sum = |a: usize, b: usize| {
            let product = |r: &[DMatrix<f64>; 4]| transposed_product(&r[a], &r[b]);
            rows.iter().map(product).fold(DMatrix::zeros(p, p), |m, own| m + own)
        };
        let normal = (0..4).into_par_iter().map(|a| (0..4).map(|b| sum(a, b)).collect()).collect();
        let tau = DMatrix::from_fn(samples, n, |s, j| torque[j][s]);
        let right = std::array::from_fn(|a| {
            let mut cross = DMatrix::zeros(p, n * n);
            for (j, r) in rows.iter().enumerate() {
                cross.columns_mut(j * n, n).copy_from(&(r[a].tr_mul(&tau) * weight[j]));
            }
            cross
        });
        Some(Self {
            joints: n,
            samples,
            rigid,
            kept: model.base.kept,
            normal,
            right,
            square: tau.tr_mul(&tau),
            rows,
            torque: tau,
            weight,
            cancel: cancel.clone(),
        })
    }

    /// The normal matrix scaled to a unit diagonal, factorised, and the scales.
    fn factorised(&self, direction: Vector3<f64>) -> (Cholesky<f64, Dyn>, DVector<f64>) {
        self.cancel.leave_if_set();
        factorised(&self.normal_along(direction))
    }

    /// Normal matrix under this direction.
    pub(crate) fn normal_along(&self, direction: Vector3<f64>) -> DMatrix<f64> {
        let c = powers(direction);
        let p = self.normal[0][0].nrows();
        let mut g = DMatrix::zeros(p, p);
        for a in 0..4 {
            for b in 0..4 {
                if c[a] * c[b] != 0.0 {
                    g += &self.normal[a][b] * (c[a] * c[b]);
                }
            }
        }
        g
    }

    /// Least squares for this direction: what it makes of every torque column in every joint's row, p × n².
    fn solved(&self, direction: Vector3<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
        let (factor, scale) = self.factorised(direction);
        let mut x = right.clone();
        (0..x.nrows()).for_each(|r| x.row_mut(r).scale_mut(scale[r]));
        factor.solve_mut(&mut x);
        (0..x.nrows()).for_each(|r| x.row_mut(r).scale_mut(scale[r]));
        x
    }

    pub(crate) fn right_side(&self, direction: Vector3<f64>) -> DMatrix<f64> {
        let c = powers(direction);
        (1..4).fold(self.right[0].clone(), |m, a| m + &self.right[a] * c[a])
    }

    /// Sums of squares of all hypotheses about the columns under one direction, n² × n².
    fn products(&self, direction: Vector3<f64>) -> DMatrix<f64> {
        let n = self.joints;
        let right = self.right_side(direction);
        let mut products = -right.tr_mul(&self.solved(direction, &right));
        for j in 0..n {
            let mut corner = products.view_mut((j * n, j * n), (n, n));
            corner += &self.square * (self.weight[j] * self.weight[j]);
        }
        products
    }

    /// Parameters with these signs of the columns.
    pub fn values(&self, direction: Vector3<f64>, signs: &[f64]) -> DVector<f64> {
        let right = self.right_side(direction);
        let n = self.joints;
        let sum = (0..n).fold(DVector::zeros(right.nrows()), |v, j| v + right.column(j * n + j) * signs[j]);
        self.solved(direction, &DMatrix::from_columns(&[sum])).column(0).into_owned()
    }

    /// Inertia, viscous and Coulomb friction of a joint by itself, its declared friction included.
    pub fn own(&self, values: &DVector<f64>, layout: &Layout, joint: usize) -> [f64; 3] {
        let at = self.rigid + SETTINGS.mounting.own_columns * joint;
        let mut own = [values[at + 2], values[at + 3], values[at + 4]];
        for (&at, &value) in self.kept.iter().zip(values.iter()) {
            let parameter = layout.parameters()[at];
            match parameter.kind {
                ParameterKind::Viscous if parameter.link == joint => own[1] += value,
                ParameterKind::Coulomb if parameter.link == joint => own[2] += value,
                _ => {}
            }
        }
        own
    }

    /// Sum of squares left with these signs.
    pub fn rest(&self, direction: Vector3<f64>, signs: &[f64]) -> f64 {
        let right = self.right_side(direction);
        let n = self.joints;
        let sum = (0..n).fold(DVector::zeros(right.nrows()), |v, j| v + right.column(j * n + j) * signs[j]);
        let x = self.solved(direction, &DMatrix::from_columns(std::slice::from_ref(&sum)));
        (self.total() - sum.dot(&x.column(0))).max(SETTINGS.mounting.no_column * self.total())
    }

    pub(crate) fn total(&self) -> f64 {
        (0..self.joints).map(|j| self.square[(j, j)] * self.weight[j].powi(2)).sum()
    }

    /// What every joint's own columns leave, without a body.
    pub fn without_body(&self) -> f64 {
        let n = self.joints;
        let one = |j: usize| {
            let at = self.rigid + SETTINGS.mounting.own_columns * j;
            let g = self.normal[0][0]
                .view((at, at), (SETTINGS.mounting.own_columns, SETTINGS.mounting.own_columns))
                .into_owned();
            let b = self.right[0]
                .view((at, j * n + j), (SETTINGS.mounting.own_columns, 1))
                .into_owned();
            let x = pseudo_inverse(&g, SETTINGS.mounting.ridge) * &b;
            self.square[(j, j)] * self.weight[j].powi(2) - b.dot(&x)
        };
        (0..n).map(one).sum()
    }

    /// The best signs for the columns as ordered, and what they leave.
    pub fn signed(&self, direction: Vector3<f64>) -> (f64, Vec<f64>) {
        let order: Vec<usize> = (0..self.joints).collect();
        self.best_signs(&self.products(direction), &order)
    }

    /// All joints turned are as good as none: fewer than half are.
    fn best_signs(&self, products: &DMatrix<f64>, order: &[usize]) -> (f64, Vec<f64>) {
        let n = self.joints;
        let at: Vec<usize> = (0..n).map(|j| j * n + order[j]).collect();
        let of = |mask: usize| {
            (0..n)
                .map(|j| if mask >> j & 1 == 1 { -1.0 } else { 1.0 })
                .collect::<Vec<f64>>()
        };
        let masks: Vec<usize> = match n {
            _ if n <= SETTINGS.data_quality.exhaustive_joints => (0..1 << n).collect(),
            _ => std::iter::once(0).chain((0..n).map(|j| 1 << j)).collect(),
        };
        let weighed = masks.into_iter().filter(|m| 2 * m.count_ones() as usize <= n).map(|mask| {
            let signs = of(mask);
            let pair = |j: usize, k: usize| signs[j] * signs[k] * products[(at[j], at[k])];
            let rest: f64 = (0..n).map(|j| (0..n).map(|k| pair(j, k)).sum::<f64>()).sum();
            let rest = rest.max(SETTINGS.mounting.no_column * self.total());
            (
                rest,
                rest * SETTINGS.data_quality.sign_gain.powi(mask.count_ones() as i32),
                signs,
            )
        });
        let best = weighed
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .expect("no joint turned is one of them");
        (best.0, best.2)
    }

    /// The least that any signs and any order of the columns leave: one exchange after the other while they help.
    pub fn best_columns(&self, direction: Vector3<f64>) -> f64 {
        let products = self.products(direction);
        let n = self.joints;
        let mut order: Vec<usize> = (0..n).collect();
        let mut least = self.best_signs(&products, &order).0;
        loop {
            let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
            let tried = pairs.map(|(a, b)| {
                let mut swapped = order.clone();
                swapped.swap(a, b);
                (self.best_signs(&products, &swapped).0, swapped)
            });
            match tried.min_by(|a, b| a.0.total_cmp(&b.0)) {
                // As for the order under a known gravity: an exchange leaves clearly less, or there is none.
                Some((rest, swapped)) if rest < least / SETTINGS.mounting.exchange_gain => (least, order) = (rest, swapped),
                _ => return least,
            }
        }
    }
}

/// A normal matrix scaled to a unit diagonal with a ridge, factorised, and the scales.
pub(crate) fn factorised(g: &DMatrix<f64>) -> (Cholesky<f64, Dyn>, DVector<f64>) {
    let p = g.nrows();
    let scale = g.diagonal().map(|v| if v > 0.0 { v.sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_fn(p, p, |r, k| {
        let ridge = if r == k {
            SETTINGS.mounting.ridge + if scale[r] == 0.0 { 1.0 } else { 0.0 }
        } else {
            0.0
        };
        0.5 * (g[(r, k)] + g[(k, r)]) * scale[r] * scale[k] + ridge
    });
    let factor = scaled.clone().cholesky();
    // Rounding can make the matrix indefinite by a part in 1e9 at most: a thousand ridges are enough.
    let factor = factor.unwrap_or_else(|| {
        let lifted = scaled + DMatrix::identity(p, p) * (1e3 * SETTINGS.mounting.ridge);
        lifted.cholesky().expect("a Gram matrix with a ridge is positive definite")
    });
    (factor, scale)
}

pub(crate) fn powers(direction: Vector3<f64>) -> [f64; 4] {
    [1.0, direction.x, direction.y, direction.z]
}

/// Samples of all logs, spread evenly over their motions.
fn picked(joints: usize, logs: &[(&Motion, &[Vec<f64>])]) -> (Motion, Vec<Vec<f64>>) {
    let all: usize = logs.iter().map(|(m, _)| m.samples()).sum();
    let step = (all / SETTINGS.mounting.samples).max(1);
    let at: Vec<(usize, usize)> = logs
        .iter()
        .enumerate()
        .flat_map(|(i, (m, _))| (0..m.samples()).step_by(step).map(move |s| (i, s)))
        .collect();
    let motion = Motion::from_fn(joints, at.len(), |j, k| logs[at[k].0].0.get(j, at[k].1));
    let torque = (0..joints)
        .map(|j| at.iter().map(|&(i, s)| logs[i].1[j][s]).collect())
        .collect();
    (motion, torque)
}
