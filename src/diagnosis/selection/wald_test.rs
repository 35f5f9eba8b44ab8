//! Wald test of an effect: are its parameters different from zero, by a covariance that misfit has widened?

use super::score::chance;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::EffectKind;
use crate::regression::{System, Term};
use nalgebra::{DMatrix, DVector};

/// Chance of values as large as those of term `at` where there is no such effect.
pub(crate) fn doubt(system: &System, at: usize) -> f64 {
    let (statistic, parameters) = wald(&system.model.terms[at], &honest_covariance(system, at));
    chance(statistic, parameters)
}

/// `θᵀ C⁻¹ θ` and the length of θ, what `term` adds: its coefficients, or all parameters of a distortion, which is not there when
/// they are zero. `covariance` is that of all parameters of the term.
pub(crate) fn wald(term: &Term, covariance: &DMatrix<f64>) -> (f64, usize) {
    // Coefficients come first; distortions have none.
    let values = match term.effect.kind() {
        EffectKind::Distortion => &term.shape[..term.free_shapes],
        _ => &term.coefficients[..],
    };
    let k = values.len();
    let block = covariance.view((0, 0), (k, k)).into_owned();
    let theta = DVector::from_column_slice(values);
    determined(&theta, &block)
}

/// `θᵀ C⁺ θ` and the number of directions that the covariance says anything of. Where it is not positive definite the data leave
/// a direction open, or rounding is all there is: that confirms nothing.
fn determined(theta: &DVector<f64>, covariance: &DMatrix<f64>) -> (f64, usize) {
    // Parameters have units of their own: the scale is that of their deviations.
    let scale = covariance.diagonal().map(|v| if v > 0.0 { v.sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_fn(theta.len(), theta.len(), |r, c| covariance[(r, c)] * scale[r] * scale[c]);
    if scaled.iter().any(|v| !v.is_finite()) {
        return (0.0, theta.len());
    }
    let eigen = scaled.symmetric_eigen();
    let along = eigen.eigenvectors.tr_mul(&theta.component_mul(&scale));
    let known: Vec<usize> = (0..theta.len())
        .filter(|&i| eigen.eigenvalues[i] > SETTINGS.selection.least_eigenvalue)
        .collect();
    let statistic = known.iter().map(|&i| along[i] * along[i] / eigen.eigenvalues[i]).sum();
    (statistic, known.len().max(1))
}

/// Covariance of the parameters of term `at`. Misfit that is left on its joints widens it as it narrows the evidence.
pub(crate) fn honest_covariance(system: &System, at: usize) -> DMatrix<f64> {
    let term = &system.model.terms[at];
    let joints: Vec<usize> = if term.joints.is_empty() {
        (0..system.model.robot.joint_count()).collect()
    } else {
        term.acts_on()
    };
    if system.has_misfit(&joints) {
        system.jackknife(at)
    } else {
        system.term_covariance(at)
    }
}
