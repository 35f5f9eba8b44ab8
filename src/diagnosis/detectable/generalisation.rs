//! Whether data that a fit has not seen would show an effect as well.
//!
//! The search asks that the gain D on folds of time left out exceeds a share g of the gain G of the fit. Both are quadratic forms
//! of the sums `[J C]ᵀ y` over the folds. For `y` an effect of size s in noise of unit variance, with a hat what the effect makes
//! of them at size one, c what the noise does, and `v_f` the gradient of `D − g G` by the sums of fold f, of normal matrix `G_f`,
//!
//! ```text
//! E(D − g G) = s² (D̂ − g Ĝ) + c,    var(D − g G) ≈ s² Σ_f v_fᵀ G_f v_f.
//! ```
//!
//! Of an effect that one fold alone shows, as of a joint that turns round once, D̂ is below g Ĝ: the search takes it at no size.
//!
//! Columns C beside J add a few rows to every normal matrix, so that the covariance with them is that of J, known once for every
//! fold, and `V S⁻¹ Vᵀ`: with `X = JᵀC`, `V = [W X; −1]` and `S = CᵀC − Xᵀ W X`, W the covariance of J alone.

use super::planned::Planned;
use super::signals::Signal;
use crate::diagnosis::selection::{Candidate, columns_of, fold_blocks};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{SETTINGS as REGRESSION, Whitened, directions_above, width};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

/// The size from which on a candidate of this shape generalises to folds left out with the power asked for; infinite where none
/// does.
pub(super) fn generalises_from(planned: &Planned, candidate: &Candidate, shape: &[f64], signal: &Signal) -> f64 {
    let columns = columns_of(planned.data, &planned.system, candidate, &[shape.to_vec()]);
    let folds = folds(planned, &columns, signal);
    let all = Fold {
        normal: folds.iter().map(|f| &f.normal).fold(folds[0].normal.scale(0.0), |a, b| a + b),
        sums: folds.iter().map(|f| &f.sums).fold(folds[0].sums.scale(0.0), |a, b| a + b),
    };
    let fit = Added::new(&all.normal, &planned.system.covariance, None, REGRESSION.hidden_share);
    let mut excess = Form {
        signal: 0.0,
        noise: 0.0,
        gradient: vec![all.sums.scale(0.0); folds.len()],
    };
    for (f, [_, others]) in planned.folds.iter().enumerate() {
        let rest = &all.normal - &folds[f].normal;
        let added = Added::new(&rest, others, Some(&fit.left), SETTINGS.selection.least_outside);
        excess.add_prediction(&added, others, f, &folds[f], &all.sums);
    }
    excess.add_fit(-SETTINGS.selection.least_generalisation, &fit, &all.sums);
    excess.positive_from(&folds)
}

/// What a fold of the rows says of the declared parameters and the columns.
struct Fold {
    normal: DMatrix<f64>,
    /// `[J C]ᵀ` times the effect.
    sums: DVector<f64>,
}

fn folds(planned: &Planned, columns: &Whitened, signal: &Signal) -> Vec<Fold> {
    let (p, k) = (planned.system.covariance.nrows(), width(columns));
    let of_base = |[own, _]: &[DMatrix<f64>; 2]| Fold {
        normal: own.clone().resize(p + k, p + k, 0.0),
        sums: DVector::zeros(p + k),
    };
    let mut folds: Vec<Fold> = planned.folds.iter().map(of_base).collect();
    for ((blocks, parts), rows) in planned.system.blocks.iter().zip(columns).zip(&signal.rows) {
        for (joint, block) in blocks.iter().enumerate() {
            let own = parts.iter().find(|part| part.0 == joint).map(|part| &part.1);
            let effect = rows.iter().find(|part| part.0 == joint).map(|part| &part.1);
            for (f, from, count) in fold_blocks(block.residual.len()) {
                let (fold, jacobian) = (&mut folds[f], block.jacobian.rows(from, count));
                if let Some(m) = own.map(|m| m.rows(from, count)) {
                    let cross = jacobian.tr_mul(&m);
                    fold.normal.view_mut((0, p), (p, k)).zip_apply(&cross, |a, b| *a += b);
                    fold.normal
                        .view_mut((p, 0), (k, p))
                        .zip_apply(&cross.transpose(), |a, b| *a += b);
                    fold.normal.view_mut((p, p), (k, k)).zip_apply(&m.tr_mul(&m), |a, b| *a += b);
                }
                let Some(effect) = effect.map(|e| e.rows(from, count)) else {
                    continue;
                };
                fold.sums.rows_mut(0, p).zip_apply(&jacobian.tr_mul(&effect), |a, b| *a += b);
                if let Some(m) = own.map(|m| m.rows(from, count)) {
                    fold.sums.rows_mut(p, k).zip_apply(&m.tr_mul(&effect), |a, b| *a += b);
                }
            }
        }
    }
    folds
}

