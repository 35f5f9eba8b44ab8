//! Nuisance offsets: torque offsets that are estimated without being findings.
//!
//! Where the torque sensor of one joint has an offset, those of the others have one too, small or large. Too small to be beyond
//! doubt one by one, they still bend the gravity parameters that take them up, and with these the torque of other joints: on the
//! measured log of an LBR Med 7, the error of joint A7 on held-out data rose by half without them. So once an offset is found,
//! those of all other joints are estimated as well if together they predict blocks left out better.

use super::field::{Field, OFFSET};
use crate::diagnosis::selection::{Accepted, Candidate, Selected, Threshold, scan};
use crate::regression::{Data, Term};

/// Whether nuisance offsets may come in: an offset was found, and they have not come yet.
pub(crate) fn is_open(now: &Selected) -> bool {
    let found = |a: &Accepted| a.effect == OFFSET;
    now.fixed == now.declared && now.accepted.iter().any(found)
}

/// The selection with these offsets, fitted to all rows.
pub(crate) fn add(data: &Data, now: &mut Selected, offsets: Vec<Term>) {
    let mut model = now.system.model.clone();
    let count = offsets.len();
    model.terms.splice(now.fixed..now.fixed, offsets);
    now.fixed += count;
    now.system = data.fit(model);
}

/// Turns the finding of term `at` into a nuisance offset, where it is an offset and there are such; says whether it has.
pub(crate) fn demote(now: &mut Selected, at: usize) -> bool {
    if now.accepted[at - now.fixed].effect != OFFSET || now.fixed == now.declared {
        return false;
    }
    let term = now.system.model.terms.remove(at);
    now.accepted.remove(at - now.fixed);
    now.system.model.terms.insert(now.fixed, term);
    now.fixed += 1;
    true
}

/// Makes findings of the nuisance offsets that are beyond doubt beside all that was found after them.
pub(crate) fn promote(data: &Data, now: &mut Selected, candidates: &[Candidate], threshold: &Threshold) {
    for at in (now.declared..now.fixed).rev() {
        let without = now.system.without_term(data, at);
        let term = &now.system.model.terms[at];
        let own: Vec<Candidate> = candidates.iter().filter(|c| c.is_same_effect(term)).cloned().collect();
        let scored = scan(data, &without, &own);
        let Some(accepted) = Field::of(data, &without, candidates, &scored, threshold).and_then(|f| f.beyond_doubt()) else {
            continue;
        };
        let term = now.system.model.terms.remove(at);
        now.system.model.terms.push(term);
        now.fixed -= 1;
        now.accepted.push(accepted);
    }
    now.system = data.fit(now.system.model.clone());
}
