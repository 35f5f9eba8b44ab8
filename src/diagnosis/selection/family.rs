//! Effects of one kind on several joints at once.
//!
//! Every motor has a rotor and every channel a zero: where one joint lacks its rotor inertia, the others mostly do as well. One
//! at a time they are hard to find, because base parameters bend to hide the rest of them, and what acts on two joints (a
//! coupling) explains more than any one of them. So all that can be seen of a kind are fitted at once, and those that the data do
//! not ask for are taken out again.

use super::acceptance::judge_beside;
use super::candidate::Candidate;
use super::elimination::chance_of_loss;
use super::score::{Scored, Weighed, hypotheses, weigh};
use super::types::{Accepted, Threshold};
use super::wald_test::wald;
use crate::effects;
use crate::regression::{Data, System};

/// Several effects of one kind that have earned their place together.
pub(crate) struct Family {
    pub system: System,
    /// One per newcomer, in the order of the model's last terms.
    pub accepted: Vec<Accepted>,
    /// Twice the log of the evidence ratio against none of them.
    pub evidence: f64,
}

/// The best family among those of the everyday kinds, beside `system`. `scored` says which candidates can be seen.
pub(crate) fn best_family(
    data: &Data,
    system: &System,
    candidates: &[Candidate],
    scored: &[Scored],
    threshold: &Threshold,
) -> Option<Family> {
    let kinds = effects::all().iter().filter(|e| e.is_everyday());
    let of = |code: &str| family(data, system, candidates, scored, threshold, code);
    kinds
        .filter_map(|e| of(e.code()))
        .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// All that can be seen of one kind, less those that the data do not ask for; `None` for fewer than two.
fn family(
    data: &Data,
    system: &System,
    candidates: &[Candidate],
    scored: &[Scored],
    threshold: &Threshold,
    code: &str,
) -> Option<Family> {
    let mut members: Vec<&Scored> = scored.iter().filter(|s| s.candidate.effect.code() == code).collect();
    members.sort_by_key(|s| s.candidate.joints.clone());
    let first = system.model.terms.len();
    let tried = hypotheses(candidates, code);
    let visible = members.len();
    while members.len() > 1 {
        let together = fitted(data, system, &members);
        // The linear model says what each is worth beside the others; the least is the first to go.
        let chances = (0..members.len()).map(|i| {
            let (statistic, parameters) = wald(&together.model.terms[first + i], &together.term_covariance(first + i));
            (i, chance_of_loss(&together, first + i, statistic, parameters) * tried)
        });
        let (weakest, chance) = chances.max_by(|a, b| a.1.total_cmp(&b.1))?;
        if chance < threshold.chance {
            match judged(data, &together, &members, first, threshold, tried) {
                Ok(accepted) => return Some(weighed(data, system, together, &members, accepted, visible)),
                Err(at) => members.remove(at),
            };
        } else {
            members.remove(weakest);
        }
    }
    None
}

fn fitted(data: &Data, system: &System, members: &[&Scored]) -> System {
    let mut model = system.model.clone();
    model.terms.extend(members.iter().map(|s| s.term.clone()));
    data.fit(model)
}

/// What every member shows beside the others, or the first that has not earned its place.
fn judged(
    data: &Data,
    together: &System,
    members: &[&Scored],
    first: usize,
    threshold: &Threshold,
    tried: f64,
) -> Result<Vec<Accepted>, usize> {
    let one = |i: usize| judge_beside(data, together, first + i, &members[i].candidate, threshold, tried).ok_or(i);
    (0..members.len()).map(one).collect()
}

fn weighed(
    data: &Data,
    system: &System,
    together: System,
    members: &[&Scored],
    accepted: Vec<Accepted>,
    visible: usize,
) -> Family {
    let mut joints: Vec<usize> = members.iter().flat_map(|s| s.candidate.joints.clone()).collect();
    joints.sort_unstable();
    joints.dedup();
    let gain = data.gain(system, &together);
    // Which of those that can be seen is a choice among all subsets.
    let subsets = 2f64.powi(visible as i32);
    let Weighed { evidence, .. } = weigh(system, &joints, gain, members.len(), subsets, Some(&together));
    Family {
        system: together,
        accepted,
        evidence,
    }
}
