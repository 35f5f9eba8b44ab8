//! The search for laws: forward steps, exchanges, and what must be left clean in the end.

use super::contest::{accepted, contenders, preferred};
use super::library::{Hypothesis, is_of, library};
use crate::diagnosis::nonparametric::excess;
use crate::diagnosis::selection::{Accepted, Candidate, Selected, Threshold, drop_superfluous, extend};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::law::is_law;
use crate::regression::{AugmentedModel, Data, System, Term, spans};

/// The selection with laws for what `examined` leaves, or in the place of listed effects that imitate one, and whatever listed
/// effects can be seen beside them; `None` where no law earns its place.
pub(crate) fn written(data: &Data, examined: &Selected, known: &[Candidate], threshold: &Threshold) -> Option<Selected> {
    if !examined.system.noise_is_measured {
        return None;
    }
    let added = added(data, examined, known, threshold);
    let now = added.as_ref().unwrap_or(examined);
    let instead = instead_of_listed(data, now, known, threshold);
    Some(extend(data, instead.or(added)?, known, threshold))
}

/// Laws beside the effects of `examined`, for what they leave.
fn added(data: &Data, examined: &Selected, known: &[Candidate], threshold: &Threshold) -> Option<Selected> {
    let search = Search::new(data, &examined.system, known, threshold)?;
    let start = search.begun(examined, examined.system.model.clone(), examined.accepted.clone());
    search.clean(&examined.system, search.found(start))
}

/// Laws in the place of the effects that were accepted. A weak law over two joints looks like a crosstalk, a spring and an
/// offset, each of which explains a part of it, and what they leave together is too little for a search that continues from
/// there. So laws and listed effects begin once more, side by side, and the account with laws stays where it is the better one by
/// more than what would make the other its rival.
fn instead_of_listed(data: &Data, now: &Selected, known: &[Candidate], threshold: &Threshold) -> Option<Selected> {
    let terms = &now.system.model.terms[now.fixed..];
    if terms.iter().all(|t| is_law(&t.effect)) {
        return None;
    }
    let mut declared = now.system.model.clone();
    declared.terms.truncate(now.fixed);
    let without = data.fit(declared);
    let search = Search::new(data, &without, known, threshold)?;
    let forward = search.forward(search.begun(now, without.model.clone(), Vec::new()));
    if !forward.system.model.terms[now.fixed..].iter().any(|t| is_law(&t.effect)) {
        return None;
    }
    let other = search.clean(&without, search.improved(forward))?;
    let score = |s: &Selected| search.score(&s.system, s.fixed);
    (score(&other) - score(now) > SETTINGS.laws.exchange).then_some(other)
}

/// χ² of a joint above its mean that noise alone has once in forty logs, at two standard deviations: a law of one column that is
/// large enough to be named is far smaller than what the sum over all rows shows beyond doubt, and every law has tests of its
/// own.
fn noise_of(system: &System, joint: usize) -> f64 {
    SETTINGS.laws.suspicious * (2.0 * system.rows(joint) as f64).sqrt()
}

/// Joints that may keep more than noise.
fn suspicious(system: &System) -> Vec<usize> {
    let joints = 0..system.model.robot.joint_count();
    joints
        .filter(|&j| system.rows(j) > 0 && excess(system, j) > noise_of(system, j))
        .collect()
}

/// What all steps of a search share.
struct Search<'a> {
    data: &'a Data<'a>,
    hypotheses: Vec<Hypothesis>,
    known: &'a [Candidate],
    threshold: &'a Threshold,
}

impl<'a> Search<'a> {
    /// The search for what `system` leaves; `None` where that is noise on all joints.
    fn new(data: &'a Data<'a>, system: &System, known: &'a [Candidate], threshold: &'a Threshold) -> Option<Self> {
        let rows = suspicious(system);
        (!rows.is_empty()).then(|| Self {
            hypotheses: library(&system.model.robot, data, &spans(data.stretches), &rows),
            data,
            known,
            threshold,
        })
    }

    /// What a search begins with: `model` in the place of that of `selected`.
    fn begun(&self, selected: &Selected, model: AugmentedModel, accepted: Vec<Accepted>) -> Selected {
        Selected {
            system: self.data.linearise(model),
            accepted,
            noise: self.data.noise.clone(),
            given_up: false,
            ..*selected
        }
    }

    /// Forward steps, then exchanges.
    fn found(&self, start: Selected) -> Selected {
        self.improved(self.forward(start))
    }

    /// Exchanges as long as one is the better account.
    fn improved(&self, mut now: Selected) -> Selected {
        for _ in 0..SETTINGS.laws.rounds {
            let (there, changed) = self.exchanged(now);
            now = there;
            if !changed {
                break;
            }
        }
        now
    }

    /// Adds laws and listed effects as long as something is left and one earns its place.
    fn forward(&self, mut now: Selected) -> Selected {
        let first = now.accepted.len();
        while now.accepted.len() < first + SETTINGS.laws.most {
            let rows = suspicious(&now.system);
            let Some((system, accepted)) = self.step(&now.system, &rows) else {
                break;
            };
            now.system = system;
            now.accepted.push(accepted);
            drop_superfluous(self.data, &mut now, self.known, self.threshold);
        }
        now
    }

