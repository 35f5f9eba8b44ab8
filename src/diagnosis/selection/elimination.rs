//! Backward elimination: effects that later ones have made superfluous.

use super::candidate::Candidate;
use super::score::{chance, hypotheses};
use super::types::{Selected, Threshold};
use super::wald_test::wald;
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{Data, System, Term};

/// Joints that a term moves, of this many.
pub(crate) fn reached(term: &Term, joints: usize) -> Vec<usize> {
    if term.joints.is_empty() {
        (0..joints).collect()
    } else {
        term.acts_on()
    }
}

/// Takes out effects that later ones have made superfluous.
pub(crate) fn drop_superfluous(data: &Data, now: &mut Selected, candidates: &[Candidate], threshold: &Threshold) {
    let fixed = now.fixed;
    let mut at = now.system.model.terms.len();
    while at > fixed {
        at -= 1;
        if at + 1 == now.system.model.terms.len() {
            continue;
        }
        let term: Term = now.system.model.terms[at].clone();
        let tried = hypotheses(candidates, term.effect.code());
        let superfluous =
            |loss: f64, parameters: usize| chance_of_loss(&now.system, at, loss, parameters) * tried > threshold.chance;
        // A fit without the effect says what is lost; where the linear model says many times what is needed, it need not be made.
        let (linear, _) = wald(&term, &now.system.term_covariance(at));
        if !superfluous(SETTINGS.selection.linear_loss_share * linear, term.parameters()) {
            continue;
        }
        let mut model = now.system.model.clone();
        model.terms.remove(at);
        let without = data.fit(model);
        let loss = data.gain(&without, &now.system);
        if superfluous(loss, term.parameters()) {
            now.system = without;
            now.accepted.remove(at - fixed);
        }
    }
}

/// Chance of losing as much without term `at`, if there were no such effect. What is left was taken for noise before the last
/// effect was found: only where noise is measured can a loss be weighed by it alone.
pub(crate) fn chance_of_loss(system: &System, at: usize, loss: f64, parameters: usize) -> f64 {
    let doubt = match system.noise_is_measured {
        true => 1.0,
        false => system.persistence(&reached(&system.model.terms[at], system.model.robot.joint_count())),
    };
    chance(loss / doubt, parameters)
}
