//! Does an effect predict data it was not fitted to? Blocks of time, and periods.
//!
//! What is missing repeats in every period, so a wrong effect that mimics it repeats as well: only parts of the motion that the
//! fit has not seen can tell that. And noise that is not as assumed shows between periods.

use crate::diagnosis::settings::SETTINGS;
use crate::regression::{
    Data, SETTINGS as REGRESSION_SETTINGS, System, Whitened, pseudo_root, reduce, transposed_product, width,
};
use nalgebra::{DMatrix, DVector, DVectorView};
use std::ops::AddAssign;

/// Gain of a block of columns on data left out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HeldOutGain {
    /// Over blocks of time, all folds together.
    pub blocks: f64,
    /// Fitted to one half of the periods, evaluated on the other, both ways; `None` with fewer than two.
    pub periods: Option<f64>,
}

pub(crate) fn held_out_gain(data: &Data, system: &System, columns: &Whitened) -> HeldOutGain {
    HeldOutGain {
        blocks: block_gain(data, system, columns),
        periods: period_gain(data, system, columns),
    }
}

fn block_gain(data: &Data, system: &System, columns: &Whitened) -> f64 {
    let p = system.covariance.nrows();
    let mut folds = Folds::new(system, columns);
    let zero = DVector::zeros(folds.total.nrows());
    let mut all = folds.right.iter().fold(zero, |a, b| a + b);
    if let Some(prior) = data.prior {
        let n = prior.mean.len();
        let off = &prior.mean - system.model.vector().rows(0, n);
        folds.total.view_mut((0, 0), (n, n)).add_assign(&prior.information);
        all.rows_mut(0, n).add_assign(&(&prior.information * off));
    }
    let cost = |size: usize| {
        let bases = folds.bases(size);
        bases
            .iter()
            .zip(&folds.right)
            .map(|(base, own)| base.cost(&all, own))
            .sum::<f64>()
    };
    cost(p) - cost(folds.total.nrows())
}

/// What `[J C]` has on the folds of time.
pub(crate) struct Folds {
    /// Normal matrices.
    pub normal: Vec<DMatrix<f64>>,
    /// Of all folds, and of what is known beforehand.
    total: DMatrix<f64>,
    /// `[J C]ᵀ` times the residual.
    right: Vec<DVector<f64>>,
}

impl Folds {
    pub fn new(system: &System, columns: &Whitened) -> Self {
        let size = system.covariance.nrows() + width(columns);
        let count = SETTINGS.selection.folds;
        let (mut normal, mut right) = (vec![DMatrix::zeros(size, size); count], vec![DVector::zeros(size); count]);
        each_block(system, columns, |fold, rows, residual| {
            normal[fold] += transposed_product(rows, rows);
            right[fold] += rows.tr_mul(&residual);
        });
        let total = normal.iter().fold(DMatrix::zeros(size, size), |a, b| a + b);
        Self { normal, total, right }
    }

    /// Of the first `size` parameters.
    pub fn bases(&self, size: usize) -> Vec<FoldBasis> {
        let part = |m: &DMatrix<f64>| m.view((0, 0), (size, size)).into_owned();
        let root = pseudo_root(&part(&self.total), REGRESSION_SETTINGS.rank_tolerance);
        self.normal.iter().map(|fold| FoldBasis::new(&root, &part(fold))).collect()
    }
}

/// Directions B of the parameters along which a fold and the rest have independent information: `BᵀGB` of all data is the unit
/// matrix, that of the fold diagonal.
pub(crate) struct FoldBasis {
    pub directions: DMatrix<f64>,
    /// Share of the information that is in the fold.
    pub shares: Vec<f64>,
}

impl FoldBasis {
    fn new(root: &DMatrix<f64>, fold: &DMatrix<f64>) -> Self {
        // Rows that say nothing of any parameter.
        if root.ncols() == 0 {
            return Self {
                directions: root.clone(),
                shares: Vec::new(),
            };
        }
        let inside = (root.transpose() * fold * root).symmetric_eigen();
        Self {
            directions: root * inside.eigenvectors,
            shares: inside.eigenvalues.iter().copied().collect(),
        }
    }

    /// Variance of a parameter along each direction by the rest of the data, of unit noise; nothing where the rest says too
    /// little for it to be extrapolated.
    pub fn outside(&self) -> impl Iterator<Item = (f64, f64)> {
        let of = |&share: &f64| {
            let outside = 1.0 - share;
            let known = outside > SETTINGS.selection.least_outside;
            (share, if known { outside.recip() } else { 0.0 })
        };
        self.shares.iter().map(of)
    }

    /// Change of the sum of squares on the fold from the parameters of the model at hand to those fitted without the fold:
    /// `x'Gx − 2x'b`, by the sums of all data and of the fold.
    fn cost(&self, all: &DVector<f64>, own: &DVector<f64>) -> f64 {
        let along = |r: &DVector<f64>| self.directions.tr_mul(&r.rows(0, self.directions.nrows()));
        let (all, own) = (along(all), along(own));
        let each = |(i, (share, variance)): (usize, (f64, f64))| {
            let x = (all[i] - own[i]) * variance;
            x * x * share - 2.0 * x * own[i]
        };
        self.outside().enumerate().map(each).sum()
    }
}

