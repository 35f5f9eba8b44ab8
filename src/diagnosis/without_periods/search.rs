//! The search itself: what every robot may have on all joints at once, then single effects.

use super::field::{Chosen, Field};
use super::{nuisance, settle};
use crate::diagnosis::selection::{Candidate, Selected, Threshold, drop_superfluous, is_physical, scan};
use crate::regression::{Data, Term};

/// Continues a stepwise selection, then once more without the effects that do not last: they may have stood where another
/// belongs.
pub(crate) fn extend(data: &Data, mut now: Selected, candidates: &[Candidate], threshold: &Threshold) -> Selected {
    let mut data = data.with_noise(now.noise.clone());
    let mut open = candidates.to_vec();
    loop {
        grow(&mut data, &mut now, [candidates, &open], threshold);
        let gone = settle::settle(&data, &mut now);
        if gone.is_empty() {
            break;
        }
        open.retain(|c| !gone.iter().any(|t| c.is_same_effect(t)));
    }
    nuisance::promote(&data, &mut now, candidates, threshold);
    now.noise = data.noise;
    now
}

/// Adds effects of `open` until none has earned its place.
fn grow(data: &mut Data, now: &mut Selected, [candidates, open]: [&[Candidate]; 2], threshold: &Threshold) {
    let mut open = open.to_vec();
    for _ in 0..2 * threshold.most_effects {
        if now.accepted.len() >= threshold.most_effects {
            break;
        }
        let scored = scan(data, &now.system, &open);
        let Some(field) = Field::of(data, &now.system, &open, &scored, threshold) else {
            break;
        };
        let nuisance = match nuisance::is_open(now) {
            true => field.nuisance_offsets(),
            false => Vec::new(),
        };
        if !nuisance.is_empty() {
            nuisance::add(data, now, nuisance);
        } else {
            let chosen = field.families().map_or_else(|| field.singles(), |family| vec![family]);
            if chosen.is_empty() {
                break;
            }
            match fitted(data, now, &chosen) {
                Ok(next) => *now = next,
                Err(refused) => {
                    // The fit to all rows says otherwise: it has no further turn.
                    open.retain(|c| !refused.iter().any(|r| r.0 == c.effect.code() && r.1 == c.joints));
                    continue;
                }
            }
        }
        *data = data.with_noise(data.left_as_noise(&now.system));
        now.system = data.fit(now.system.model.clone());
        now.noise = data.noise.clone();
        drop_superfluous(data, now, candidates, threshold);
    }
}

/// Effects that are not to be tried again: code and joints.
type Refused = Vec<(String, Vec<usize>)>;

/// The selection with what was chosen, fitted to all rows.
fn fitted(data: &Data, now: &Selected, chosen: &[Chosen]) -> Result<Selected, Refused> {
    let (mut model, mut accepted, mut fixed) = (now.system.model.clone(), now.accepted.clone(), now.fixed);
    let news: Vec<Term> = chosen.iter().flat_map(Chosen::terms).collect();
    // A newcomer that holds another as its limit takes its place.
    for at in (now.declared..model.terms.len()).rev() {
        let known = &model.terms[at];
        let held = |t: &Term| t.joints == known.joints && t.effect.contains().contains(&known.effect.code());
        if news.iter().any(held) {
            model.terms.remove(at);
            match at < fixed {
                true => fixed -= 1,
                false => drop(accepted.remove(at - now.fixed)),
            }
        }
    }
    let first = model.terms.len();
    model.terms.extend(news.iter().cloned());
    let system = data.fit(model);
    let wrong: Refused = (0..news.len())
        .filter(|i| !is_physical(&system, first + i))
        .map(|i| (news[i].effect.code().to_string(), news[i].joints.clone()))
        .collect();
    if !wrong.is_empty() {
        return Err(wrong);
    }
    accepted.extend(chosen.iter().flat_map(|c| c.accepted.iter().cloned()));
    Ok(Selected {
        system,
        accepted,
        noise: now.noise.clone(),
        fixed,
        declared: now.declared,
        given_up: false,
    })
}
