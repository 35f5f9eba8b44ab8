//! What changes from period to period: friction that drifts, and contacts.

use super::system::Prior;
use super::{AugmentedModel, Finding, RmsPair, Stretch};
use crate::model::Robot;

pub(crate) struct BetweenFinding {}
impl BetweenFinding {
    pub fn finding(&self, _robot: &Robot, _rms: &RmsPair) -> Finding {
        unreachable!()
    }
}
pub(crate) fn separate(_robot: &Robot, stretches: &[Stretch], _start: &AugmentedModel, _prior: Option<&Prior>, _chance: f64) -> (Vec<Stretch>, Vec<BetweenFinding>) {
    (stretches.to_vec(), Vec::new())
}
