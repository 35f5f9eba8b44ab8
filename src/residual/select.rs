//! Forward and backward selection, one effect at a time.

use super::appraise::{Scored, appraise, chance, hypotheses};
use super::candidate::Candidate;
use super::confirm::wald;
use super::crossval::HeldOutGain;
use super::family::best_family;
use super::judge::{is_simpler, judge, stands_in};
use super::price::Rivalling;
use super::scan::scan;
use super::system::{Data, System};
use super::without_periods;
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
    /// Terms before the effects: those that the search began with, then nuisance offsets.
    pub fixed: usize,
    /// How many of them the search began with.
    pub declared: usize,
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
        fixed,
        declared: fixed,
        given_up: false,
    };
    extend(data, now, candidates, threshold)
}

/// Goes on from a selection.
pub(crate) fn extend(data: &Data, mut now: Selected, candidates: &[Candidate], threshold: &Threshold) -> Selected {
    if !now.system.noise_is_measured {
        return without_periods::extend(data, now, candidates, threshold);
    }
    let fixed = now.fixed;
    let data = data.with_noise(now.noise.clone());
    let mut open = candidates.to_vec();
    let mut rivalling = Rivalling::default();
    // Effects that come can make others superfluous, which may come again: twice as many steps as effects end a search that turns in a circle.
    for _ in 0..2 * threshold.most_effects {
        if now.accepted.len() >= threshold.most_effects {
            break;
        }
        let scored = scan(&data, &now.system, &open);
        let family = best_family(&data, &now.system, &open, &scored, threshold);
        // Functions imitate several effects of a kind as they imitate anything: as long as those are open, the search goes on.
        now.given_up = family.is_none() && rivalling.functions_are_cheaper(&data, &now, fixed, candidates, &scored);
        if now.given_up {
            break;
        }
        let step = step(&data, &now.system, &open, &scored, threshold);
        let single = step.as_ref().map_or(f64::NEG_INFINITY, |s| s.accepted.evidence);
        match (family, step) {
            (Some(family), _) if family.evidence > single => {
                now.system = family.system;
                now.accepted.extend(family.accepted);
            }
            (_, Some(step)) => {
                now.system = step.system;
                now.accepted.push(step.accepted);
                if let Some(other) = step.instead_of {
                    open.retain(|c| c.effect.code() != other.effect.code() || c.joints != other.joints);
                }
            }
            _ => break,
        }
        drop_superfluous(&data, &mut now, candidates, threshold);
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

/// The best candidate that earns its place, fitted together with everything else, or what is simpler and explains nearly as much.
fn step(data: &Data, system: &System, candidates: &[Candidate], scored: &[Scored], threshold: &Threshold) -> Option<Step> {
    let group = contenders(scored);
    let mut fitted: Vec<Fitted> = group.par_iter().map(|s| fitted(data, system, s)).collect();
    let evidence = |f: &Fitted| f.scored.held_against(fitted.iter().map(|o| &o.scored)).1;
    let evidences: Vec<f64> = fitted.iter().map(evidence).collect();
    let mut order: Vec<usize> = (0..fitted.len()).collect();
    order.sort_by(|&a, &b| evidences[b].total_cmp(&evidences[a]));
    let judged = |f: &Fitted| {
        let tried = hypotheses(candidates, f.scored.candidate.effect.code());
        let at = f.system.model.terms.len() - 1;
        judge(data, system, &f.scored, &f.system, at, threshold, tried)
    };
    let (best, accepted) = order.iter().find_map(|&i| Some((i, judged(&fitted[i])?)))?;
    let simpler = order.iter().find_map(|&i| {
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

fn reached(term: &Term, joints: usize) -> Vec<usize> {
    if term.joints.is_empty() {
        (0..joints).collect()
    } else {
        term.joints.clone()
    }
}

/// Takes out effects that later ones have made superfluous.
pub(super) fn drop_superfluous(data: &Data, now: &mut Selected, candidates: &[Candidate], threshold: &Threshold) {
    let fixed = now.fixed;
    let mut at = now.system.model.terms.len();
    while at > fixed {
        at -= 1;
        if at + 1 == now.system.model.terms.len() {
            continue;
        }
        let term: Term = now.system.model.terms[at].clone();
        let tried = hypotheses(candidates, term.effect.code());
        let superfluous =
            |loss: f64, parameters: usize| chance_of_loss(&now.system, at, loss, parameters) * tried > threshold.chance;
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

/// Chance of losing as much without term `at`, if there were no such effect. What is left was taken for noise before the last effect was found: only where
/// noise is measured can a loss be weighed by it alone.
pub(super) fn chance_of_loss(system: &System, at: usize, loss: f64, parameters: usize) -> f64 {
    let doubt = match system.noise_is_measured {
        true => 1.0,
        false => system.persistence(&reached(&system.model.terms[at], system.model.robot.joint_count())),
    };
    chance(loss / doubt, parameters)
}

/// Shapes and distortions of the others bend when an effect goes, and take over a part of what it explained: of what the linear model says, a
/// quarter is lost at least.
const LINEAR_SHARE: f64 = 0.25;
