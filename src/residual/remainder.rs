//! What no effect explains, and what it depends on.
//!
//! Smooth functions of one or two variables stand in for the unknown cause. They compete with the effects found: where the effects leave
//! structure that such a function catches, and the function with fewer effects accounts for the data better than the effects alone, the
//! effects were imitations, and are taken back.

use super::candidate::{Candidate, LINEAR_GAIN, Scored, chance, hypotheses};
use super::projection::{Thinned, reduce};
use super::select::{Selected, Threshold};
use super::system::{Data, System};
use super::{AugmentedModel, Remainder, Stretch, Term};
use crate::dynamics::Coulomb;
use crate::effects::{Effect, Scene, Unexplained, products, variable, variable_name};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// A smooth dependence tried on one joint's row.
#[derive(Clone)]
struct Smooth {
    term: Term,
    gain: f64,
    evidence: f64,
}

/// Products of functions in one smooth dependence: matching pursuit stops earlier when the next does not pay.
const MOST_PRODUCTS: usize = 10;
/// Effects that name a cause are preferred to a function that does not, unless the odds are 20 000 to 1 (2 ln of that).
pub(super) const PREFERENCE: f64 = 20.0;
/// Share of the noise of a single measurement below which a remainder is nothing to act on, and may come from the positions.
pub(super) const LEAST_SIZE: f64 = 0.2;
const MOST_FUNCTIONS: usize = 3;

/// The selection with imitations taken back, and the remainder if there is one.
pub(crate) fn examine(
    data: &Data,
    selected: Selected,
    fixed: usize,
    candidates: &[Candidate],
    threshold: &Threshold,
) -> (Selected, Option<Remainder>) {
    // Without measured noise nobody knows whether anything is left.
    if !selected.system.noise_is_measured {
        return (selected, None);
    }
    let start = score_of(data, &selected.system, candidates, fixed);
    match best_with_functions(data, &selected, fixed, candidates) {
        Some((score, k, system)) if score > start + PREFERENCE => {
            withdraw(data, selected, fixed, k, system, candidates, threshold)
        }
        _ => (selected, None),
    }
}

/// Smooth functions on top of the first effects: score, how many effects those are, and the model.
type WithFunctions = (f64, usize, System);

/// The best of as many first effects as are kept at most.
fn best_with_functions(data: &Data, selected: &Selected, fixed: usize, candidates: &[Candidate]) -> Option<WithFunctions> {
    let count = selected.accepted.len();
    // One effect that leaves nothing has no imitations to be suspected of; several small ones may have shared out what is one thing. Where
    // nothing is left above the noise of any joint, effects alone are enough.
    let full = if count <= MOST_BESIDE {
        beside(data, selected, fixed, count, candidates)
    } else {
        None
    };
    if full.is_none() && count <= 1 {
        return None;
    }
    let fewer = (0..=MOST_BESIDE).rev().filter(|&k| k < count);
    best_of(
        full.into_iter()
            .chain(fewer.filter_map(|k| beside(data, selected, fixed, k, candidates))),
    )
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
        0 => data.alone.get_or_init(|| made().map(|s| s.model)).clone(),
        _ => made().map(|s| s.model),
    }?;
    let system = data.linearise(model);
    Some((score_of(data, &system, candidates, fixed), k, system))
}

/// Effects that are kept beside smooth functions at most.
const MOST_BESIDE: usize = 3;

/// Whether a search for effects is worth going on with. What no effect explains is imitated by many, one after the other, and each makes the next more
/// costly to find; at the end smooth functions take their place all the same.
#[derive(Default)]
pub(super) struct Rivalling(Option<f64>);

