//! Does an effect predict data it was not fitted to? Blocks of time, and periods.
//!
//! What is missing repeats in every period, so a wrong effect that mimics it repeats as well: only parts of the motion that the
//! fit has not seen can tell that. And noise that is not as assumed shows between periods.

use crate::diagnosis::settings::SETTINGS;
use crate::regression::{Data, SETTINGS as REGRESSION_SETTINGS, System, Whitened, pseudo_root, reduce, transposed_product};
use nalgebra::{DMatrix, DVector};
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
    let k = columns.iter().flatten().map(|(_, m)| m.ncols()).next().unwrap_or(0);
    // Per fold: normal matrix and right side of [J C].
    let mut folds: Vec<(DMatrix<f64>, DVector<f64>)> = (0..SETTINGS.selection.folds)
        .map(|_| (DMatrix::zeros(p + k, p + k), DVector::zeros(p + k)))
        .collect();
    for (blocks, parts) in system.blocks.iter().zip(columns) {
        for (j, block) in blocks.iter().enumerate() {
            let own = parts.iter().find(|(joint, _)| *joint == j).map(|(_, m)| m);
            let rows = block.residual.len();
            for b in 0..SETTINGS.selection.fold_blocks {
                let (from, to) = (
                    b * rows / SETTINGS.selection.fold_blocks,
                    (b + 1) * rows / SETTINGS.selection.fold_blocks,
                );
                let mut z = DMatrix::zeros(to - from, p + k);
                z.columns_mut(0, p).copy_from(&block.jacobian.rows(from, to - from));
                if let Some(m) = own {
                    z.columns_mut(p, k).copy_from(&m.rows(from, to - from));
                }
                let fold = &mut folds[b % SETTINGS.selection.folds];
                fold.0 += transposed_product(&z, &z);
                fold.1 += z.tr_mul(&block.residual.rows(from, to - from));
            }
        }
    }
    let mut total = (DMatrix::zeros(p + k, p + k), DVector::zeros(p + k));
    folds.iter().for_each(|(g, r)| {
        total.0 += g;
        total.1 += r;
    });
    if let Some(prior) = data.prior {
        let n = prior.mean.len();
        let off = &prior.mean - system.model.vector().rows(0, n);
        total.0.view_mut((0, 0), (n, n)).add_assign(&prior.information);
        total.1.rows_mut(0, n).add_assign(&(&prior.information * off));
    }
    let cost = |size: usize| {
        let root = pseudo_root(
            &total.0.view((0, 0), (size, size)).into_owned(),
            REGRESSION_SETTINGS.rank_tolerance,
        );
        folds.iter().map(|fold| fold_cost(&root, &total.1, fold)).sum::<f64>()
    };
    cost(p) - cost(p + k)
}

/// Change of the sum of squares on a fold from the parameters of the model at hand to those fitted without the fold:
/// `x'Gx − 2x'b`. In the coordinates of `root`, in which all data together have the unit matrix for their information.
fn fold_cost(root: &DMatrix<f64>, right: &DVector<f64>, fold: &(DMatrix<f64>, DVector<f64>)) -> f64 {
    let size = root.nrows();
    // Rows that say nothing of any parameter.
    if root.ncols() == 0 {
        return 0.0;
    }
    let inside = (root.transpose() * fold.0.view((0, 0), (size, size)) * root).symmetric_eigen();
    let along = |r: &DVector<f64>| inside.eigenvectors.tr_mul(&root.tr_mul(&r.rows(0, size)));
    let (all, own) = (along(right), along(&fold.1));
    let each = |(i, &share): (usize, &f64)| {
        let outside = 1.0 - share;
        let x = if outside > SETTINGS.selection.least_outside {
            (all[i] - own[i]) / outside
        } else {
            0.0
        };
        x * x * share - 2.0 * x * own[i]
    };
    inside.eigenvalues.iter().enumerate().map(each).sum()
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
    let k = columns.iter().flatten().map(|(_, m)| m.ncols()).next().unwrap_or(0);
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
        let cost = |size: usize| {
            let root = pseudo_root(
                &total.0.view((0, 0), (size, size)).into_owned(),
                REGRESSION_SETTINGS.rank_tolerance,
            );
            fold_cost(&root, &total.1, &fold)
        };
        // The effect has amplitude 2 in twenty rows of mean square 1/2.
        let explained = 2.0 * 2.0 * 0.5 * 20.0;
        let gain = cost(1) - cost(2);
        assert!(gain > 0.5 * explained && gain < 1.5 * explained, "{gain} of {explained}");
    }
}
