//! What a diagnosis hands back: the report, the model that was found, and what is known of it.

use crate::diagnosis::alternatives::RivalTerm;
use crate::diagnosis::report::ResidualReport;
use crate::regression::{AugmentedModel, Explained, Fitted, NoiseModel, Prior};
use nalgebra::DMatrix;

/// Report, augmented model and estimates.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// Verdict, findings and errors, as documents report them.
    pub report: ResidualReport,
    /// The declared model with the effects that were found.
    pub model: AugmentedModel,
    /// Share of the torques that the declared model explains on held-out data.
    pub explained: Explained,
    /// Noise of every joint.
    pub noise: Vec<NoiseModel>,
    /// Rows of the fit per second of the motion.
    pub rate_hz: f64,
    /// Of every term of the model, the rivals that the data do not exclude.
    pub rival_terms: Vec<Vec<RivalTerm>>,
    /// Inverse covariance of [`AugmentedModel::vector`].
    pub information: DMatrix<f64>,
    /// The estimates with the effects and without them; `None` against an existing model, whose parameters are no estimate of
    /// these logs alone.
    pub estimates: Option<Estimates>,
}

/// The same rows and weights twice.
#[derive(Debug, Clone)]
pub struct Estimates {
    /// Declared model and effects together: what is handed out.
    pub found: Fitted,
    /// Without the effects, for comparison.
    pub declared: Fitted,
}

impl Diagnosis {
    /// The model and what is known about it, for tracing what changes afterwards. The remainder's stand-in terms stay out of it.
    pub fn existing(&self) -> (AugmentedModel, Prior) {
        (
            self.model.clone(),
            Prior {
                mean: self.model.vector(),
                information: self.information.clone(),
            },
        )
    }
}
