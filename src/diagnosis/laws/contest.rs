//! Which law, or which listed effect after all, is the best account beside a model.

use super::library::{Hypothesis, acts_on};
use super::physics::is_physical_law;
use crate::diagnosis::selection::{
    Accepted, Candidate, Fitted, Scored, Threshold, best_on_grid, fitted, hypotheses, judge, refine, scan,
};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::law::{LawForm, is_law};
use crate::regression::{Data, System};
use rayon::prelude::*;

/// A law or a listed effect, fitted beside the model.
pub(super) struct Contender {
    pub fit: Fitted,
    /// By one yardstick for all that were fitted.
    pub evidence: f64,
}

impl Contender {
    pub fn is_law(&self) -> bool {
        is_law(&self.fit.scored.candidate.effect)
    }

    fn cost(&self) -> usize {
        self.fit.scored.cost
    }
}

/// The best laws on `rows` and listed effects beside `system`, fitted, the best evidence first.
pub(super) fn contenders(
    data: &Data,
    system: &System,
    library: &[Hypothesis],
    known: &[Candidate],
    rows: &[usize],
) -> Vec<Contender> {
    let joints = system.model.robot.joint_count();
    let mut laws: Vec<Scored> = library
        .par_iter()
        .filter(|h| acts_on(&h.candidate, rows, joints))
        .filter_map(|h| best_on_grid(data, system, &h.candidate, h.tried))
        .collect();
    by_evidence(&mut laws);
    laws.truncate(SETTINGS.laws.shortlist);
    let mut laws: Vec<Scored> = laws.par_iter().map(|s| refine(data, system, s)).collect();
    by_evidence(&mut laws);
    laws.truncate(SETTINGS.laws.fitted);
    let mut listed = scan(data, system, known);
    // As laws pay for the choice among them, listed effects do.
    let choice = 2.0 * (2.0 * known.len().max(1) as f64).ln();
    listed.iter_mut().for_each(|s| s.evidence -= choice);
    listed.truncate(SETTINGS.laws.known);
    let open: Vec<Scored> = laws.into_iter().chain(listed).filter(|s| s.evidence > 0.0).collect();
    let fits: Vec<Fitted> = open
        .par_iter()
        .with_max_len(1)
        .map(|s| {
            let mut fit = fitted(data, system, s);
            fit.scored.evidence -= if is_law(&s.candidate.effect) { 0.0 } else { choice };
            fit
        })
        .collect();
    let evidences: Vec<f64> = fits
        .iter()
        .map(|f| f.scored.held_against(fits.iter().map(|o| &o.scored)).1)
        .collect();
    let mut all: Vec<Contender> = fits
        .into_iter()
        .zip(evidences)
        .map(|(fit, evidence)| Contender { fit, evidence })
        .collect();
    all.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    all
}

fn by_evidence(scored: &mut [Scored]) {
    scored.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
}

/// The order in which contenders are tried: of those that the best does not exclude listed effects first, then the simplest
/// formulas, then by evidence.
pub(super) fn preferred(contenders: &[Contender]) -> Vec<usize> {
    let best = contenders.first().map_or(0.0, |c| c.evidence);
    let tied = |i: &usize| contenders[*i].evidence > best - SETTINGS.alternatives.not_excluded;
    let (mut near, far): (Vec<usize>, Vec<usize>) = (0..contenders.len()).partition(tied);
    near.sort_by_key(|&i| (contenders[i].is_law(), contenders[i].cost()));
    near.into_iter().chain(far).collect()
}

/// What a contender has shown, if it has earned its place beside `before`.
pub(super) fn accepted(
    data: &Data,
    before: &System,
    contender: &Contender,
    known: &[Candidate],
    threshold: &Threshold,
) -> Option<Accepted> {
    let Fitted { scored, system } = &contender.fit;
    let at = system.model.terms.len() - 1;
    if contender.is_law() && !is_physical_law(data, system, at) {
        return None;
    }
    let tried = match contender.is_law() {
        true => scored.tried as f64,
        false => hypotheses(known, scored.candidate.effect.code()),
    };
    judge(data, before, scored, system, at, threshold, tried)
}

/// Whether `wide` is the formula of `narrow` with one more constant.
pub(super) fn contains(wide: &Candidate, narrow: &Candidate) -> bool {
    is_law(&wide.effect)
        && is_law(&narrow.effect)
        && wide.joints == narrow.joints
        && LawForm::numbered(wide.form).contains(LawForm::numbered(narrow.form))
}
