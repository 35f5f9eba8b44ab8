//! The fit of one more effect beside everything else.

use super::score::{Scored, appraise};
use crate::regression::{Data, System};

/// A contender, fitted with everything else.
pub(crate) struct Fitted {
    pub scored: Scored,
    pub system: System,
}

/// Adds a candidate to the model of `system`, fits all parameters, and appraises what it gains then.
pub(crate) fn fitted(data: &Data, system: &System, scored: &Scored) -> Fitted {
    let mut model = system.model.clone();
    model.terms.push(scored.term.clone());
    let there = data.fit(model);
    let gain = data.gain(system, &there);
    let rank = if scored.term.is_distortion() {
        scored.cost
    } else {
        scored.cost - scored.candidate.free_shapes().min(scored.cost)
    };
    let term = scored.term.clone();
    let scored = appraise(system, &scored.candidate, term, gain, rank, scored.tried, Some(&there));
    Fitted { scored, system: there }
}
