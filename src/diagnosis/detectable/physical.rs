//! Whether a candidate of some size would pass for a real thing.

use super::gains::Gain;
use super::planned::Planned;
use super::signals::Signal;
use crate::diagnosis::selection::{Candidate, has_physical_signs, is_plausible};
use crate::diagnosis::settings::SETTINGS;
use nalgebra::DMatrix;

/// As the diagnosis judges an effect: positive where it must be, and that of a real thing.
pub(super) fn is_physical(planned: &Planned, candidate: &Candidate, gain: &Gain, size: f64) -> bool {
    let values: Vec<f64> = gain.coefficients.iter().map(|c| c * size).collect();
    let in_range = |(v, [low, high]): (&f64, &[f64; 2])| v > low && v < high;
    has_physical_signs(&candidate.effect, candidate.form, &values, &gain.covariance)
        && (!candidate.is_distortion() || values.iter().zip(&candidate.bounds).all(in_range))
        && (candidate.is_distortion()
            || is_plausible(
                &planned.system,
                &candidate.joints,
                &candidate.effect,
                &values,
                &gain.covariance,
            ))
}

/// Whether the effect of that size is one that robots have.
pub(super) fn is_real(planned: &Planned, candidate: &Candidate, signal: &Signal, size: f64) -> bool {
    let values: Vec<f64> = signal.unit.iter().map(|u| u * size).collect();
    let in_range = |(v, [low, high]): (&f64, &[f64; 2])| v > low && v < high;
    match candidate.is_distortion() {
        true => {
            size.is_finite()
                && values.iter().zip(&candidate.bounds).all(in_range)
                && (!candidate.effect.distorts_by_load()
                    || bend_of_bend(planned, candidate, signal, &values) < SETTINGS.detectable.most_bend_of_bend)
        }
        false => {
            let certain = DMatrix::zeros(values.len(), values.len());
            size.is_finite() && is_plausible(&planned.system, &candidate.joints, &candidate.effect, &values, &certain)
        }
    }
}

/// What the torque of an elastic joint differs from that of its first bend, as a share of it: the bend adds `c M ω²` of itself, c
/// the compliance and M the inertia behind the joint. Where that is not small the arm rings, and quasi-static elasticity is no
/// model of it.
fn bend_of_bend(planned: &Planned, candidate: &Candidate, signal: &Signal, values: &[f64]) -> f64 {
    let mut model = planned.system.model.clone();
    model.terms.push(candidate.term(values, &[]));
    let there = planned.data.linearise(model);
    let size = values[signal.parameter];
    let (mut first, mut beyond) = (0.0, 0.0);
    for ((before, after), rows) in planned.system.blocks.iter().zip(&there.blocks).zip(&signal.rows) {
        for (joint, linear) in rows {
            let (before, after) = (&before[*joint], &after[*joint]);
            // Where the bent joint turns round a sample earlier or later, rows of one have no counterpart.
            for row in (0..linear.len()).filter(|&row| before.rows[row] && after.rows[row]) {
                let (first_bend, whole) = (size * linear[row], before.residual[row] - after.residual[row]);
                first += first_bend * first_bend;
                beyond += (whole - first_bend) * (whole - first_bend);
            }
        }
    }
    (beyond / first).sqrt()
}
