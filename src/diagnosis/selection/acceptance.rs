//! Whether a fitted candidate has earned its place, and whether something simpler takes it.

use super::candidate::{Candidate, columns_of, reach};
use super::cross_validation::held_out_gain;
use super::score::{Scored, appraise, chance};
use super::types::{Accepted, Threshold};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::{AnyEffect, Travel};
use crate::regression::{Data, System};
use nalgebra::DMatrix;

/// Whether a fitted candidate, term `at` of the model `after`, has earned its place.
pub(crate) fn judge(
    data: &Data,
    before: &System,
    scored: &Scored,
    after: &System,
    at: usize,
    threshold: &Threshold,
    tried: f64,
) -> Option<Accepted> {
    let promising = scored.evidence > 0.0 && explains_a_share(before, scored, threshold.share) && is_physical(after, at);
    if !promising {
        return None;
    }
    let term = &after.model.terms[at];
    let columns = columns_of(data, before, &scored.candidate, std::slice::from_ref(&term.shape));
    let p_value = (chance(scored.fair_gain, scored.cost) * tried).min(1.0);
    if p_value >= threshold.chance {
        return None;
    }
    let held_out = held_out_gain(data, before, &columns);
    let linear = before.reduced(&columns).gain.min(scored.gain);
    let generalises = held_out.blocks > threshold.generalises * linear;
    let repeats = held_out.periods.is_none_or(|g| g > 0.0);
    if !(generalises && repeats) {
        return None;
    }
    let Scored {
        candidate,
        fair_gain,
        evidence,
        ..
    } = scored;
    Some(Accepted {
        effect: candidate.effect.code().into(),
        gain: *fair_gain,
        evidence: *evidence,
        p_value,
        held_out,
    })
}

/// The same for one of several effects that came together: what it shows beside the others, of a fit without it.
pub(crate) fn judge_beside(
    data: &Data,
    together: &System,
    at: usize,
    candidate: &Candidate,
    threshold: &Threshold,
    tried: f64,
) -> Option<Accepted> {
    let mut model = together.model.clone();
    let term = model.terms.remove(at);
    let without = data.fit(model);
    let gain = data.gain(&without, together);
    let rank = term.parameters() - candidate.free_shapes().min(term.parameters());
    let own = appraise(&without, candidate, term, gain, rank, candidate.grid().len(), Some(together));
    judge(data, &without, &own, together, at, threshold, tried)
}

/// Whether the parameters of term `at` lie inside their ranges and have the signs that their meaning asks for, by three standard
/// deviations.
pub(crate) fn is_physical(system: &System, at: usize) -> bool {
    let term = &system.model.terms[at];
    let covariance = if system.noise_is_measured {
        system.term_covariance(at)
    } else {
        system.jackknife(at)
    };
    let k = term.coefficients.len();
    let values: Vec<f64> = term
        .coefficients
        .iter()
        .chain(&term.shape[..term.free_shapes])
        .copied()
        .collect();
    let inside = term.bounds.iter().take(term.free_shapes).enumerate().all(|(i, [low, high])| {
        let margin = 1e-6 * (high - low);
        !margin.is_finite() || (values[k + i] > low + margin && values[k + i] < high - margin)
    });
    let own = covariance.view((0, 0), (k, k)).into_owned();
    let plausible = is_plausible(system, &term.joints, &term.effect, &term.coefficients, &own);
    inside && plausible && has_physical_signs(&term.effect, term.form, &values, &covariance)
}

/// Whether what must be positive is not clearly negative, and some of it is positive. `values` are coefficients, then estimated
/// shapes.
pub(crate) fn has_physical_signs(effect: &AnyEffect, form: usize, values: &[f64], covariance: &DMatrix<f64>) -> bool {
    let all: Vec<usize> = effect.positive(form).iter().copied().filter(|&i| i < values.len()).collect();
    let allowed = |&i: &usize| values[i] > -SETTINGS.selection.sign_deviations * covariance[(i, i)].max(0.0).sqrt();
    all.iter().all(allowed) && (all.is_empty() || all.iter().any(|&i| values[i] > 0.0))
}

/// Whether coefficients are those of a real thing on all joints, as far as their covariance lets it be seen.
pub(crate) fn is_plausible(
    system: &System,
    joints: &[usize],
    effect: &AnyEffect,
    coefficients: &[f64],
    covariance: &DMatrix<f64>,
) -> bool {
    joints
        .iter()
        .all(|&j| effect.is_plausible(coefficients, covariance, travel(system, j)))
}

/// Where a joint can be: within its limits, and where it was.
fn travel(system: &System, joint: usize) -> Travel {
    let limits = system.model.robot.joints()[joint].limits.position;
    let positions = system
        .evaluated
        .iter()
        .flat_map(|e| e.motion.positions(joint).iter().copied());
    let [low, high] = positions.fold(limits.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]), |[l, h], q| {
        [l.min(q), h.max(q)]
    });
    Travel { low, high }
}

/// An effect that explains a sliver of a large misfit is a part of an approximation, not its cause.
fn explains_a_share(system: &System, scored: &Scored, share: f64) -> bool {
    let joints = reach(&scored.candidate, system.model.robot.joint_count());
    let rows: usize = joints.iter().map(|&j| system.rows(j)).sum();
    let sum: f64 = joints.iter().map(|&j| system.joint_chi_square(j)).sum();
    // Without measured noise all of it may be misfit.
    let excess = if system.noise_is_measured { sum - rows as f64 } else { sum };
    scored.gain > share * excess
}

/// On the same joints, what every robot has in the place of what few have, or the same effect with fewer parameters.
pub(crate) fn is_simpler(one: &Candidate, other: &Candidate) -> bool {
    let common = one.effect.is_everyday() && !other.effect.is_everyday();
    let plainer = one.effect.code() == other.effect.code() && one.shapes.len() < other.shapes.len();
    one.joints == other.joints && !one.joints.is_empty() && (common || plainer)
}

/// Whether something simpler is to be named in the place of what explains more: it explains nearly as much, and the difference is
/// less than what the better one leaves unexplained. What the model still lacks could then turn the balance, and what is common
/// is the likelier cause. Where the better one leaves nothing above the measured noise, it keeps its place.
pub(crate) fn stands_in(simple: &Scored, best: &Scored, with_best: &System) -> bool {
    let joints = &best.candidate.joints;
    if !is_simpler(&simple.candidate, &best.candidate) {
        return false;
    }
    let rows: usize = joints.iter().map(|&j| with_best.rows(j)).sum();
    let noise = if with_best.noise_is_measured { rows as f64 } else { 0.0 };
    let left = with_best.mean_square(joints) * rows as f64 - noise;
    let difference = best.gain - simple.gain;
    simple.gain > SETTINGS.selection.simpler_share * best.gain && difference < left && with_best.has_misfit(joints)
}