    /// The best that earns its place beside `system`, on joints of `rows`.
    fn step(&self, system: &System, rows: &[usize]) -> Option<(System, Accepted)> {
        if rows.is_empty() {
            return None;
        }
        let mut all = contenders(self.data, system, &self.hypotheses, self.known, rows);
        let judged = |i: usize| Some((i, accepted(self.data, system, &all[i], self.known, self.threshold)?));
        let (at, accepted) = preferred(&all).into_iter().find_map(judged)?;
        Some((all.swap_remove(at).fit.system, accepted))
    }

    /// Every law taken out in turn, alone and with the other laws on its joints: what stands better in its place takes it.
    fn exchanged(&self, mut now: Selected) -> (Selected, bool) {
        let mut changed = false;
        for out in self.groups(&now) {
            if let Some(better) = self.exchange(&now, &out) {
                now = better;
                changed = true;
                break;
            }
        }
        (now, changed)
    }

    /// Numbers of effects that are taken out together: all laws that act on one joint or are of the same joints, where there are
    /// several, then each alone. A seal over two joints comes as two laws, each with the speed of the other.
    fn groups(&self, now: &Selected) -> Vec<Vec<usize>> {
        let terms = &now.system.model.terms[now.fixed..];
        let laws: Vec<usize> = (0..terms.len()).filter(|&i| is_law(&terms[i].effect)).collect();
        let acts = |i: usize| terms[i].effect.acts_on(terms[i].form, &terms[i].joints);
        let mut groups: Vec<Vec<usize>> = (0..now.system.model.robot.joint_count())
            .map(|j| laws.iter().copied().filter(|&i| acts(i).contains(&j)).collect::<Vec<_>>())
            .filter(|g| g.len() > 1)
            .collect();
        let joints = |i: usize| {
            let mut all = terms[i].joints.clone();
            all.sort_unstable();
            all
        };
        for &i in &laws {
            let alike: Vec<usize> = laws.iter().copied().filter(|&k| joints(k) == joints(i)).collect();
            if alike.len() > 1 && !groups.contains(&alike) {
                groups.push(alike);
            }
        }
        groups.dedup();
        groups.extend(laws.iter().map(|&i| vec![i]));
        groups
    }

    /// The selection with one effect in the place of those in `out`, if it is the better account.
    fn exchange(&self, now: &Selected, out: &[usize]) -> Option<Selected> {
        let mut model = now.system.model.clone();
        let mut kept = now.accepted.clone();
        let mut rows: Vec<usize> = Vec::new();
        for &i in out.iter().rev() {
            let term = model.terms.remove(now.fixed + i);
            rows.extend(term.acts_on());
            kept.remove(i);
        }
        let without = self.data.fit(model);
        let (system, accepted) = self.step(&without, &rows)?;
        let gained = self.score(&system, now.fixed) - self.score(&now.system, now.fixed);
        (gained > SETTINGS.laws.exchange).then(|| {
            kept.push(accepted);
            Selected {
                system,
                accepted: kept,
                noise: now.noise.clone(),
                ..*now
            }
        })
    }

    /// Minus the sum of squares less what the laws and effects cost: differences are twice the log of an evidence ratio.
    fn score(&self, system: &System, fixed: usize) -> f64 {
        let rows: usize = (0..system.model.robot.joint_count()).map(|j| system.rows(j)).sum();
        let price = |t: &Term| t.parameters() as f64 * (rows as f64).ln() + 2.0 * (self.choice(t) as f64).ln();
        -self.data.chi_square(system) - system.model.terms[fixed..].iter().map(price).sum::<f64>()
    }

    /// How many a term was chosen from.
    fn choice(&self, term: &Term) -> usize {
        let own = self.hypotheses.iter().find(|h| is_of(&h.candidate, term));
        own.map_or(2 * self.known.len().max(1), |h| h.tried)
    }

    /// Without the laws on joints that keep more than a share of what they had; `None` where none is left.
    fn clean(&self, before: &System, mut now: Selected) -> Option<Selected> {
        let fixed = now.fixed;
        loop {
            let keeps = |j: usize| {
                excess(&now.system, j) > noise_of(&now.system, j) + SETTINGS.laws.most_left * excess(before, j).max(0.0)
            };
            let terms = &now.system.model.terms;
            let law = |t: &Term| is_law(&t.effect);
            let dirty = (fixed..terms.len()).rev().find(|&at| {
                let t = &terms[at];
                law(t) && t.acts_on().iter().any(|&j| keeps(j))
            });
            match dirty {
                Some(at) => {
                    let mut model: AugmentedModel = now.system.model.clone();
                    model.terms.remove(at);
                    now.accepted.remove(at - fixed);
                    now.system = self.data.fit(model);
                }
                None => return terms[fixed..].iter().any(law).then_some(now),
            }
        }
    }
}
