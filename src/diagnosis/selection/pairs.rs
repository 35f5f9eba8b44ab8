//! Two effects at once, where neither earns its place alone.
//!
//! Two laws of friction on one joint hide each other: beside the base parameters each alone explains a sliver of what both
//! explain together, and neither passes. Such a pair is named only where it leaves nothing but noise on its joints: pairs are
//! many, and two effects that explain a part of a misfit are an approximation of something else.

use super::acceptance::judge_beside;
use super::candidate::{Candidate, reach};
use super::fitted::fitted;
use super::score::{Scored, Weighed, hypotheses, one_form_each, weigh};
use super::screening::scan_on_grid;
use super::types::{Accepted, Threshold};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{Data, System};
use rayon::prelude::*;

/// Two effects that have earned their place together.
pub(crate) struct Pair {
    pub system: System,
    /// In the order of the model's last two terms.
    pub accepted: [Accepted; 2],
}

/// The pair with the best evidence beside `system`, of those that settle joints that it leaves a misfit on. `scored` says which
/// candidates can be seen.
pub(crate) fn best_pair(
    data: &Data,
    system: &System,
    candidates: &[Candidate],
    scored: &[Scored],
    threshold: &Threshold,
) -> Option<Pair> {
    let joints = system.model.robot.joint_count();
    let open = |s: &&Scored| {
        let reached = reach(&s.candidate, joints);
        let room = |&j: &usize| system.model.effects_on(j) + 2 <= threshold.most_per_joint;
        reached.iter().any(|&j| system.has_misfit(&[j])) && reached.iter().all(room)
    };
    let mut firsts: Vec<&Scored> = scored.iter().filter(open).collect();
    firsts.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    one_form_each(&mut firsts);
    firsts.truncate(SETTINGS.selection.pair_firsts);
    let seconds = |first: &&Scored| with_a_second(data, system, candidates, first);
    let mut pairs: Vec<FittedPair> = firsts.par_iter().with_max_len(1).flat_map(seconds).collect();
    pairs.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    pairs.into_iter().find_map(|p| judged(data, p, candidates, threshold))
}

/// A pair, fitted with everything else.
struct FittedPair {
    system: System,
    members: [Scored; 2],
    evidence: f64,
}

/// The best effects on joints of `first` beside it.
fn with_a_second(data: &Data, system: &System, candidates: &[Candidate], first: &Scored) -> Vec<FittedPair> {
    let joints = system.model.robot.joint_count();
    let reached = reach(&first.candidate, joints);
    let meets = |c: &&Candidate| reach(c, joints).iter().any(|j| reached.contains(j));
    let others: Vec<Candidate> = candidates.iter().filter(meets).cloned().collect();
    let beside = fitted(data, system, first).system;
    // A fit finds the shapes; where none on the grid may settle the joints, none needs to be made.
    let mut seconds = scan_on_grid(data, &beside, &others);
    seconds.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let pair = |second: &Scored| {
        let mut reached = reached.clone();
        reached.extend(reach(&second.candidate, joints));
        reached.sort_unstable();
        reached.dedup();
        if !second.could_settle(&beside, &reached) {
            return None;
        }
        let together = fitted(data, &beside, second).system;
        // Two that leave a misfit on their joints are not its cause.
        (!together.has_misfit(&reached)).then(|| {
            let members = [first.clone(), second.clone()];
            let parameters = members.iter().map(|m| m.cost).sum();
            let tried = members
                .iter()
                .map(|m| hypotheses(candidates, m.candidate.effect.code()))
                .product();
            let gain = data.gain(system, &together);
            let Weighed { evidence, .. } = weigh(system, &reached, gain, parameters, tried, Some(&together));
            FittedPair {
                system: together,
                members,
                evidence,
            }
        })
    };
    seconds
        .iter()
        .take(SETTINGS.selection.pair_seconds)
        .filter_map(pair)
        .collect()
}

/// The pair, if each of the two has earned its place beside the other.
fn judged(data: &Data, pair: FittedPair, candidates: &[Candidate], threshold: &Threshold) -> Option<Pair> {
    if pair.evidence <= 0.0 {
        return None;
    }
    let first = pair.system.model.terms.len() - 2;
    let one = |i: usize| {
        let candidate = &pair.members[i].candidate;
        let tried = hypotheses(candidates, candidate.effect.code());
        judge_beside(data, &pair.system, first + i, candidate, threshold, tried)
    };
    let accepted = [one(0)?, one(1)?];
    Some(Pair {
        system: pair.system,
        accepted,
    })
}