/// Rows of `[J C]` and their residuals, block by block, with the fold that they are in.
fn each_block(system: &System, columns: &Whitened, mut take: impl FnMut(usize, &DMatrix<f64>, DVectorView<f64>)) {
    let (p, k) = (system.covariance.nrows(), width(columns));
    for (blocks, parts) in system.blocks.iter().zip(columns) {
        for (joint, block) in blocks.iter().enumerate() {
            let own = parts.iter().find(|(j, _)| *j == joint).map(|(_, m)| m);
            for (fold, from, count) in fold_blocks(block.residual.len()) {
                let mut rows = DMatrix::zeros(count, p + k);
                rows.columns_mut(0, p).copy_from(&block.jacobian.rows(from, count));
                if let Some(m) = own {
                    rows.columns_mut(p, k).copy_from(&m.rows(from, count));
                }
                take(fold, &rows, block.residual.rows(from, count));
            }
        }
    }
}

/// Blocks of so many rows: the fold, the first row and how many.
pub(crate) fn fold_blocks(rows: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    let place = move |b: usize| b * rows / SETTINGS.selection.fold_blocks;
    (0..SETTINGS.selection.fold_blocks).map(move |b| (b % SETTINGS.selection.folds, place(b), place(b + 1) - place(b)))
}

fn period_gain(data: &Data, system: &System, columns: &Whitened) -> Option<f64> {
    if data.stretches.iter().any(|s| s.periods.len() < 2) {
        return None;
    }
    let (own, rest, right) = system.projected(columns);
    let halves = [0, 1].map(|half| half_right_side(data, system, columns, half) + &right);
    let gain = |fit: &DVector<f64>, test: &DVector<f64>| {
        let x = reduce(&own, &rest, fit).coefficients;
        2.0 * x.dot(test) - (x.transpose() * &rest * &x)[0]
    };
    Some(0.5 * (gain(&halves[0], &halves[1]) + gain(&halves[1], &halves[0])))
}

/// `C_⊥ᵀ` times what the average of every second period deviates from the average of all.
fn half_right_side(data: &Data, system: &System, columns: &Whitened, half: usize) -> DVector<f64> {
    let p = system.covariance.nrows();
    let k = width(columns);
    let (mut direct, mut through, mut cross) = (DVector::zeros(k), DVector::zeros(p), DMatrix::zeros(p, k));
    for ((stretch, blocks), parts) in data.stretches.iter().zip(&system.blocks).zip(columns) {
        let which: Vec<usize> = (half..stretch.periods.len()).step_by(2).collect();
        let mean = stretch.mean_over(&which);
        for (j, block) in blocks.iter().enumerate() {
            let off: Vec<f64> = mean[j].iter().zip(&stretch.torque[j]).map(|(a, b)| a - b).collect();
            let white = DVector::from_vec(data.noise[j].whiten(&off, &block.rows, stretch.repetitions()));
            through += block.jacobian.tr_mul(&white);
            if let Some((_, m)) = parts.iter().find(|(joint, _)| *joint == j) {
                direct += m.tr_mul(&white);
                cross += transposed_product(&block.jacobian, m);
            }
        }
    }
    direct - cross.tr_mul(&(&system.covariance * through))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parameter that one block alone determines, but for a breath: extrapolated into the block it would be off by thousands,
    /// in both models, and their difference would drown what the effect explains.
    #[test]
    fn prop_a_parameter_of_one_block_does_not_judge_an_effect() {
        let wave = |s: usize, f: f64| (f * s as f64).sin();
        let row = |s: usize| {
            let base = if s < 20 { wave(s, 0.9) } else { 1e-5 * wave(s, 0.7) };
            (
                DVector::from_vec(vec![base, wave(s, 0.37)]),
                2.0 * wave(s, 0.37) + 0.3 * wave(s, 2.9),
            )
        };
        let sum = |rows: std::ops::Range<usize>| {
            rows.map(row)
                .fold((DMatrix::zeros(2, 2), DVector::zeros(2)), |(g, b), (z, r)| {
                    (g + &z * z.transpose(), b + z * r)
                })
        };
        let (total, fold) = (sum(0..100), sum(0..20));
        let folds = Folds {
            normal: vec![fold.0],
            total: total.0,
            right: vec![fold.1.clone()],
        };
        let cost = |size: usize| folds.bases(size)[0].cost(&total.1, &folds.right[0]);
        // The effect has amplitude 2 in twenty rows of mean square 1/2.
        let explained = 2.0 * 2.0 * 0.5 * 20.0;
        let gain = cost(1) - cost(2);
        assert!(gain > 0.5 * explained && gain < 1.5 * explained, "{gain} of {explained}");
    }
}
