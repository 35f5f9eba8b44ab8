//! Forward and backward selection, one effect at a time.

use super::candidate::{Candidate, Scored, appraise, chance, columns_of, hypotheses, reach, scan};
use super::confirm::wald;
use super::crossval::{HeldOutGain, held_out_gain};
use super::dependence::chance_of;
use super::remainder::Rivalling;
use super::system::{Data, System};
use super::{AugmentedModel, NoiseModel, Term};
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
    /// Noise that the system's rows are whitened with: what is left, where it is not measured.
    pub noise: Vec<NoiseModel>,
    /// Whether smooth functions account for the data at so much lower a price that the search for further effects was given up.
    pub given_up: bool,
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
    let now = Selected {
        system: data.fit(start),
        accepted: Vec::new(),
        noise: data.noise.clone(),
        given_up: false,
    };
    extend(data, now, fixed, candidates, threshold)
}

/// Goes on from a selection, whose first `fixed` terms were there before it.
pub(crate) fn extend(data: &Data, mut now: Selected, fixed: usize, candidates: &[Candidate], threshold: &Threshold) -> Selected {
    let mut data = data.with_noise(now.noise.clone());
    let mut open = candidates.to_vec();
    let mut rivalling = Rivalling::default();
    // Effects that come can make others superfluous, which may come again: twice as many steps as effects end a search that turns in a circle.
    for _ in 0..2 * threshold.most_effects {
        if now.accepted.len() >= threshold.most_effects {
            break;
        }
        let scored = scan(&data, &now.system, &open);
        now.given_up = rivalling.functions_are_cheaper(&data, &now, fixed, candidates, &scored);
        if now.given_up {
            break;
        }
        let Some(step) = step(&data, &now.system, &open, &scored, threshold) else {
            break;
        };
        now.system = step.system;
        now.accepted.push(step.accepted);
        if let Some(other) = step.instead_of {
            open.retain(|c| c.effect.code() != other.effect.code() || c.joints != other.joints);
        }
        if !now.system.noise_is_measured {
            data = data.with_noise(data.left_as_noise(&now.system));
            now.system = data.fit(now.system.model.clone());
        }
        drop_superfluous(&data, &mut now, fixed, candidates, threshold);
    }
    now.noise = data.noise;
    now
}

/// An effect that has earned its place.
struct Step {
    system: System,
    accepted: Accepted,
    /// The effect that explains a little more, and that gave way to this one.
    instead_of: Option<Candidate>,
}

/// A contender, fitted with everything else.
struct Fitted {
    scored: Scored,
    system: System,
}

/// The best candidate that earns its place, fitted together with everything else.
fn step(data: &Data, system: &System, candidates: &[Candidate], scored: &[Scored], threshold: &Threshold) -> Option<Step> {
    let first = contenders(scored);
    // Where all rows have misfit, imitators without physical sense can fill the first places: further ones get their turn.
    let further = scored
        .iter()
        .filter(|s| !system.noise_is_measured && s.evidence > 0.0 && !first.iter().any(|c| std::ptr::eq(*c, *s)))
        .take(MOST_FITTED.saturating_sub(first.len()))
        .collect::<Vec<_>>();
    let groups = std::iter::once(first).chain(further.chunks(GROUP).map(<[_]>::to_vec));
    groups
        .map(|group| best_of(data, system, &group, candidates, threshold))
        .find_map(|found| found)
}

/// Fits per step: the right one is among the first two dozen or explains next to nothing.
const MOST_FITTED: usize = 24;
const GROUP: usize = 6;

/// The best of a group, or what is simpler and explains nearly as much.
fn best_of(data: &Data, system: &System, group: &[&Scored], candidates: &[Candidate], threshold: &Threshold) -> Option<Step> {
    let mut fitted: Vec<Fitted> = group.par_iter().map(|s| fitted(data, system, s)).collect();
    fitted.sort_by(|a, b| b.scored.evidence.total_cmp(&a.scored.evidence));
    let judged = |f: &Fitted| {
        let tried = hypotheses(candidates, f.scored.candidate.effect.code());
        judge(data, system, &f.scored, &f.system, threshold, tried)
    };
    let (best, accepted) = fitted.iter().enumerate().find_map(|(i, f)| Some((i, judged(f)?)))?;
    let simpler = (0..fitted.len()).find_map(|i| {
        let stands_in = i != best && stands_in(&fitted[i].scored, &fitted[best].scored, &fitted[best].system);
        stands_in.then(|| Some((i, judged(&fitted[i])?))).flatten()
    });
    let instead_of = simpler.is_some().then(|| fitted[best].scored.candidate.clone());
    let (at, accepted) = simpler.unwrap_or((best, accepted));
    Some(Step {
        system: fitted.swap_remove(at).system,
        accepted,
        instead_of,
    })
}

/// Candidates worth fitting: the linearised gain of a distortion, or of a column made of torques that are not right yet, is off by a fraction; the
/// true one decides.
fn contenders(scored: &[Scored]) -> Vec<&Scored> {
    let open: Vec<&Scored> = scored.iter().filter(|s| s.evidence > 0.0).collect();
    let best = open.first().map_or(0.0, |s| s.evidence);
    let near = open
        .iter()
        .filter(|s| s.evidence > best - (0.3 * best.abs()).max(6.0))
        .take(4);
    let mut list: Vec<&Scored> = near.copied().collect();
    // An effect on many joints is weighed against what is left on all of them: those that gain most stay in, whatever is left.
    let mut by_gain = open.clone();
    by_gain.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    // And whatever can stand in for one of them by being simpler.
    let near = list.clone();
    let simpler = open
        .iter()
        .filter(|s| near.iter().any(|n| is_simpler(&s.candidate, &n.candidate)))
        .copied();
    for scored in by_gain.into_iter().take(3).chain(simpler) {
        if !list.iter().any(|c| std::ptr::eq(*c, scored)) {
            list.push(scored);
        }
    }
    list
}

