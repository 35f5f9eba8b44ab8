//! The search for effects, and the last word on each of them, by all samples.
//!
//! Effects are looked for on the coarse forms of the data, one sample of the motion to every row. Of long logs that is a tenth of the samples and less, while
//! so many rows see what a hundredth of the noise hides: what only the coarse form needs is not an effect of the robot.

use super::appraise::chance;
use super::candidate::Candidate;
use super::remainder::{self, unaccounted};
use super::rivals::{Contest, rivals, settled};
use super::select::{Accepted, Selected, Threshold, extend, select};
use super::system::{Data, System};
use super::{AugmentedModel, Remainder, Term};
use crate::effects::Kind;
use nalgebra::{DMatrix, DVector};

/// What a search ends with.
pub(super) struct Searched<'a> {
    /// All samples, with the noise that the search ended with.
    pub data: Data<'a>,
    /// Fitted to them.
    pub system: System,
    /// Terms before the effects: those that the search began with, then nuisance offsets.
    pub fixed: usize,
    pub accepted: Vec<Accepted>,
    /// One per effect of `accepted`.
    pub contests: Vec<Contest>,
    pub remainder: Option<Remainder>,
}

/// Selects on the coarse forms, confirms by all samples, and goes on without the effects that were not confirmed, because they may have stood where another
/// belongs: every turn has fewer candidates.
pub(super) fn searched<'a>(
    coarse: &Data,
    fine: &Data<'a>,
    start: AugmentedModel,
    candidates: &[Candidate],
    threshold: &Threshold,
) -> Searched<'a> {
    let mut open = candidates.to_vec();
    let mut selected = select(coarse, start, &open, threshold);
    loop {
        let fixed = selected.fixed;
        let (settled, mut contests) = settled(coarse, selected, fixed, &open, threshold);
        let data = coarse.with_noise(settled.noise.clone());
        let (examined, remainder) = remainder::examine(&data, settled, fixed, &open, threshold);
        if remainder.is_some() || examined.accepted.len() != contests.len() || open.len() < candidates.len() {
            contests = rivals(&data, &examined, fixed, candidates, threshold);
        }
        let fine = fine.with_noise(examined.noise.clone());
        let mut accepted = examined.accepted.clone();
        let system = fine.fit(examined.system.model.clone());
        let (system, doubtful) = confirmed(&fine, system, fixed, &mut accepted, &mut contests, threshold.chance);
        if doubtful.is_empty() || remainder.is_some() {
            return Searched {
                remainder: remainder.or_else(|| unaccounted(&fine, &system)),
                data: fine,
                system,
                fixed,
                accepted,
                contests,
            };
        }
        open.retain(|c| !doubtful.iter().any(|t| c.is_same_effect(t)));
        let left = Selected {
            system: data.fit(system.model),
            accepted,
            ..examined
        };
        selected = extend(&data, left, &open, threshold);
    }
}

/// Takes effects beyond the first `fixed` terms out that the samples do not confirm, the weakest first, until all that are left are: the chance of
/// `θᵀ C⁻¹ θ` (Wald), θ what the effect adds and C its covariance, is below `limit`. What was tried before is not counted again. Says what went.
fn confirmed(
    data: &Data,
    mut system: System,
    fixed: usize,
    accepted: &mut Vec<Accepted>,
    contests: &mut Vec<Contest>,
    limit: f64,
) -> (System, Vec<Term>) {
    let mut gone = Vec::new();
    loop {
        let doubts = (0..accepted.len()).map(|i| (i, doubt(&system, fixed + i)));
        match doubts.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((i, p)) if p >= limit => {
                accepted.remove(i);
                contests.remove(i);
                let mut model = system.model;
                gone.push(model.terms.remove(fixed + i));
                system = data.fit(model);
            }
            _ => return (system, gone),
        }
    }
}

/// Chance of values as large as those of term `at` where there is no such effect.
pub(super) fn doubt(system: &System, at: usize) -> f64 {
    let (statistic, parameters) = wald(&system.model.terms[at], &honest_covariance(system, at));
    chance(statistic, parameters)
}

/// `θᵀ C⁻¹ θ` and the length of θ, what `term` adds: its coefficients, or all parameters of a distortion, which is not there when they are zero.
/// `covariance` is that of all parameters of the term.
pub(super) fn wald(term: &Term, covariance: &DMatrix<f64>) -> (f64, usize) {
    // Coefficients come first; distortions have none.
    let values = match term.effect.kind() {
        Kind::Distortion => &term.shape[..term.free_shapes],
        _ => &term.coefficients[..],
    };
    let k = values.len();
    let block = covariance.view((0, 0), (k, k)).into_owned();
    let theta = DVector::from_column_slice(values);
    determined(&theta, &block)
}

/// `θᵀ C⁺ θ` and the number of directions that the covariance says anything of. Where it is not positive definite the data leave a direction open, or rounding is
/// all there is: that confirms nothing.
fn determined(theta: &DVector<f64>, covariance: &DMatrix<f64>) -> (f64, usize) {
    // Parameters have units of their own: the scale is that of their deviations.
    let scale = covariance.diagonal().map(|v| if v > 0.0 { v.sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_fn(theta.len(), theta.len(), |r, c| covariance[(r, c)] * scale[r] * scale[c]);
    if scaled.iter().any(|v| !v.is_finite()) {
        return (0.0, theta.len());
    }
    let eigen = scaled.symmetric_eigen();
    let along = eigen.eigenvectors.tr_mul(&theta.component_mul(&scale));
    let known: Vec<usize> = (0..theta.len()).filter(|&i| eigen.eigenvalues[i] > CERTAIN).collect();
    let statistic = known.iter().map(|&i| along[i] * along[i] / eigen.eigenvalues[i]).sum();
    (statistic, known.len().max(1))
}

/// Least eigenvalue of a correlation matrix that is more than rounding: the pseudo-inverse it comes from has lost up to 1e-13 of its own largest.
const CERTAIN: f64 = 1e-12;

/// Covariance of the parameters of term `at`. Misfit that is left on its joints widens it as it narrows the evidence.
pub(super) fn honest_covariance(system: &System, at: usize) -> DMatrix<f64> {
    let term = &system.model.terms[at];
    let joints: Vec<usize> = if term.joints.is_empty() {
        (0..system.model.robot.joint_count()).collect()
    } else {
        term.joints.clone()
    };
    if system.has_misfit(&joints) {
        system.jackknife(at)
    } else {
        system.term_covariance(at)
    }
}
