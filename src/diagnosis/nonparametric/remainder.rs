//! What no effect explains, and what it depends on.
//!
//! Smooth functions of one or two variables stand in for the unknown cause. They compete with the effects found: where the
//! effects leave structure that such a function catches, and the function with fewer effects accounts for the data better than
//! the effects alone, the effects were imitations, and are taken back.

use super::bic::{best_with_functions, score_of};
use super::matching_pursuit::{left_over, score};
use crate::diagnosis::report::Remainder;
use crate::diagnosis::selection::{Candidate, Selected, Threshold, chance, hypotheses};
use crate::diagnosis::settings::SETTINGS;
use crate::diagnosis::without_periods;
use crate::effects::variable_name;
use crate::regression::{Data, Stretch, System, Term};

/// The selection with imitations taken back, and the remainder if there is one.
pub(crate) fn examine(
    data: &Data,
    selected: Selected,
    fixed: usize,
    candidates: &[Candidate],
    threshold: &Threshold,
) -> (Selected, Option<Remainder>) {
    if !selected.system.noise_is_measured {
        return without_periods::examine(data, selected);
    }
    let start = score_of(data, &selected.system, candidates, fixed);
    match best_with_functions(data, &selected, fixed, candidates) {
        Some((score, k, system)) if score > start + SETTINGS.nonparametric.preference => {
            withdraw(data, selected, fixed, k, system, candidates, threshold)
        }
        _ => (selected, None),
    }
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
            && loss > SETTINGS.nonparametric.share_beside * accepted[at].gain;
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
            fixed,
            declared: selected.declared,
            given_up: selected.given_up,
        },
        Some(remainder),
    )
}

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
    // Squares beyond a double leave no share that anybody knows.
    let share = Some(1.0 - total(with) / total(&without))
        .filter(|s| s.is_finite())
        .unwrap_or(0.0);
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

/// What is left where neither effects nor smooth functions were found for it: nobody may read that nothing is missing there.
/// Without measured noise nobody knows whether anything is left.
pub(crate) fn unaccounted(data: &Data, system: &System) -> Option<Remainder> {
    let large = |&j: &usize| rms_above_noise(data, system, j) > SETTINGS.nonparametric.unaccounted * data.noise[j].std_dev;
    let rows: Vec<usize> = match system.noise_is_measured {
        true => left_over(data, system).into_iter().filter(large).collect(),
        false => Vec::new(),
    };
    let name = |&j: &usize| system.model.robot.joints()[j].name.clone();
    let joints: Vec<String> = rows.iter().map(name).collect();
    let note = format!(
        "{} keeps more than its noise, and neither an effect known here nor a smooth function of one or two positions and speeds accounts for it; \
         accelerations that the positions do not hold exactly can leave that, too",
        joints.join(", ")
    );
    (!rows.is_empty()).then(|| Remainder {
        joints,
        depends_on: Vec::new(),
        predicted_share: 0.0,
        rms: rows.iter().map(|&j| rms_above_noise(data, system, j)).collect(),
        note,
    })
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
