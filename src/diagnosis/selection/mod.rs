//! Stepwise selection of effects: screening of all candidates, forward steps, backward elimination.
//!
//! A candidate is scored by the gain it would bring after the model's own columns are projected out, less what its parameters and
//! the choice cost (`score`); the best are fitted, and must be physical, significant by a Wald test, explain a share of what is
//! left, and hold on data left out (`acceptance`, `cross_validation`).

mod acceptance;
mod candidate;
mod cross_validation;
mod elimination;
mod family;
mod fitted;
mod pairs;
mod score;
mod screening;
mod stepwise;
mod types;
mod wald_test;

pub(crate) use acceptance::{has_physical_signs, is_physical, is_plausible, is_simpler, judge};
pub(crate) use candidate::{Candidate, candidates, columns_of, own_candidate, reach};
#[cfg(test)]
pub(crate) use cross_validation::held_out_gain;
pub(crate) use cross_validation::{Folds, HeldOutGain, fold_blocks};
pub(crate) use elimination::{drop_superfluous, reached};
pub(crate) use fitted::{Fitted, fitted};
pub(crate) use pairs::best_pair;
pub(crate) use score::{Scored, appraise, chance, hypotheses};
pub(crate) use screening::{best_on_grid, refine, scan, scan_on_grid};
pub(crate) use stepwise::{extend, select};
pub(crate) use types::{Accepted, Selected, Threshold};
pub(crate) use wald_test::{doubt, honest_covariance, wald};
