//! Could it be something else? Every effect is taken out in turn and all others are tried in its place.

use super::contest::Contest;
use super::swaps::swapped;
use crate::diagnosis::report::{Rival, joint_names};
use crate::diagnosis::selection::{
    Accepted, Candidate, Fitted, Scored, Selected, Threshold, appraise, extend, fitted, hypotheses, judge, reach, scan,
};
use crate::diagnosis::settings::SETTINGS;
use crate::diagnosis::without_periods::linear_contests;
use crate::regression::{Data, System, Term};
use nalgebra::DVector;
use rayon::prelude::*;

/// Rivals of every effect that `selected` has beside the first `fixed` terms.
pub(crate) fn rivals(
    data: &Data,
    selected: &Selected,
    fixed: usize,
    candidates: &[Candidate],
    threshold: &Threshold,
) -> Vec<Contest> {
    if !selected.system.noise_is_measured {
        return linear_contests(data, selected, fixed, candidates);
    }
    contests(data, selected, fixed, candidates, threshold, false)
        .into_iter()
        .map(|c| c.0)
        .collect()
}

/// The selection in which no effect has a rival that the evidence prefers, and the rivals that are left; none are reported where
/// misfit is left all the same, since these effects may be taken back.
///
/// An effect that was named early may have stood in for one that was not there yet: beside the later ones another may explain
/// its part better, and takes its place, or one takes that of two, or two that of one; then the search goes on. Every exchange
/// raises the evidence by `not_excluded`, so that none comes back.
pub(crate) fn settled(
    data: &Data,
    mut selected: Selected,
    fixed: usize,
    candidates: &[Candidate],
    threshold: &Threshold,
) -> (Selected, Vec<Contest>) {
    if !selected.system.noise_is_measured {
        let contests = linear_contests(&data.with_noise(selected.noise.clone()), &selected, fixed, candidates);
        return (selected, contests);
    }
    let mut exchanges = 0;
    loop {
        let data = data.with_noise(selected.noise.clone());
        let joints = selected.system.model.robot.joint_count();
        let unsettled = selected.system.noise_is_measured && (0..joints).any(|j| selected.system.has_misfit(&[j]));
        // Imitations have no rivals worth naming, but what they imitate may be found in their place.
        let (mut contests, better): (Vec<Contest>, Vec<Option<Better>>) = match selected.given_up {
            true => (Vec::new(), Vec::new()),
            false => contests(&data, &selected, fixed, candidates, threshold, unsettled)
                .into_iter()
                .unzip(),
        };
        if unsettled {
            contests.clear();
        }
        let best = better
            .into_iter()
            .enumerate()
            .filter_map(|(i, b)| Some((i, b?)))
            .min_by(|a, b| a.1.evidence.total_cmp(&b.1.evidence));
        if exchanges == threshold.most_effects {
            return (selected, contests);
        }
        exchanges += 1;
        match best {
            // The newcomer stands last in its model.
            Some((at, better)) => {
                selected.accepted.remove(at);
                selected.accepted.push(better.accepted);
                selected.system = better.system;
            }
            None => match swapped(&data, &selected, fixed, candidates, threshold) {
                Some(other) => selected = other,
                None => return (selected, contests),
            },
        }
        selected = extend(&data, selected, candidates, threshold);
    }
}

fn contests(
    data: &Data,
    selected: &Selected,
    fixed: usize,
    candidates: &[Candidate],
    threshold: &Threshold,
    better_alone: bool,
) -> Vec<(Contest, Option<Better>)> {
    (0..selected.accepted.len())
        .map(|i| contest(data, selected, fixed + i, candidates, threshold, better_alone))
        .collect()
}

/// A rival that the evidence prefers and that has earned its place, fitted in the place of a finding.
struct Better {
    /// Twice the log of the evidence ratio in favour of the finding: negative.
    evidence: f64,
    accepted: Accepted,
    system: System,
}

/// Twice the log of the evidence ratio in favour of the finding.
///
/// A rival that contains the finding fits no worse, and has only its further parameters against it: simplicity is a reason to
/// name the finding, but none to exclude the rival. The data do that where they leave none of its parameters but those at which
/// it is the finding; until then their part of the evidence alone counts.
fn said_against(finding: &Scored, rival: &Scored, fitted: &System) -> f64 {
    let (own_gain, own) = finding.held_against(std::iter::once(rival));
    let (other_gain, other) = rival.held_against(std::iter::once(finding));
    let evidence = own - other;
    let effect = &rival.candidate.effect;
    if evidence < 0.0
        || !effect.contains().contains(&finding.candidate.effect.code())
        || rival.candidate.joints != finding.candidate.joints
    {
        return evidence;
    }
    let at = fitted.model.terms.len() - 1;
    match effect.is_within_reach(&fitted.model.terms[at].coefficients, &fitted.term_covariance(at)) {
        true => (own_gain - other_gain).clamp(0.0, evidence),
        false => evidence.max(SETTINGS.alternatives.not_excluded),
    }
}

