//! What can be said of a definition before there is a robot.

use super::arm::Arm;
use super::{Definition, OwnEffect};
use crate::model::FieldProblem;

/// Joints of a formula whose kinds are tried: all combinations of turning and sliding are.
const MOST_TRIED: usize = 8;

impl Definition {
    /// What is wrong with it whatever robot it serves: names, parameters, ranges, units, the formula. Its units are, if they fit
    /// for no combination of turning and sliding joints. Whether a robot has its joints shows when it is used
    /// ([`OwnEffect::new`]).
    pub fn faults(&self) -> Vec<FieldProblem> {
        let arm = Arm::spoken_of(self);
        let effect = match OwnEffect::on(self.clone(), &arm) {
            Ok(effect) => effect,
            Err(found) => return found,
        };
        let places = effect.joints();
        if places.len() > MOST_TRIED {
            return Vec::new();
        }
        let tried = |kinds: usize| OwnEffect::on(self.clone(), &arm.with_kinds(&places, kinds)).err();
        let all_turning = tried(0).unwrap_or_default();
        match (1..1 << places.len()).any(|kinds| tried(kinds).is_none()) {
            true => Vec::new(),
            false => all_turning,
        }
    }
}
