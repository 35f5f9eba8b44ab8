//! What can be asked of a diagnosis.

use crate::cancel::CancelFlag;
use crate::effects::OwnEffect;
use crate::model::Robot;
use crate::regression::{AugmentedModel, Estimator, Prior, Term};
use std::sync::Arc;

/// What can be asked of a diagnosis.
#[derive(Debug, Clone)]
pub struct DiagnosisOptions {
    /// Largest chance of a false finding in one log. One in a thousand: a false finding is worse than a miss, because somebody
    /// will compensate for it.
    pub chance: f64,
    /// An existing model and its information, when the question is what has changed since.
    pub existing: Option<(AugmentedModel, Prior)>,
    /// Whether a torque offset of every joint belongs to the declared model: it is fitted, and is no finding.
    pub offsets: bool,
    /// Effects with formulas of their own: declared ones belong to the model from the start, the others are tried like listed
    /// ones.
    pub own: Vec<Arc<OwnEffect>>,
    /// A bound on the search: friction laws of one joint have at most three parts beside viscous and Coulomb (Bittencourt &
    /// Gunnarsson 2012).
    pub most_effects_per_joint: usize,
    /// Whether effects are looked for; otherwise the declared model is estimated and its lack of fit reported.
    pub search: bool,
    /// How rows weigh in the estimate that is handed out.
    pub estimator: Estimator,
    /// Leaves the tracing when it is set, as [`CancelFlag::leave_if_set`] does: within [`CancelFlag::run`].
    pub cancel: CancelFlag,
}

impl Default for DiagnosisOptions {
    fn default() -> Self {
        Self {
            chance: 1e-3,
            existing: None,
            offsets: false,
            own: Vec::new(),
            most_effects_per_joint: 3,
            search: true,
            estimator: Estimator::Weighted,
            cancel: CancelFlag::default(),
        }
    }
}

impl DiagnosisOptions {
    /// The model that the search starts from.
    pub(crate) fn start(&self, robot: &Robot) -> AugmentedModel {
        let existing = self.existing.as_ref().map(|(model, _)| model.clone());
        let mut start = existing.unwrap_or_else(|| AugmentedModel::declared(robot));
        if self.offsets {
            start.terms.extend((0..robot.joint_count()).map(Term::offset));
        }
        start
    }
}
