//! The search for effects, and the last word on each of them, by all samples.
//!
//! Effects are looked for on the coarse forms of the data, one sample of the motion to every row. Of long logs that is a tenth of
//! the samples and less, while so many rows see what a hundredth of the noise hides: what only the coarse form needs is not an
//! effect of the robot.

use crate::diagnosis::alternatives::{Contest, rivals, settled};
use crate::diagnosis::laws::{law_contests, written};
use crate::diagnosis::nonparametric::{examine, unaccounted};
use crate::diagnosis::report::Remainder;
use crate::diagnosis::selection::{Accepted, Candidate, Selected, Threshold, doubt, extend, select};
use crate::effects::law::is_law;
use crate::regression::{AugmentedModel, Data, System, Term};

/// What a search ends with.
pub(crate) struct Searched<'a> {
    /// All samples, with the noise that the search ended with.
    pub data: Data<'a>,
    /// Fitted to them.
    pub system: System,
    /// Terms before the effects: those that the search began with, then nuisance offsets.
    pub fixed: usize,
    pub accepted: Vec<Accepted>,
    /// One per effect of `accepted`.
    pub contests: Vec<Contest>,
    pub remainder: Option<Remainder>,
}

/// Selects on the coarse forms, confirms by all samples, and goes on without the effects that were not confirmed, because they
/// may have stood where another belongs. One of those before them may be that other, so it has a second turn, and no third: the
/// search ends.
pub(crate) fn searched<'a>(
    coarse: &Data,
    fine: &Data<'a>,
    start: AugmentedModel,
    candidates: &[Candidate],
    threshold: &Threshold,
) -> Searched<'a> {
    let mut open = candidates.to_vec();
    let mut turned_down = TurnedDown::default();
    let mut selected = select(coarse, start, &open, threshold);
    // Rivals cost far more than a fit to all samples, which without periods turns most down.
    while !selected.system.noise_is_measured {
        let confirmed = confirmed(&fine.with_noise(selected.noise.clone()), &selected, threshold.chance);
        if confirmed.gone.is_empty() {
            break;
        }
        open = turned_down.open(candidates, &confirmed.gone);
        let data = coarse.with_noise(selected.noise.clone());
        selected = extend(&data, confirmed.left_of(&data, selected), &open, threshold);
    }
    // A law that the samples do not confirm would be found again.
    let mut may_have_laws = true;
    loop {
        let fixed = selected.fixed;
        let (settled, mut contests) = settled(coarse, selected, fixed, &open, threshold);
        let data = coarse.with_noise(settled.noise.clone());
        let (mut examined, mut remainder) = examine(&data, settled, fixed, &open, threshold);
        // What no effect explains may have a law.
        let law = may_have_laws.then(|| written(&data, &examined, &open, threshold)).flatten();
        if let Some(law) = law {
            (examined, remainder) = examine(&data, law, fixed, &open, threshold);
        }
        let laws = examined.system.model.terms.iter().any(|t| is_law(&t.effect));
        // Without measured noise a remainder takes effects back or changes nothing.
        let taken_back = remainder.is_some() && examined.system.noise_is_measured;
        if laws || taken_back || examined.accepted.len() != contests.len() || open.len() < candidates.len() {
            contests = rivals(&data, &examined, fixed, candidates, threshold);
            for (at, contest) in law_contests(&data, &examined, &open, threshold) {
                contests[at] = contest;
            }
        }
        let fine = fine.with_noise(examined.noise.clone());
        let confirmed = confirmed(&fine, &examined, threshold.chance);
        if confirmed.gone.is_empty() || remainder.is_some() {
            return Searched {
                remainder: remainder.or_else(|| unaccounted(&fine, &confirmed.system)),
                data: fine,
                fixed,
                accepted: confirmed.of(&examined.accepted),
                contests: confirmed.of(&contests),
                system: confirmed.system,
            };
        }
        may_have_laws &= !confirmed.gone.iter().any(|t| is_law(&t.effect));
        open = turned_down.open(candidates, &confirmed.gone);
        selected = extend(&data, confirmed.left_of(&data, examined), &open, threshold);
    }
}

/// Effects that all samples did not confirm.
#[derive(Default)]
struct TurnedDown(Vec<Term>);

impl TurnedDown {
    /// Adds those turned down just now, and says which of the candidates may come next: those of earlier turns once more.
    fn open(&mut self, candidates: &[Candidate], now: &[Term]) -> Vec<Candidate> {
        let times = |c: &Candidate, list: &[Term]| list.iter().filter(|t| c.is_same_effect(t)).count();
        let may_come = |c: &&Candidate| times(c, now) == 0 && times(c, &self.0) < 2;
        let open = candidates.iter().filter(may_come).cloned().collect();
        self.0.extend_from_slice(now);
        open
    }
}

/// Effects of a selection that all samples confirm, and those that they do not.
struct Confirmed {
    /// Fitted to all samples, without those that went.
    system: System,
    /// Which effects of the selection stayed.
    kept: Vec<usize>,
    gone: Vec<Term>,
}

impl Confirmed {
    /// What belongs to the effects that stayed.
    fn of<T: Clone>(&self, all: &[T]) -> Vec<T> {
        self.kept.iter().map(|&i| all[i].clone()).collect()
    }

    /// The selection with the effects that stayed, fitted to `data`.
    fn left_of(&self, data: &Data, selected: Selected) -> Selected {
        Selected {
            system: data.fit(self.system.model.clone()),
            accepted: self.of(&selected.accepted),
            ..selected
        }
    }
}

/// Takes effects of a selection out that the samples of `data` do not confirm, the weakest first, until all that are left are:
/// the chance of `θᵀ C⁻¹ θ` (Wald), θ what the effect adds and C its covariance, is below `limit`. What was tried before is not
/// counted again.
fn confirmed(data: &Data, selected: &Selected, limit: f64) -> Confirmed {
    let mut found = Confirmed {
        system: data.fit(selected.system.model.clone()),
        kept: (0..selected.accepted.len()).collect(),
        gone: Vec::new(),
    };
    loop {
        let doubts = (0..found.kept.len()).map(|i| (i, doubt(&found.system, selected.fixed + i)));
        match doubts.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((i, p)) if p >= limit => {
                found.kept.remove(i);
                let mut model = found.system.model;
                found.gone.push(model.terms.remove(selected.fixed + i));
                found.system = data.fit(model);
            }
            _ => return found,
        }
    }
}
