//! Forward and backward selection, one effect at a time.

use super::candidate::{Candidate, Scored, appraise, chance, columns_of, hypotheses, reach, scan};
use super::crossval::{HeldOutGain, held_out_gain};
use super::system::{Data, System};
use super::{AugmentedModel, Term};
use rayon::prelude::*;

/// What an accepted effect has shown.
#[derive(Debug, Clone)]
pub(crate) struct Accepted {
    pub effect: &'static str,
    /// Decrease of the weighted sum of squares, fair to what is left.
    pub gain: f64,
    pub evidence: f64,
    /// Chance of such a gain without the effect, times the number of hypotheses.
    pub p_value: f64,
    pub held_out: HeldOutGain,
}

/// The result of a selection.
pub(crate) struct Selected {
    pub system: System,
    /// In the order of acceptance, one per term of the model.
    pub accepted: Vec<Accepted>,
}

/// What an effect must reach.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Threshold {
    /// Largest chance of a false finding in the whole search.
    pub chance: f64,
    /// Share of what is left over (above the noise) on the joints reached that an effect must explain.
    pub share: f64,
    /// Share of the gain that must be there on blocks of time left out.
    pub generalises: f64,
    pub most_effects: usize,
}

pub(crate) fn select(data: &Data, start: AugmentedModel, candidates: &[Candidate], threshold: &Threshold) -> Selected {
    let fixed = start.terms.len();
    let mut now = Selected {
        system: data.fit(start),
        accepted: Vec::new(),
    };
    for _ in 0..threshold.most_effects {
        let Some((system, accepted)) = step(data, &now.system, candidates, threshold) else {
            break;
        };
        now.system = system;
        now.accepted.push(accepted);
        drop_superfluous(data, &mut now, fixed, candidates, threshold);
    }
    now
}

/// The best candidate that earns its place, fitted together with everything else.
fn step(data: &Data, system: &System, candidates: &[Candidate], threshold: &Threshold) -> Option<(System, Accepted)> {
    let scored = scan(data, system, candidates);
    let best = scored.first()?.evidence;
    // The linearised gain of a distortion, or of a column made of torques that are not right yet, is off by a fraction; the true one decides.
    // Without measured noise what is left decides, and that is known only afterwards.
    let open = |s: &Scored| s.evidence > 0.0 || !system.noise_is_measured;
    let mut contenders: Vec<&Scored> = scored
        .iter()
        .filter(|s| open(s) && s.evidence > best - (0.3 * best.abs()).max(6.0))
        .take(4)
        .collect();
    // An effect on many joints is weighed against what is left on all of them: those that gain most stay in, whatever is left.
    let mut by_gain: Vec<&Scored> = scored.iter().filter(|s| open(s)).collect();
    by_gain.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    for scored in by_gain.into_iter().take(3) {
        if !contenders.iter().any(|c| std::ptr::eq(*c, scored)) {
            contenders.push(scored);
        }
    }
    let before = data.chi_square(system);
    let mut fitted: Vec<(Scored, System)> = contenders
        .par_iter()
        .map(|s| {
            let mut model = system.model.clone();
            model.terms.push(s.term.clone());
            let there = data.fit(model);
            let gain = before - data.chi_square(&there);
            let rank = if s.term.is_distortion() {
                s.cost
            } else {
                s.cost - s.candidate.shapes.len().min(s.cost)
            };
            let scored = appraise(system, &s.candidate, s.term.clone(), gain, rank, s.tried, Some(&there));
            (scored, there)
        })
        .collect();
    fitted.sort_by(|a, b| b.0.evidence.total_cmp(&a.0.evidence));
    fitted.into_iter().find_map(|(scored, there)| {
        let tried = hypotheses(candidates, scored.candidate.effect.code());
        let accepted = judge(data, system, &scored, &there, threshold, tried)?;
        Some((there, accepted))
    })
}

/// Whether a fitted candidate has earned its place.
fn judge(data: &Data, before: &System, scored: &Scored, after: &System, threshold: &Threshold, tried: f64) -> Option<Accepted> {
    let p_value = (chance(scored.fair_gain, scored.cost) * tried).min(1.0);
    let enough = scored.evidence > 0.0 && p_value < threshold.chance && explains_a_share(before, scored, threshold.share);
    if !enough {
        return None;
    }
    let term = after.model.terms.last().expect("the candidate was added");
    if !is_physical(after) {
        return None;
    }
    let columns = columns_of(data, before, &scored.candidate, std::slice::from_ref(&term.shape));
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
        effect: candidate.effect.code(),
        gain: *fair_gain,
        evidence: *evidence,
        p_value,
        held_out,
    })
}

/// Whether the last term's parameters lie inside their ranges and have the signs that their meaning asks for, by three standard deviations.
fn is_physical(system: &System) -> bool {
    let at = system.model.terms.len() - 1;
    let term = &system.model.terms[at];
    let covariance = system.term_covariance(at);
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
    let significant = |i: usize| values[i] > -3.0 * covariance[(i, i)].max(0.0).sqrt();
    let positive = term.effect.positive(term.form);
    inside && positive.iter().all(|&i| significant(i)) && positive.iter().any(|&i| values[i] > 0.0) | positive.is_empty()
}

/// An effect that explains a sliver of a large misfit is a part of an approximation, not its cause.
fn explains_a_share(system: &System, scored: &Scored, share: f64) -> bool {
    let joints = reach(&scored.candidate, system.model.robot.joint_count());
    let rows: usize = joints.iter().map(|&j| system.rows(j)).sum();
    let sum: f64 = joints.iter().map(|&j| system.joint_chi_square(j)).sum();
    let excess = sum - rows as f64;
    scored.gain > share * excess
}

/// Takes out effects that later ones have made superfluous.
fn drop_superfluous(data: &Data, now: &mut Selected, fixed: usize, candidates: &[Candidate], threshold: &Threshold) {
    let mut at = now.system.model.terms.len();
    while at > fixed {
        at -= 1;
        if at + 1 == now.system.model.terms.len() {
            continue;
        }
        let mut model = now.system.model.clone();
        let term: Term = model.terms.remove(at);
        let without = data.fit(model);
        let loss = data.chi_square(&without) - data.chi_square(&now.system);
        if chance(loss, term.parameters()) * hypotheses(candidates, term.effect.code()) > threshold.chance {
            now.system = without;
            now.accepted.remove(at - fixed);
        }
    }
}
