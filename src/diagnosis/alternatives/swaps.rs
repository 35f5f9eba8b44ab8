//! One effect in the place of two, and two in the place of one.
//!
//! Two effects may imitate one that was not there when they were found, and one may imitate two. One for one does not part them:
//! beside the half that stays the right one gains little. What takes their place leaves nothing but noise on its joints, as in
//! other exchanges.

use crate::diagnosis::nonparametric::score_of;
use crate::diagnosis::selection::{
    Accepted, Candidate, Scored, Selected, Threshold, best_pair, fitted, hypotheses, judge, reach, reached, scan_on_grid,
};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{Data, System};
use rayon::prelude::*;

/// The selection after the exchange that the evidence prefers most, if it prefers one to what is there.
pub(super) fn swapped(
    data: &Data,
    selected: &Selected,
    fixed: usize,
    candidates: &[Candidate],
    threshold: &Threshold,
) -> Option<Selected> {
    let swaps = Swaps {
        data,
        selected,
        fixed,
        candidates,
        threshold,
    };
    let count = selected.accepted.len();
    let pairs = (0..count).flat_map(|i| (0..i).map(move |k| vec![k, i]));
    let all: Vec<Vec<usize>> = (0..count).map(|i| vec![i]).chain(pairs).collect();
    let own = score_of(data, &selected.system, candidates, fixed);
    let better = |out: &Vec<usize>| {
        let (system, accepted) = match out[..] {
            [one] => swaps.two_for(one)?,
            _ => swaps.one_for(out)?,
        };
        let score = score_of(data, &system, candidates, fixed) - own;
        (score > SETTINGS.alternatives.not_excluded).then_some((score, system, accepted))
    };
    let found: Vec<_> = all.par_iter().with_max_len(1).filter_map(better).collect();
    let (_, system, accepted) = found.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Selected {
        system,
        accepted,
        noise: selected.noise.clone(),
        given_up: false,
        ..*selected
    })
}

/// What all exchanges share.
struct Swaps<'a> {
    data: &'a Data<'a>,
    selected: &'a Selected,
    fixed: usize,
    candidates: &'a [Candidate],
    threshold: &'a Threshold,
}

impl Swaps<'_> {
    fn joints(&self) -> usize {
        self.selected.system.model.robot.joint_count()
    }

    /// Joints that effect `i` moves.
    fn reached(&self, i: usize) -> Vec<usize> {
        reached(&self.selected.system.model.terms[self.fixed + i], self.joints())
    }

    /// The model without some effects, and what the others have shown.
    fn without(&self, out: &[usize]) -> (System, Vec<Accepted>) {
        let mut model = self.selected.system.model.clone();
        let mut kept = self.selected.accepted.clone();
        for &i in out.iter().rev() {
            model.terms.remove(self.fixed + i);
            kept.remove(i);
        }
        (self.data.fit(model), kept)
    }

    fn has_misfit(&self, joints: &[usize]) -> bool {
        joints.iter().any(|&j| self.selected.system.has_misfit(&[j]))
    }

    /// Whether one of these joints has so many effects that they imitate something: no exchange of one or two of them makes an
    /// account of that, and every try costs a fit and a scan.
    fn imitates(&self, joints: &[usize]) -> bool {
        let model = &self.selected.system.model;
        joints.iter().any(|&j| model.effects_on(j) > self.threshold.most_per_joint)
    }

    /// Candidates on joints such as these.
    fn on(&self, wanted: impl Fn(&[usize]) -> bool) -> Vec<Candidate> {
        let joints = self.joints();
        let of = |c: &&Candidate| wanted(&reach(c, joints));
        self.candidates.iter().filter(of).cloned().collect()
    }

    /// Two effects in the place of one that leaves a misfit on its joints: where it leaves none, two are no better account.
    fn two_for(&self, one: usize) -> Option<(System, Vec<Accepted>)> {
        let reached = self.reached(one);
        if !self.has_misfit(&reached) || self.imitates(&reached) {
            return None;
        }
        let (without, mut kept) = self.without(&[one]);
        let open = self.on(|joints| joints.iter().any(|j| reached.contains(j)));
        let scored = scan_on_grid(self.data, &without, &open);
        let pair = best_pair(self.data, &without, &open, &scored, self.threshold)?;
        kept.extend(pair.accepted);
        Some((pair.system, kept))
    }

    /// One effect in the place of two that share a joint and account for all that is there, of those that may explain as much.
    /// Where two leave a misfit and one does not, it takes the place of one of them, and the other goes.
    fn one_for(&self, two: &[usize]) -> Option<(System, Vec<Accepted>)> {
        let [a, b] = [self.reached(two[0]), self.reached(two[1])];
        let union = [&a[..], &b].concat();
        if !a.iter().any(|j| b.contains(j)) || self.has_misfit(&union) || self.imitates(&union) {
            return None;
        }
        let (without, kept) = self.without(two);
        // One of the two alone is among them: with another shape it may be all that is there.
        let open = self.on(|joints| joints.iter().any(|j| a.contains(j) && b.contains(j)));
        let loss = self.data.gain(&without, &self.selected.system);
        let mut scored: Vec<Scored> = scan_on_grid(self.data, &without, &open);
        let joints = self.joints();
        scored
            .retain(|s| s.gain > SETTINGS.selection.linear_gain * loss && s.could_settle(&without, &reach(&s.candidate, joints)));
        scored.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        scored.truncate(SETTINGS.selection.pair_seconds);
        let judged = |s: &Scored| {
            let there = fitted(self.data, &without, s);
            let at = there.system.model.terms.len() - 1;
            if there.system.has_misfit(&reach(&s.candidate, joints)) {
                return None;
            }
            let tried = hypotheses(self.candidates, s.candidate.effect.code());
            let accepted = judge(self.data, &without, &there.scored, &there.system, at, self.threshold, tried)?;
            Some((there.system, accepted))
        };
        let score = |found: &(System, Accepted)| score_of(self.data, &found.0, self.candidates, self.fixed);
        let best = scored.iter().filter_map(judged).max_by(|a, b| score(a).total_cmp(&score(b)));
        let (system, accepted) = best?;
        Some((system, kept.into_iter().chain([accepted]).collect()))
    }
}