impl Rivalling {
    /// Whether smooth functions, with what they leave, are cheaper than the effects found and as many more as explain what is left, if each of these
    /// costs least and gains as much as the best of `scored`, what could come next: then no effects turn the balance. Functions are tried once, when there
    /// are more effects than are kept beside functions: alone, and with as many.
    pub fn functions_are_cheaper(
        &mut self,
        data: &Data,
        now: &Selected,
        fixed: usize,
        candidates: &[Candidate],
        scored: &[Scored],
    ) -> bool {
        if now.accepted.len() <= MOST_BESIDE || !now.system.noise_is_measured {
            return false;
        }
        let left = |system: &System| (data.chi_square(system) - all_rows(system) as f64).max(0.0);
        let functions = *self.0.get_or_insert_with(|| {
            let tried = [MOST_BESIDE, 0]
                .into_iter()
                .filter_map(|k| beside(data, now, fixed, k, candidates));
            best_of(tried).map_or(f64::INFINITY, |(_, _, with)| price_of(&with, candidates, fixed) + left(&with))
        });
        let gain = scored.iter().map(|s| s.gain / LINEAR_GAIN).fold(f64::MIN_POSITIVE, f64::max);
        let more = (left(&now.system) / gain).ceil() * cheapest(&now.system, candidates);
        price_of(&now.system, candidates, fixed) + more > functions + PREFERENCE
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
fn score_of(data: &Data, system: &System, candidates: &[Candidate], fixed: usize) -> f64 {
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
            2.0 * (term.coefficients.len() as f64) * DICTIONARY.ln()
        } else {
            0.0
        };
        term.parameters() as f64 * rows.ln() + 2.0 * choice.ln() + each
    };
    system.model.terms[fixed..].iter().map(price).sum()
}

/// Adds smooth functions while they earn their place; `None` when not even one does.
fn with_functions(data: &Data, system: &System) -> Option<System> {
    let mut now: Option<System> = None;
    for _ in 0..MOST_FUNCTIONS {
        let here = now.as_ref().unwrap_or(system);
        let Some(best) = best_function(data, here) else { break };
        let mut model: AugmentedModel = here.model.clone();
        model.terms.push(best.term);
        now = Some(data.fit(model));
    }
    now
}

/// The smooth function with the best evidence, if it is beyond chance, on joints whose χ² is five standard deviations above its mean: the
/// noise's own correlation is an estimate.
fn best_function(data: &Data, system: &System) -> Option<Smooth> {
    let n = system.model.robot.joint_count();
    let excess = |j: usize| system.joint_chi_square(j) - system.rows(j) as f64 + system.spent(j);
    // Five standard deviations of χ², because the noise's own correlation is an estimate.
    let repetitions = data.stretches.iter().map(Stretch::repetitions).max().unwrap_or(1) as f64;
    let least = |j: usize| {
        (5.0 * (2.0 * system.rows(j) as f64).sqrt()).max(LEAST_SIZE * LEAST_SIZE * repetitions * system.rows(j) as f64)
    };
    let mut rows: Vec<usize> = (0..n).filter(|&j| excess(j) > least(j)).collect();
    rows.sort_by(|&a, &b| excess(b).total_cmp(&excess(a)));
    rows.truncate(3);
    let jobs = function_jobs(n, &rows);
    let scored: Vec<Smooth> = jobs
        .par_iter()
        .filter_map(|job| score(data, system, job, jobs.len() as f64))
        .collect();
    let best = scored.iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence))?.clone();
    // Each product was the best of a dictionary, the function the best of all jobs.
    let products = best.term.coefficients.len();
    let beyond_chance =
        chance(best.gain, products).ln() + products as f64 * DICTIONARY.ln() + (jobs.len() as f64).ln() < 1e-3f64.ln();
    let share = best.gain > 0.05 * excess(best.term.joints[0]);
    (best.evidence > PREFERENCE && beyond_chance && share).then_some(best)
}

/// Rows and variables tried: every position, speed and the load; pairs of positions; a position or the load with the joint's own speed.
fn function_jobs(n: usize, rows: &[usize]) -> Vec<Vec<usize>> {
    let mut jobs = Vec::new();
    for &row in rows {
        jobs.extend((0..2 * n).chain([2 * n + row]).map(|v| vec![row, v]));
        jobs.extend((0..n).flat_map(|a| (a + 1..n).map(move |b| vec![row, a, b])));
        jobs.extend((0..n).chain([2 * n + row]).map(|a| vec![row, a, n + row]));
        // Two joints that act on each other: both rows, a function of both positions.
        jobs.extend(
            (0..n)
                .filter(|&other| other != row)
                .map(|other| vec![row, row.min(other), row.max(other), other]),
        );
    }
    jobs
}

