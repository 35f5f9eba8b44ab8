//! What is planned.

use crate::effects::OwnEffect;
use crate::regression::AugmentedModel;
use crate::trajectory::FourierSeries;
use std::sync::Arc;

/// A recording that is planned.
#[derive(Debug, Clone, Copy)]
pub struct Plan<'a> {
    /// The declared model at the values known beforehand, and the effects known already. With all values zero, effects on torques
    /// are not assessed.
    pub model: &'a AugmentedModel,
    /// Trajectories, all of them recorded.
    pub series: &'a [&'a FourierSeries],
    /// Samples per second of the log.
    pub rate_hz: f64,
    /// Periods of each that are recorded, at least two: with one, the noise is not measured and the search is another one.
    pub periods: f64,
    /// Standard deviation of the torque noise of every joint, white [N·m or N].
    pub torque_noise: &'a [f64],
    /// Effects with formulas of their own that the diagnosis tries beside those listed; declared ones are a part of the model.
    pub own: &'a [Arc<OwnEffect>],
    /// Largest chance of a false finding in one log.
    pub chance: f64,
}
