//! What a selection works with: thresholds, accepted effects, and the selection so far.

use super::cross_validation::HeldOutGain;
use crate::regression::{NoiseModel, System};

/// What an accepted effect has shown.
#[derive(Debug, Clone)]
pub(crate) struct Accepted {
    pub effect: String,
    /// Decrease of the weighted sum of squares, fair to what is left.
    pub gain: f64,
    pub evidence: f64,
    /// Chance of such a gain without the effect, times the number of hypotheses.
    pub p_value: f64,
    pub held_out: HeldOutGain,
}

/// The result of a selection.
pub(crate) struct Selected {
    pub system: System,
    /// In the order of acceptance, one per term of the model.
    pub accepted: Vec<Accepted>,
    /// Noise that the system's rows are whitened with: what is left, where it is not measured.
    pub noise: Vec<NoiseModel>,
    /// Terms before the effects: those that the search began with, then nuisance offsets.
    pub fixed: usize,
    /// How many of them the search began with.
    pub declared: usize,
    /// Whether smooth functions account for the data at so much lower a price that the search for further effects was given up.
    pub given_up: bool,
}

/// What an effect must reach.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Threshold {
    /// Largest chance of a false finding in the whole search.
    pub chance: f64,
    /// Share of the residual above the noise, on the joints reached, that an effect must explain.
    pub share: f64,
    /// Share of the gain that must be there on blocks of time left out.
    pub generalises: f64,
    pub most_effects: usize,
    /// Effects on one joint beyond which they are no account of causes.
    pub most_per_joint: usize,
}
