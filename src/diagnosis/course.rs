//! A diagnosis with its data and options, and the model that remains after the test on held-out data.

use super::declared_effects::has;
use super::held_out::{Judge, decide};
use super::options::DiagnosisOptions;
use super::outcome::Estimates;
use super::search::Searched;
use crate::diagnosis::alternatives::Contest;
use crate::diagnosis::report::{FindingHeldOut, Remainder};
use crate::diagnosis::selection::{Accepted, Candidate, Threshold, candidates, honest_covariance, own_candidate};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::OwnEffect;
use crate::model::Robot;
use crate::regression::{AugmentedModel, Data, Explained, Prior, Stretch, System, Term, estimated, spans};
use nalgebra::DMatrix;
use std::sync::Arc;

/// One diagnosis: robot, data, options, and the model that the search starts from.
pub(crate) struct Course<'a> {
    pub robot: &'a Robot,
    pub measured: &'a [Stretch],
    pub held_out: &'a [Stretch],
    pub options: &'a DiagnosisOptions,
    /// The model that the search starts from.
    pub start: AugmentedModel,
    /// Laws in what the log has beside positions and torques.
    pub channel_laws: Vec<Arc<OwnEffect>>,
    /// Share of the torques that the declared model explains on held-out data.
    pub explained: Explained,
}

/// The model that remains after the test on held-out data, and the declared one. Effects are in the order of the decision, those
/// that stay first.
pub(crate) struct Decided<'a> {
    pub data: Data<'a>,
    pub before: System,
    pub system: System,
    pub estimates: Option<Estimates>,
    /// Terms before the effects: those that the search began with, then nuisance offsets.
    pub fixed: usize,
    /// How many effects stay.
    pub stay: usize,
    pub terms: Vec<Term>,
    /// Of the effects' parameters: of those that stay by the final estimate, of the others by the fit that had them.
    pub covariances: Vec<DMatrix<f64>>,
    pub tests: Vec<FindingHeldOut>,
    pub accepted: Vec<Accepted>,
    pub contests: Vec<Contest>,
    pub remainder: Option<Remainder>,
}

impl<'a> Course<'a> {
    pub fn prior(&self) -> Option<&'a Prior> {
        self.options.existing.as_ref().map(|(_, prior)| prior)
    }

    /// Whether the declared model explains the torques at all; otherwise no effect is searched for.
    pub fn explains(&self) -> bool {
        self.options.existing.is_some() || self.explained.is_more_than_a_constant()
    }

    pub fn searches(&self) -> bool {
        self.options.search && self.explains()
    }

    pub fn threshold(&self) -> Threshold {
        Threshold {
            chance: self.options.chance,
            share: SETTINGS.selection.least_share,
            generalises: SETTINGS.selection.least_generalisation,
            most_effects: self.options.most_effects_per_joint * self.robot.joint_count(),
            most_per_joint: self.options.most_effects_per_joint,
        }
    }

    /// Effects on joints that have rows.
    pub fn candidates(&self, stretches: &[Stretch]) -> Vec<Candidate> {
        if !self.searches() {
            return Vec::new();
        }
        let spans = spans(stretches);
        let open = |own: &&Arc<OwnEffect>| !own.is_declared() && !has(&self.start, own);
        // Of two that explain the same, the first is named: what the user thought of.
        let own = self
            .options
            .own
            .iter()
            .filter(open)
            .chain(&self.channel_laws)
            .map(|own| own_candidate(own, &spans));
        let mut list: Vec<Candidate> = own.collect();
        list.extend(candidates(&self.start, &spans, self.prior().is_some()));
        list.retain(|c| c.joints.iter().all(|&j| stretches.iter().any(|s| s.has_rows(j))));
        list
    }

    /// Held-out data decide what stays; then model and declared model are estimated afresh.
    pub fn decided<'d>(&self, found: Searched<'d>) -> Decided<'d> {
        let Searched {
            data,
            system,
            fixed,
            accepted,
            contests,
            remainder,
        } = found;
        let withheld: Vec<DMatrix<f64>> = (0..accepted.len()).map(|i| honest_covariance(&system, fixed + i)).collect();
        let named: Vec<Term> = system.model.terms[fixed..].to_vec();
        let decision = decide(&data, system, fixed, &self.judge(&data));
        let estimates = self.prior().is_none().then(|| Estimates {
            found: estimated(&data, &decision.system.model, self.options.estimator),
            declared: estimated(&data, &self.start, self.options.estimator),
        });
        let (before, system) = match &estimates {
            Some(e) => (
                data.linearise(e.declared.model.clone()),
                data.linearise(e.found.model.clone()),
            ),
            None => (data.fit(self.start.clone()), decision.system),
        };
        let stay = decision.stay;
        let covariance = |at: usize| match &estimates {
            Some(estimates) if at < stay => estimates.found.term_covariance(fixed + at),
            None if at < stay => honest_covariance(&system, fixed + at),
            _ => withheld[decision.order[at]].clone(),
        };
        let term = |at: usize| match at < stay {
            true => system.model.terms[fixed + at].clone(),
            false => named[decision.order[at]].clone(),
        };
        let all = 0..accepted.len();
        Decided {
            covariances: all.clone().map(covariance).collect(),
            terms: all.map(term).collect(),
            accepted: decision.order.iter().map(|&i| accepted[i].clone()).collect(),
            contests: decision.order.iter().map(|&i| contests[i].clone()).collect(),
            tests: decision.tests,
            remainder,
            data,
            before,
            system,
            estimates,
            fixed,
            stay,
        }
    }

    pub fn judge(&self, data: &Data) -> Judge<'a> {
        Judge {
            logs: self.held_out,
            floor: data.noise.iter().map(|n| n.std_dev).collect(),
        }
    }
}