/// What columns add to a covariance: directions of unit variance beside those of the declared parameters.
struct Added {
    /// `V` times a root of `S⁻¹`.
    directions: DMatrix<f64>,
    /// `S`.
    left: DMatrix<f64>,
}

impl Added {
    /// With the covariance of the declared parameters by the same data. Directions of which less than the share `least` is
    /// left, of their own columns or of `of`, are not determined.
    fn new(normal: &DMatrix<f64>, covariance: &DMatrix<f64>, of: Option<&DMatrix<f64>>, least: f64) -> Self {
        let p = covariance.nrows();
        let k = normal.nrows() - p;
        let (cross, own) = (normal.view((0, p), (p, k)), normal.view((p, p), (k, k)).into_owned());
        let hidden = covariance * cross;
        let left = &own - cross.tr_mul(&hidden);
        let root = directions_above(of.unwrap_or(&own), &left, least);
        let mut directions = DMatrix::zeros(p + k, root.ncols());
        directions.rows_mut(0, p).copy_from(&(-hidden * &root));
        directions.rows_mut(p, k).copy_from(&root);
        Self { directions, left }
    }

    fn times(&self, vector: &DVector<f64>) -> DVector<f64> {
        &self.directions * self.directions.tr_mul(vector)
    }
}

/// A quadratic form of the sums of the folds.
struct Form {
    /// For an effect of size one.
    signal: f64,
    /// Its mean for noise alone.
    noise: f64,
    /// By the sums of each fold, at size one.
    gradient: Vec<DVector<f64>>,
}

impl Form {
    /// What the columns gain on a fold: with x the parameters by the sums u of the others, and r those of the fold, the loss is
    /// `xᵀ G x − 2 xᵀ r`; with the columns x goes on by δ.
    fn add_prediction(&mut self, added: &Added, others: &DMatrix<f64>, fold: usize, own: &Fold, all: &DVector<f64>) {
        let p = others.nrows();
        let by_others = |v: &DVector<f64>| (others * v.rows(0, p)).resize_vertically(v.len(), 0.0);
        let (normal, r) = (&own.normal, &own.sums);
        let u = all - r;
        let (x, delta) = (by_others(&u), added.times(&u));
        let bent = normal * &delta;
        self.signal -= bent.dot(&(2.0 * &x + &delta)) - 2.0 * delta.dot(r);
        self.noise -= added.directions.dot(&(normal * &added.directions));
        let by_u = -2.0 * (by_others(&bent) + added.times(&(normal * &x + &bent - r)));
        for (f, gradient) in self.gradient.iter_mut().enumerate() {
            *gradient += if f == fold { 2.0 * &delta } else { by_u.clone() };
        }
    }

    /// What a fit to all data gains: the square of the sums along directions of unit information.
    fn add_fit(&mut self, factor: f64, fit: &Added, all: &DVector<f64>) {
        self.signal += factor * fit.directions.tr_mul(all).norm_squared();
        self.noise += factor * fit.directions.ncols() as f64;
        let by_sums = 2.0 * factor * fit.times(all);
        self.gradient.iter_mut().for_each(|gradient| *gradient += &by_sums);
    }

    /// The size from which on it is positive with the power asked for.
    fn positive_from(&self, folds: &[Fold]) -> f64 {
        if self.signal <= 0.0 {
            return f64::INFINITY;
        }
        let square = |(v, fold): (&DVector<f64>, &Fold)| v.dot(&(&fold.normal * v));
        let variance: f64 = self.gradient.iter().zip(folds).map(square).sum();
        let z = Normal::standard().inverse_cdf(SETTINGS.detectable.power);
        let (linear, discriminant) = (z * variance.sqrt(), z * z * variance - 4.0 * self.signal * self.noise);
        if discriminant < 0.0 {
            return 0.0;
        }
        ((linear + discriminant.sqrt()) / (2.0 * self.signal)).max(0.0)
    }
}
