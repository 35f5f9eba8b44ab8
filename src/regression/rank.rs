//! Which directions of the parameters the data determine: pseudo-inverses and their ranks.

use crate::regression::settings::SETTINGS;
use nalgebra::{DMatrix, DVector};

/// Combinations D of columns that the model does not hide, of unit information each: `Dᵀ rest D = 1`.
pub(crate) fn directions(own: &DMatrix<f64>, rest: &DMatrix<f64>) -> DMatrix<f64> {
    directions_above(own, rest, SETTINGS.hidden_share)
}

/// The same of those combinations of which `rest` is more than the share `least` of `own`.
pub(crate) fn directions_above(own: &DMatrix<f64>, rest: &DMatrix<f64>, least: f64) -> DMatrix<f64> {
    let k = own.nrows();
    let scale = DVector::from_fn(k, |i, _| if own[(i, i)] > 0.0 { own[(i, i)].sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_fn(k, k, |r, c| 0.5 * (rest[(r, c)] + rest[(c, r)]) * scale[r] * scale[c]);
    let eigen = scaled.symmetric_eigen();
    let seen: Vec<usize> = (0..k).filter(|&i| eigen.eigenvalues[i] > least).collect();
    DMatrix::from_fn(k, seen.len(), |r, c| {
        scale[r] * eigen.eigenvectors[(r, seen[c])] / eigen.eigenvalues[seen[c]].sqrt()
    })
}

/// Pseudo-inverse of a positive semidefinite matrix, scaled to a unit diagonal first; eigenvalues below `relative` of the largest
/// count as zero.
pub(crate) fn pseudo_inverse(normal: &DMatrix<f64>, relative: f64) -> DMatrix<f64> {
    let half = pseudo_root(normal, relative);
    &half * half.transpose()
}

/// H with `H Hᵀ` the pseudo-inverse of [`pseudo_inverse`], and `Hᵀ G H = 1`.
pub(crate) fn pseudo_root(normal: &DMatrix<f64>, relative: f64) -> DMatrix<f64> {
    let p = normal.nrows();
    // A column that is zero but for rounding (gravity along an axis that is not quite a coordinate axis) is 1e-16 of the others.
    let least = 1e-24 * normal.diagonal().amax();
    let scale = DVector::from_fn(p, |i, _| {
        if normal[(i, i)] > least {
            normal[(i, i)].sqrt().recip()
        } else {
            0.0
        }
    });
    let scaled = DMatrix::from_fn(p, p, |r, c| normal[(r, c)] * scale[r] * scale[c]);
    let eigen = scaled.symmetric_eigen();
    let least = relative * eigen.eigenvalues.amax();
    let kept: Vec<usize> = (0..p).filter(|&i| eigen.eigenvalues[i] > least).collect();
    let mut half = eigen.eigenvectors.select_columns(&kept);
    for (c, &i) in kept.iter().enumerate() {
        half.column_mut(c).scale_mut(eigen.eigenvalues[i].sqrt().recip());
    }
    (0..p).for_each(|r| half.row_mut(r).scale_mut(scale[r]));
    half
}
