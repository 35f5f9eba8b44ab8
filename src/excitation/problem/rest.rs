//! Where the motion starts and scales from, and whether the arm can stand there.

use super::{Criterion, Problem, Start};
use crate::dynamics::{Coulomb, Motion, inverse_dynamics_batch};
use crate::excitation::postures::Postures;

impl Problem {
    /// Why no motion at all is possible, if so: a joint that starts on its limit would have to leave it.
    pub fn no_room(&self) -> Option<String> {
        let joints = self.spec.robot.joints().iter().enumerate();
        let mut stuck = joints.filter(|(j, joint)| {
            let rest = self.rest_position(*j);
            joint.limits.position.is_some_and(|[low, high]| rest <= low || rest >= high)
        });
        stuck.next().map(|(_, joint)| {
            format!(
                "joint `{}` starts on its position limit and has nowhere to go: choose another start_position, or start: free",
                joint.name
            )
        })
        .or_else(|| {
            let alike = self.spec.criterion == Criterion::RivalEvidence
                && self.spec.knowledge.rivals.as_ref().is_some_and(|r| r.nested == [true, true]);
            alike.then(|| "the two rivals make the same torques on any motion of this arm, once the other parameters are fitted: no motion tells them apart".into())
        })
        .or_else(|| {
            let reasons: Vec<String> = self.too_heavy_at_rest().into_iter().chain(self.too_near_at_rest()).collect();
            (!reasons.is_empty()).then(|| format!("{}; {}", reasons.join("; "), Postures::for_problem(self).in_words(self)))
        })
    }

    /// For a free start whose middle of the ranges is not allowed: a posture that is, if there is one.
    pub(super) fn another_rest(&self) -> Option<Vec<f64>> {
        let stuck = self.too_heavy_at_rest().is_some() || self.too_near_at_rest().is_some();
        let searched = self.spec.start == Start::Free && stuck;
        searched.then(|| Postures::for_problem(self).best).flatten()
    }

    /// The first joint that exceeds its torque limit by holding the arm still, in words.
    fn too_heavy_at_rest(&self) -> Option<String> {
        let limits = self.torque.as_ref()?;
        let joints = self.spec.robot.joint_count();
        let prior = self.layout.prior(&self.spec.robot)?;
        // Just moving, one way and the other: friction is there as soon as anything moves.
        let still = Motion::from_fn(joints, 2, |j, s| [self.rest_position(j), [-1e-9, 1e-9][s], 0.0]);
        let torques = inverse_dynamics_batch(&self.chain, &self.layout, prior.as_slice(), &still, Coulomb::Sign);
        let at = |j: usize| torques[j * still.stride()].abs().max(torques[j * still.stride() + 1].abs());
        let joint = (0..joints).find(|&j| at(j) >= limits.allowed[j])?;
        Some(format!(
            "joint `{}` needs {:.4} to hold the arm where the motion starts and to begin to move, and constraints.torque allows {:.4} N m or N: choose another \
             start_position, a smaller safety_factor or larger limits",
            self.spec.robot.joints()[joint].name,
            at(joint),
            limits.allowed[joint]
        ))
    }

    /// The pair that is too near before anything has moved, in words.
    fn too_near_at_rest(&self) -> Option<String> {
        let set = self.space.as_ref()?;
        let (pair, distance) = set.nearest(self.robot(), &|j| self.rest_position(j))?;
        (distance <= set.clearance).then(|| {
            format!(
                "where the motion starts, the link of joint `{}` is {:.4} m from `{}`, and constraints.space asks for more than {} m: choose another \
                 start_position, a smaller clearance, or add the pair to self_collision.ignore if it always touches",
                self.robot().joints()[pair.link].name,
                distance,
                pair.name,
                set.clearance
            )
        })
    }

    /// Where the coefficients of `joint` scale from: the start position, or the middle of the range when the start is free, or
    /// where limits along the path do not allow that another posture that they do.
    pub fn rest_position(&self, joint: usize) -> f64 {
        if let Some(rest) = &self.elsewhere {
            return rest[joint];
        }
        match (self.spec.start, self.spec.robot.joints()[joint].limits.position) {
            (Start::Free, Some([low, high])) => 0.5 * (low + high),
            _ => self.start_position[joint],
        }
    }
}