/// Products that a function of two positions chooses from.
const DICTIONARY: f64 = 121.0;

/// One function, by matching pursuit over its products.
fn score(data: &Data, system: &System, job: &[usize], jobs: f64) -> Option<Smooth> {
    let codes = &job[1..job.len().min(3)];
    let mut shape = scaling(data, system, codes)?;
    let coarse: Vec<&Stretch> = data.stretches.iter().map(Stretch::coarse_form).collect();
    let columns: Vec<_> = coarse
        .iter()
        .zip(system.thinned(data))
        .map(|(stretch, e)| Unexplained.columns(0, &scene(system, stretch, e), job, &shape))
        .collect();
    let (own, rest, right) = system.projected(&system.whitened(data, &coarse, columns));
    let rows: usize = (0..system.model.robot.joint_count()).map(|j| system.rows(j)).sum();
    let count = products(codes, system.model.robot.joint_count()) * if job.len() > 3 { 2 } else { 1 };
    let price = (rows as f64).ln() + 2.0 * (count as f64).ln();
    let (chosen, gain, coefficients) = pursue(&own, &rest, &right, price);
    if chosen.is_empty() {
        return None;
    }
    let evidence = gain - chosen.len() as f64 * price - 2.0 * jobs.ln();
    shape.extend(chosen.iter().map(|&k| k as f64));
    let term = Term {
        effect: &Unexplained,
        form: 0,
        joints: job.to_vec(),
        coefficients: coefficients.as_slice().to_vec(),
        shape,
        free_shapes: 0,
        bounds: Vec::new(),
    };
    Some(Smooth { term, gain, evidence })
}

/// Takes the column that gains most beside those taken, until none pays its price.
fn pursue(own: &DMatrix<f64>, rest: &DMatrix<f64>, right: &DVector<f64>, price: f64) -> (Vec<usize>, f64, DVector<f64>) {
    let mut chosen: Vec<usize> = Vec::new();
    let mut best = (0.0, DVector::zeros(0));
    let with = |set: &[usize]| {
        let pick = |m: &DMatrix<f64>| DMatrix::from_fn(set.len(), set.len(), |r, c| m[(set[r], set[c])]);
        let target = DVector::from_fn(set.len(), |r, _| right[set[r]]);
        reduce(&pick(own), &pick(rest), &target)
    };
    while chosen.len() < MOST_PRODUCTS {
        let options = (0..own.nrows()).filter(|k| !chosen.contains(k)).map(|k| {
            let set: Vec<usize> = chosen.iter().copied().chain([k]).collect();
            (k, with(&set))
        });
        let Some((k, reduced)) = options.max_by(|a, b| a.1.gain.total_cmp(&b.1.gain)) else {
            break;
        };
        if reduced.gain - best.0 < price || reduced.rank <= chosen.len() {
            break;
        }
        chosen.push(k);
        best = (reduced.gain, reduced.coefficients);
    }
    (chosen, best.0, best.1)
}

fn scene<'a>(system: &'a System, stretch: &Stretch, e: &'a Thinned) -> Scene<'a> {
    Scene {
        robot: &system.model.robot,
        motion: &e.motion,
        rigid: &e.rigid,
        declared: &e.declared,
        interval: stretch.interval,
        periodic: stretch.periodic,
        coulomb: Coulomb::Sign,
    }
}

/// Centre and half range of every variable over all stretches; `None` for one that does not vary.
fn scaling(data: &Data, system: &System, codes: &[usize]) -> Option<Vec<f64>> {
    let mut shape = Vec::new();
    for &code in codes {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (stretch, e) in data.stretches.iter().map(Stretch::coarse_form).zip(system.thinned(data)) {
            for v in variable(&scene(system, stretch, e), code) {
                (low, high) = (low.min(v), high.max(v));
            }
        }
        // A variable that moves by less than a thousandth of a radian predicts nothing.
        if high - low < 1e-3 {
            return None;
        }
        shape.extend([0.5 * (low + high), 0.5 * (high - low)]);
    }
    Some(shape)
}

