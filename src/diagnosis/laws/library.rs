//! All laws that are tried, and what the choice among them costs.

use crate::diagnosis::selection::{Candidate, reach};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::law::{Class, LawForm, OfPosition};
use crate::effects::{AnyEffect, Effect, Law, Span, by_code};
use crate::model::Robot;
use crate::regression::{Data, Term};

/// A law on a place, one of `tried`.
pub(super) struct Hypothesis {
    pub candidate: Candidate,
    pub tried: usize,
}

/// Classes that share the prior: those of laws, and the listed effects.
const CLASSES: f64 = 5.0;

/// Laws that act on one of `rows` and on no joint without rows. Every class has the same prior, laws and listed effects one half
/// each.
pub(super) fn library(robot: &Robot, data: &Data, spans: &[Span], rows: &[usize]) -> Vec<Hypothesis> {
    let seen = |j: &usize| data.stretches.iter().any(|s| s.has_rows(*j));
    let mut list: Vec<(LawForm, Candidate)> = Vec::new();
    for (number, &form) in LawForm::all().iter().enumerate() {
        for joints in Law.places_of(number, robot) {
            let acts = form.acts_on(&joints);
            let wanted = acts.iter().any(|j| rows.contains(j)) && acts.iter().all(seen);
            if !wanted || is_listed(form, &joints, spans) {
                continue;
            }
            let shapes = Law.shapes(number, &joints, spans);
            if shapes.iter().all(|s| !s.grid.is_empty()) {
                list.push((form, candidate(number, joints, shapes)));
            }
        }
    }
    let members = |class: Class| list.iter().filter(|(form, _)| form.class() == class).count() as f64;
    let tried = |form: LawForm, candidate: &Candidate| {
        let turns = candidate.joints.iter().any(|&j| robot.joints()[j].is_revolute());
        let odds = if turns && !form.is_periodic() {
            SETTINGS.laws.not_periodic
        } else {
            0.0
        };
        (members(form.class()) * 2.0 * CLASSES * (0.5 * odds).exp()).ceil() as usize
    };
    let all: Vec<usize> = list.iter().map(|(form, c)| tried(*form, c)).collect();
    let candidates = list.into_iter().map(|(_, candidate)| candidate);
    candidates
        .zip(all)
        .map(|(candidate, tried)| Hypothesis { candidate, tried })
        .collect()
}

fn candidate(form: usize, joints: Vec<usize>, shapes: Vec<crate::effects::Shape>) -> Candidate {
    Candidate {
        effect: AnyEffect::Listed(&Law),
        form,
        joints,
        shapes,
        bounds: Vec::new(),
    }
}

/// Whether a listed effect is the same: waves of a position that are fast enough are ripple.
fn is_listed(form: LawForm, joints: &[usize], spans: &[Span]) -> bool {
    match form {
        LawForm::Position(OfPosition::Sine(n) | OfPosition::Cosine(n) | OfPosition::Wave(n)) => {
            let ripple = by_code("position_ripple").expect("is in the list");
            ripple
                .shapes(0, joints, spans)
                .iter()
                .any(|cycles| f64::from(n) >= cycles.low)
        }
        _ => false,
    }
}

/// Whether a law on these joints is among those that act on `rows`.
pub(super) fn acts_on(candidate: &Candidate, rows: &[usize], joints: usize) -> bool {
    reach(candidate, joints).iter().any(|j| rows.contains(j))
}

/// Whether a term is of this candidate, in the same form.
pub(super) fn is_of(candidate: &Candidate, term: &Term) -> bool {
    candidate.form == term.form && candidate.is_same_effect(term)
}
