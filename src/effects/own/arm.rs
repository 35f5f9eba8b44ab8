//! The joints that a formula is read against: those of a robot, or those that it speaks of, where it is to serve any robot.

use super::Definition;
use super::names::{Said, said};
use super::parse::parsed;
use crate::model::{INPUT_LIMITS, Robot};

/// Joints with their names, and whether each turns.
#[derive(Debug, Clone)]
pub(super) struct Arm {
    joints: Vec<(String, bool)>,
    /// How many of them are called by their numbers.
    numbered: usize,
    /// Whether it is known which of them turn: without, units of formulas cannot be held together.
    pub kinds_known: bool,
}

impl Arm {
    pub fn of(robot: &Robot) -> Self {
        let joints: Vec<(String, bool)> = robot.joints().iter().map(|j| (j.name.clone(), j.is_revolute())).collect();
        Self {
            numbered: joints.len(),
            joints,
            kinds_known: true,
        }
    }

    /// As many numbered joints as a robot may have, and those that the definition calls by name.
    pub fn spoken_of(definition: &Definition) -> Self {
        let mut joints = vec![(String::new(), true); INPUT_LIMITS.joints];
        let names = parsed(&definition.expression).map(|(_, names)| names).unwrap_or_default();
        let by_name = names.iter().filter_map(|name| match said(name) {
            Some(Said::Named { joint, .. }) => Some(joint),
            Some(Said::Numbered { .. } | Said::Own { .. }) | None => None,
        });
        for name in std::iter::once(definition.joint.as_str()).chain(by_name) {
            if !joints[INPUT_LIMITS.joints..].iter().any(|(known, _)| known == name) {
                joints.push((name.to_string(), true));
            }
        }
        Self {
            joints,
            numbered: INPUT_LIMITS.joints,
            kinds_known: false,
        }
    }

    /// Place of a joint by its name. Those of no robot that have only numbers have none.
    pub fn place(&self, name: &str) -> Option<usize> {
        let named = if self.numbered < self.joints.len() { self.numbered } else { 0 };
        self.joints[named..]
            .iter()
            .position(|(known, _)| known == name)
            .map(|at| named + at)
    }

    pub fn numbered(&self) -> usize {
        self.numbered
    }

    pub fn names(&self) -> Vec<&str> {
        self.joints.iter().map(|(name, _)| name.as_str()).collect()
    }

    pub fn turns(&self, joint: usize) -> bool {
        self.joints[joint].1
    }

    /// The same with the joints of `places` turning or sliding by the bits of `kinds`.
    pub fn with_kinds(&self, places: &[usize], kinds: usize) -> Self {
        let mut arm = self.clone();
        for (bit, place) in places.iter().enumerate() {
            arm.joints[*place].1 = kinds >> bit & 1 == 0;
        }
        arm.kinds_known = true;
        arm
    }
}