/// Keeps the effects that are still needed beside the functions, and says what the functions depend on.
fn withdraw(
    data: &Data,
    selected: Selected,
    fixed: usize,
    kept: usize,
    mut system: System,
    candidates: &[Candidate],
    threshold: &Threshold,
) -> (Selected, Option<Remainder>) {
    let mut accepted = selected.accepted[..kept].to_vec();
    for at in (0..kept).rev() {
        let mut model = system.model.clone();
        let term = model.terms.remove(fixed + at);
        let without = data.fit(model);
        let loss = data.gain(&without, &system);
        let needed = chance(loss, term.parameters()) * hypotheses(candidates, term.effect.code()) < threshold.chance
            && loss > SHARE_BESIDE * accepted[at].gain;
        if !needed {
            system = without;
            accepted.remove(at);
        }
    }
    let remainder = describe(data, &system, fixed + accepted.len());
    let mut model = system.model.clone();
    model.terms.truncate(fixed + accepted.len());
    (
        Selected {
            system: data.fit(model),
            accepted,
            noise: data.noise.clone(),
            given_up: selected.given_up,
        },
        Some(remainder),
    )
}

/// An effect that keeps less than this share of its gain beside a smooth function has been that function's stand-in.
const SHARE_BESIDE: f64 = 0.1;

fn describe(data: &Data, with: &System, from: usize) -> Remainder {
    let n = with.model.robot.joint_count();
    let mut plain = with.model.clone();
    let functions: Vec<Term> = plain.terms.drain(from..).collect();
    let without = data.fit(plain);
    let mut rows: Vec<usize> = functions
        .iter()
        .flat_map(|t| std::iter::once(t.joints[0]).chain(t.joints.get(3).copied()))
        .collect();
    let mut seen = std::collections::BTreeSet::new();
    rows.retain(|r| seen.insert(*r));
    let excess = |system: &System, j: usize| (system.joint_chi_square(j) - system.rows(j) as f64 + system.spent(j)).max(0.0);
    let total = |system: &System| rows.iter().map(|&j| excess(system, j)).sum::<f64>();
    let share = if total(&without) > 0.0 {
        1.0 - total(with) / total(&without)
    } else {
        0.0
    };
    let mut depends_on = Vec::new();
    for code in functions.iter().flat_map(|t| by_strength(data, &without, t)) {
        let name = variable_name(code, n);
        if !depends_on.contains(&name) {
            depends_on.push(name);
        }
    }
    let joints: Vec<String> = rows.iter().map(|&j| with.model.robot.joints()[j].name.clone()).collect();
    let rms = rows.iter().map(|&j| rms_above_noise(data, &without, j)).collect();
    let note = format!(
        "no effect known here explains what is left on {}; a smooth function of {} predicts {:.0} % of it",
        joints.join(", "),
        depends_on.join(" and "),
        100.0 * share.clamp(0.0, 1.0)
    );
    Remainder {
        joints,
        depends_on,
        predicted_share: share.clamp(0.0, 1.0),
        rms,
        note,
    }
}

/// Variables of a function, the one that predicts more alone first.
fn by_strength(data: &Data, without: &System, term: &Term) -> Vec<usize> {
    let rows = std::iter::once(term.joints[0]).chain(term.joints.get(3).copied());
    let gain = |code: usize| {
        rows.clone()
            .filter_map(|row| score(data, without, &[row, code], 1.0))
            .map(|s| s.gain)
            .sum::<f64>()
    };
    let mut codes: Vec<(f64, usize)> = term.joints[1..term.joints.len().min(3)]
        .iter()
        .map(|&c| (gain(c), c))
        .collect();
    codes.sort_by(|a, b| b.0.total_cmp(&a.0));
    codes.into_iter().map(|c| c.1).collect()
}

/// RMS of the mean residual above what noise leaves there [N·m or N].
fn rms_above_noise(data: &Data, system: &System, joint: usize) -> f64 {
    let ratio = system.joint_chi_square(joint) / (system.rows(joint) as f64 - system.spent(joint)).max(1.0);
    let repetitions = data.stretches.first().map_or(1, Stretch::repetitions) as f64;
    data.noise[joint].std_dev * ((ratio - 1.0).max(0.0) / repetitions).sqrt()
}
