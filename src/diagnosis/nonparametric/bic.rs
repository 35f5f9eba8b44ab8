//! What effects and smooth functions cost, and which of them account for the data at the lower price.

use super::matching_pursuit::{function_jobs, left_over, with_functions};
use crate::diagnosis::selection::{Candidate, Scored, Selected};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{Data, System, Term};

/// Smooth functions on top of the first effects: score, how many effects those are, and the model.
type WithFunctions = (f64, usize, System);

/// The best of as many first effects as are kept at most.
pub(crate) fn best_with_functions(
    data: &Data,
    selected: &Selected,
    fixed: usize,
    candidates: &[Candidate],
) -> Option<WithFunctions> {
    let count = selected.accepted.len();
    // One effect that leaves nothing has no imitations to be suspected of; several small ones may have shared out what is one
    // thing. Where nothing is left above the noise of any joint, effects alone are enough.
    let full = if count <= SETTINGS.nonparametric.effects_beside {
        beside(data, selected, fixed, count, candidates)
    } else {
        None
    };
    if full.is_none() && count <= 1 {
        return None;
    }
    let fewer = (0..=SETTINGS.nonparametric.effects_beside)
        .rev()
        .filter(|&k| k < count && could_pay(data, selected, fixed, k, candidates));
    best_of(
        full.into_iter()
            .chain(fewer.filter_map(|k| beside(data, selected, fixed, k, candidates))),
    )
}

/// Whether functions beside the first `k` effects can be the cheaper account at all. Where the effects leave nothing above the
/// noise, no function leaves less that is worth its price; then there must be a function to every two joints on which the first
/// `k` leave something, of one product at least.
fn could_pay(data: &Data, selected: &Selected, fixed: usize, k: usize, candidates: &[Candidate]) -> bool {
    if !left_over(data, &selected.system).is_empty() {
        return true;
    }
    let fewer = prefix(data, selected, fixed + k);
    let rows = all_rows(&fewer) as f64;
    let functions = left_over(data, &fewer).len().div_ceil(2) as f64;
    let each = rows.ln() + 2.0 * SETTINGS.nonparametric.dictionary.ln() + choice_of_function(&fewer);
    let least = price_of(&fewer, candidates, fixed) + functions * each;
    functions > 0.0 && least + SETTINGS.nonparametric.preference < price_of(&selected.system, candidates, fixed)
}

/// Twice the log of the functions that one is chosen from.
fn choice_of_function(system: &System) -> f64 {
    2.0 * (function_jobs(system.model.robot.joint_count(), &[0]).len() as f64).ln()
}

fn best_of(scored: impl Iterator<Item = WithFunctions>) -> Option<WithFunctions> {
    scored.reduce(|best, s| if s.0 > best.0 { s } else { best })
}

/// Smooth functions on top of the first `k` effects, if there is anything for them.
fn beside(data: &Data, selected: &Selected, fixed: usize, k: usize, candidates: &[Candidate]) -> Option<WithFunctions> {
    let made = || match k == selected.accepted.len() {
        true => with_functions(data, &selected.system),
        false => with_functions(data, &prefix(data, selected, fixed + k)),
    };
    let model = match k {
        0 => data.alone.get(|| made().map(|s| s.model)).clone(),
        _ => made().map(|s| s.model),
    }?;
    let system = data.linearise(model);
    Some((score_of(data, &system, candidates, fixed), k, system))
}

/// Whether a search for effects is worth going on with. What no effect explains is imitated by many, one after the other, and
/// each makes the next more costly to find; at the end smooth functions take their place all the same.
#[derive(Default)]
pub(crate) struct Rivalling(Option<f64>);

impl Rivalling {
    /// Whether smooth functions, with what they leave, are cheaper than the effects found and as many more as explain what is
    /// left, if each of these costs least and gains as much as the best of `scored`, what could come next: then no effects turn
    /// the balance. Functions are tried once, when there are more effects than are kept beside functions: alone, and with as
    /// many.
    pub fn functions_are_cheaper(
        &mut self,
        data: &Data,
        now: &Selected,
        fixed: usize,
        candidates: &[Candidate],
        scored: &[Scored],
    ) -> bool {
        if now.accepted.len() <= SETTINGS.nonparametric.effects_beside || !now.system.noise_is_measured {
            return false;
        }
        let left = |system: &System| (data.chi_square(system) - all_rows(system) as f64).max(0.0);
        let functions = *self.0.get_or_insert_with(|| {
            let tried = [SETTINGS.nonparametric.effects_beside, 0]
                .into_iter()
                .filter_map(|k| beside(data, now, fixed, k, candidates));
            best_of(tried).map_or(f64::INFINITY, |(_, _, with)| price_of(&with, candidates, fixed) + left(&with))
        });
        let gain = scored
            .iter()
            .map(|s| s.gain / SETTINGS.selection.linear_gain)
            .fold(f64::MIN_POSITIVE, f64::max);
        let more = (left(&now.system) / gain).ceil() * cheapest(&now.system, candidates);
        price_of(&now.system, candidates, fixed) + more > functions + SETTINGS.nonparametric.preference
    }
}

/// What an effect costs at least: one parameter, and the choice among all.
fn cheapest(system: &System, candidates: &[Candidate]) -> f64 {
    (all_rows(system) as f64).ln() + 2.0 * (candidates.len() as f64).ln()
}

/// The model with only its first `terms` terms, fitted.
fn prefix(data: &Data, selected: &Selected, terms: usize) -> System {
    let mut model = selected.system.model.clone();
    model.terms.truncate(terms);
    data.fit(model)
}

/// Minus the sum of squares, less what parameters and shapes tried cost: differences are twice the log of an evidence ratio.
pub(crate) fn score_of(data: &Data, system: &System, candidates: &[Candidate], fixed: usize) -> f64 {
    // Rows at reversals come and go with a distortion: each is expected to leave one.
    all_rows(system) as f64 - data.chi_square(system) - price_of(system, candidates, fixed)
}

fn all_rows(system: &System) -> usize {
    (0..system.model.robot.joint_count()).map(|j| system.rows(j)).sum()
}

/// What the terms beyond the first `fixed` cost: their parameters, and what each was chosen from.
fn price_of(system: &System, candidates: &[Candidate], fixed: usize) -> f64 {
    let rows = all_rows(system) as f64;
    // Which effect, or which function and products, is a choice as well: it costs the log of their number.
    let price = |term: &Term| {
        let own = candidates.iter().find(|c| c.is_same_effect(term) && c.form == term.form);
        let choice = match own {
            Some(candidate) => candidate.grid().len() as f64 * candidates.len() as f64,
            None => function_jobs(system.model.robot.joint_count(), &[0]).len() as f64,
        };
        let each = if own.is_none() {
            2.0 * (term.coefficients.len() as f64) * SETTINGS.nonparametric.dictionary.ln()
        } else {
            0.0
        };
        term.parameters() as f64 * rows.ln() + 2.0 * choice.ln() + each
    };
    system.model.terms[fixed..].iter().map(price).sum()
}