/// The rivals of term `at`, and the one to take its place; with `better_alone` only those that could.
fn contest(
    data: &Data,
    selected: &Selected,
    at: usize,
    candidates: &[Candidate],
    threshold: &Threshold,
    better_alone: bool,
) -> (Contest, Option<Better>) {
    let mut model = selected.system.model.clone();
    let own = model.terms.remove(at);
    let without = data.fit(model);
    let loss = data.gain(&without, &selected.system);
    let Some(mine) = candidates.iter().find(|c| c.is_same_effect(&own) && c.form == own.form) else {
        return (Contest::default(), None);
    };
    let tried = mine.grid().len();
    let cost = own.parameters() - mine.free_shapes();
    let finding = appraise(&without, mine, own.clone(), loss, cost, tried, Some(&selected.system));
    // A rival moves the same rows.
    let joints = without.model.robot.joint_count();
    let reached = reach(mine, joints);
    let meets = |c: &&Candidate| !c.is_same_effect(&own) && reach(c, joints).iter().any(|j| reached.contains(j));
    let others: Vec<Candidate> = candidates.iter().filter(meets).cloned().collect();
    let others = scan(data, &without, &others);
    // The linearised gain errs by a fraction, and before a fit nobody knows what it leaves: what gains nearly as much is fitted
    // properly.
    let could_settle = |s: &Scored| s.could_settle(&without, &reach(&s.candidate, joints));
    let wanted = |s: &&Scored| s.gain > SETTINGS.selection.linear_gain * loss && (!better_alone || could_settle(s));
    let mut near: Vec<_> = others.iter().filter(wanted).collect();
    near.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    near.truncate(6);
    let mut found: Vec<(Rival, Term, DVector<f64>, Option<Better>)> = near
        .par_iter()
        .filter_map(|s| {
            let Fitted {
                scored: there,
                system: fitted,
            } = fitted(data, &without, s);
            let evidence = said_against(&finding, &there, &fitted);
            (evidence < SETTINGS.alternatives.not_excluded).then(|| {
                let rival = Rival {
                    effect: s.candidate.effect.code().into(),
                    joints: joint_names(&without.model.robot, &s.candidate.joints),
                    evidence,
                    formula: None,
                };
                let last = fitted.model.terms.last().expect("the rival was added");
                let (last, values) = (last.clone(), fitted.model.values.clone());
                // Where misfit stays all the same, what the model still lacks could turn the balance.
                let settles = fitted.noise_is_measured && !fitted.has_misfit(&reach(&s.candidate, joints));
                let open = evidence < -SETTINGS.alternatives.not_excluded && settles;
                let tried = hypotheses(candidates, s.candidate.effect.code());
                let accepted = open
                    .then(|| {
                        judge(
                            data,
                            &without,
                            &there,
                            &fitted,
                            fitted.model.terms.len() - 1,
                            threshold,
                            tried,
                        )
                    })
                    .flatten();
                let better = accepted.map(|accepted| Better {
                    evidence,
                    accepted,
                    system: fitted,
                });
                (rival, last, values, better)
            })
        })
        .collect();
    found.sort_by(|a, b| a.0.evidence.total_cmp(&b.0.evidence));
    // Forms of one effect are one rival, reported as its best form.
    let mut rivals: Vec<Rival> = Vec::new();
    let mut fitted = Vec::new();
    let mut better = None;
    for (rival, term, values, preferred) in found {
        better = better.or(preferred);
        if !rivals.iter().any(|r| r.effect == rival.effect && r.joints == rival.joints) {
            rivals.push(rival);
            fitted.push((term, values));
        }
    }
    let ahead = rivals.iter().filter(|r| r.evidence < 0.0 && own.effect.is_everyday());
    let names: Vec<&str> = ahead.map(|r| r.effect.as_str()).collect();
    let note = (!names.is_empty()).then(|| {
        format!(
            "{} explains a little more, but the difference is smaller than what both leave unexplained; {} is what every robot has, and so \
             the likelier cause",
            names.join(", "),
            own.effect.code()
        )
    });
    (Contest { rivals, fitted, note }, better)
}
