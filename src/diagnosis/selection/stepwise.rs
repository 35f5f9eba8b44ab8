//! Forward and backward selection, one effect at a time.

use super::acceptance::{is_simpler, judge, stands_in};
use super::candidate::Candidate;
use super::elimination::drop_superfluous;
use super::family::best_family;
use super::fitted::{Fitted, fitted};
use super::pairs::best_pair;
use super::score::{Scored, hypotheses, one_form_each};
use super::screening::scan;
use super::types::{Accepted, Selected, Threshold};
use crate::diagnosis::nonparametric::Rivalling;
use crate::diagnosis::without_periods;
use crate::regression::{AugmentedModel, Data, System};
use rayon::prelude::*;

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

/// Continues a stepwise selection.
pub(crate) fn extend(data: &Data, mut now: Selected, candidates: &[Candidate], threshold: &Threshold) -> Selected {
    if !now.system.noise_is_measured {
        return without_periods::extend(data, now, candidates, threshold);
    }
    let fixed = now.fixed;
    let data = data.with_noise(now.noise.clone());
    let mut open = candidates.to_vec();
    let mut rivalling = Rivalling::default();
    // Effects that come can make others superfluous, which may come again: twice as many steps as effects end a search that turns
    // in a circle.
    for _ in 0..2 * threshold.most_effects {
        if now.accepted.len() >= threshold.most_effects {
            break;
        }
        let scored = scan(&data, &now.system, &open);
        let family = best_family(&data, &now.system, &open, &scored, threshold);
        // Functions imitate several effects of a kind as they imitate anything: as long as those are open, the search goes on.
        now.given_up = family.is_none() && rivalling.functions_are_cheaper(&data, &now, fixed, candidates, &scored);
        let step = match now.given_up {
            true => None,
            false => step(&data, &now.system, &open, &scored, threshold),
        };
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
            // Neither of two may earn its place without the other.
            _ => {
                let fits = now.accepted.len() + 2 <= threshold.most_effects;
                let pair = fits
                    .then(|| best_pair(&data, &now.system, &open, &scored, threshold))
                    .flatten();
                let Some(pair) = pair else { break };
                now.given_up = false;
                now.system = pair.system;
                now.accepted.extend(pair.accepted);
            }
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

/// Candidates worth fitting: the linearised gain of a distortion, or of a column made of torques that are not right yet, is off
/// by a fraction; the true one decides.
fn contenders(scored: &[Scored]) -> Vec<&Scored> {
    let open: Vec<&Scored> = scored.iter().filter(|s| s.evidence > 0.0).collect();
    let best = open.first().map_or(0.0, |s| s.evidence);
    let near = open
        .iter()
        .filter(|s| s.evidence > best - (0.3 * best.abs()).max(6.0))
        .take(4);
    let mut list: Vec<&Scored> = near.copied().collect();
    // An effect on many joints is weighed against what is left on all of them: those that gain most stay in, whatever is left;
    // of the forms of one effect the best.
    let mut by_gain = open.clone();
    by_gain.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    one_form_each(&mut by_gain);
    for scored in by_gain.into_iter().take(3) {
        if !list.iter().any(|c| std::ptr::eq(*c, scored)) {
            list.push(scored);
        }
    }
    // And whatever can stand in for one of them by being simpler: beside others a form with a shape gains most at the end of its
    // range, and only the plain one is the cause.
    let simpler =
        |s: &&Scored| list.iter().any(|n| is_simpler(&s.candidate, &n.candidate)) && !list.iter().any(|c| std::ptr::eq(*c, *s));
    let simpler: Vec<&Scored> = open.iter().copied().filter(simpler).collect();
    list.extend(simpler);
    list
}