fn fitted(data: &Data, system: &System, scored: &Scored) -> Fitted {
    let mut model = system.model.clone();
    model.terms.push(scored.term.clone());
    let there = data.fit(model);
    let gain = data.gain(system, &there);
    let rank = if scored.term.is_distortion() {
        scored.cost
    } else {
        scored.cost - scored.candidate.shapes.len().min(scored.cost)
    };
    let term = scored.term.clone();
    let scored = appraise(system, &scored.candidate, term, gain, rank, scored.tried, Some(&there));
    Fitted { scored, system: there }
}

/// Effects that are alike on ordinary motions share this much: |qd| of a sinusoid is a constant to 8/π² = 81 %, of constant speeds to more.
const ALIKE: f64 = 0.75;

/// On the same joints, what every robot has in the place of what few have, or the same effect with fewer parameters.
fn is_simpler(one: &Candidate, other: &Candidate) -> bool {
    let common = one.effect.is_everyday() && !other.effect.is_everyday();
    let plainer = one.effect.code() == other.effect.code() && one.shapes.len() < other.shapes.len();
    one.joints == other.joints && !one.joints.is_empty() && (common || plainer)
}

/// Whether something simpler is to be named in the place of what explains more: it explains nearly as much, and the difference
/// is less than what the better one leaves unexplained. What the model still lacks could then turn the balance, and what is common is the
/// likelier cause. Where the better one leaves nothing above the measured noise, it keeps its place.
fn stands_in(simple: &Scored, best: &Scored, with_best: &System) -> bool {
    let joints = &best.candidate.joints;
    if !is_simpler(&simple.candidate, &best.candidate) {
        return false;
    }
    let rows: usize = joints.iter().map(|&j| with_best.rows(j)).sum();
    let noise = if with_best.noise_is_measured { rows as f64 } else { 0.0 };
    let left = with_best.mean_square(joints) * rows as f64 - noise;
    let difference = best.gain - simple.gain;
    simple.gain > ALIKE * best.gain && difference < left && with_best.has_misfit(joints)
}

/// Whether a fitted candidate has earned its place.
pub(crate) fn judge(
    data: &Data,
    before: &System,
    scored: &Scored,
    after: &System,
    threshold: &Threshold,
    tried: f64,
) -> Option<Accepted> {
    let promising = scored.evidence > 0.0 && explains_a_share(before, scored, threshold.share) && is_physical(after);
    if !promising {
        return None;
    }
    let term = after.model.terms.last().expect("the candidate was added");
    let columns = columns_of(data, before, &scored.candidate, std::slice::from_ref(&term.shape));
    let single = if before.noise_is_measured {
        chance(scored.fair_gain, scored.cost)
    } else {
        chance_of(before, &columns)
    };
    let p_value = (single * tried).min(1.0);
    // Sums over forty stretches of time are normal only nearly, and less so far out.
    let limit = if before.noise_is_measured {
        threshold.chance
    } else {
        0.1 * threshold.chance
    };
    if p_value >= limit {
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
    let covariance = if system.noise_is_measured {
        system.term_covariance(at)
    } else {
        system.spread(at)
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
    let significant = |i: usize| values[i] > -3.0 * covariance[(i, i)].max(0.0).sqrt();
    let positive = term.effect.positive(term.form);
    inside && positive.iter().all(|&i| significant(i)) && positive.iter().any(|&i| values[i] > 0.0) | positive.is_empty()
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

fn reached(term: &Term, joints: usize) -> Vec<usize> {
    if term.joints.is_empty() {
        (0..joints).collect()
    } else {
        term.joints.clone()
    }
}

/// Takes out effects that later ones have made superfluous.
fn drop_superfluous(data: &Data, now: &mut Selected, fixed: usize, candidates: &[Candidate], threshold: &Threshold) {
    let mut at = now.system.model.terms.len();
    while at > fixed {
        at -= 1;
        if at + 1 == now.system.model.terms.len() {
            continue;
        }
        let term: Term = now.system.model.terms[at].clone();
        // What is left was taken for noise before the last effect was found: only where that is measured can a loss be weighed by it alone.
        let doubt = match now.system.noise_is_measured {
            true => 1.0,
            false => now.system.persistence(&reached(&term, now.system.model.robot.joint_count())),
        };
        let tried = hypotheses(candidates, term.effect.code());
        let superfluous = |loss: f64, parameters: usize| chance(loss / doubt, parameters) * tried > threshold.chance;
        // A fit without the effect says what is lost; where the linear model says many times what is needed, it need not be made.
        let (linear, _) = wald(&term, &now.system.term_covariance(at));
        if !superfluous(LINEAR_SHARE * linear, term.parameters()) {
            continue;
        }
        let mut model = now.system.model.clone();
        model.terms.remove(at);
        let without = data.fit(model);
        let loss = data.gain(&without, &now.system);
        if superfluous(loss, term.parameters()) {
            now.system = without;
            now.accepted.remove(at - fixed);
        }
    }
}

/// Shapes and distortions of the others bend when an effect goes, and take over a part of what it explained: of what the linear model says, a
/// quarter is lost at least.
const LINEAR_SHARE: f64 = 0.25;
