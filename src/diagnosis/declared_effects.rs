//! Own effects that belong to the model from the start.

use crate::diagnosis::selection::{own_candidate, scan};
use crate::effects::OwnEffect;
use crate::regression::{AugmentedModel, Data, Term, spans};
use std::sync::Arc;

/// `start` with the declared effects among `own`. Where a formula has shape parameters, they begin at the best point of their
/// grid, from which a fit goes on.
pub(crate) fn with_declared(data: &Data, start: AugmentedModel, own: &[Arc<OwnEffect>]) -> AugmentedModel {
    let mut model = start;
    let spans = spans(data.stretches);
    let known = model.clone();
    for effect in own.iter().filter(|e| e.is_declared() && !has(&known, e)) {
        let candidate = own_candidate(effect, &spans);
        let seen = match effect.has_shapes() {
            true => scan(data, &data.fit(model.clone()), std::slice::from_ref(&candidate)).pop(),
            false => None,
        };
        model.terms.push(match seen {
            Some(scored) => scored.term,
            None => unseen(effect, &candidate.term(&[], &[])),
        });
    }
    model
}

/// Whether the model has this effect already: an existing model brings its own.
pub(crate) fn has(model: &AugmentedModel, effect: &OwnEffect) -> bool {
    let same = |t: &Term| {
        t.effect
            .own()
            .is_some_and(|own| own.definition().name == effect.definition().name)
    };
    model.terms.iter().any(same)
}

/// Without a size, at the middle of its grid.
fn unseen(effect: &OwnEffect, term: &Term) -> Term {
    let grid = effect.grid();
    Term {
        coefficients: vec![0.0; effect.coefficients()],
        shape: grid[grid.len() / 2].clone(),
        ..term.clone()
    }
}
