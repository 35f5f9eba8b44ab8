//! Pairs of shapes that avoid each other, and the penalty for coming too near.

use super::super::problem::ProblemSpec;
use super::distance::{Distance, poses};
use super::{HalfSpace, Obstacle, SelfCollision, SpaceLimits};
use crate::dynamics::Motion;
use crate::model::{Capsule, FieldProblem, INPUT_LIMITS, Joint, Robot};
use crate::spatial::Transform;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// A capsule and the shape that it avoids.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    pub link: usize,
    pub capsule: Capsule,
    pub against: Against,
    /// Name of the obstacle; of a link its joint's.
    pub name: String,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Against {
    HalfSpace { normal: Vector3<f64>, offset: f64 },
    Box { center: Vector3<f64>, size: Vector3<f64> },
    Link { link: usize, capsule: Capsule },
}

/// Checked limits in space.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct SpaceSet {
    pub pairs: Vec<Pair>,
    pub clearance: f64,
}

/// Coming nearer than the clearance by this much (m) weighs like exceeding a torque limit twice over.
const LENGTH: f64 = 0.1;

impl SpaceSet {
    /// `None` where no limits in space are asked for, or where `found` now says what is wrong with them.
    pub fn new(spec: &ProblemSpec, found: &mut Vec<FieldProblem>) -> Option<Self> {
        let asked = spec.space.as_ref()?;
        let before = found.len();
        check(asked, &spec.robot, found);
        (found.len() == before).then(|| Self {
            pairs: pairs(asked, &spec.robot)
                .into_iter()
                .filter(|p| !always_touch(&spec.robot, p))
                .collect(),
            clearance: asked.clearance,
        })
    }

    /// The nearest pair at positions `q`.
    pub fn nearest(&self, robot: &Robot, q: &dyn Fn(usize) -> f64) -> Option<(&Pair, f64)> {
        let mut frames = Vec::new();
        poses(robot, q, &mut frames);
        let all = self.pairs.iter().map(|p| (p, p.distance(&frames).value));
        all.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Adds `penalty · mean over samples of Σ_pairs (max(0, clearance − distance)/LENGTH)²` and its derivative by q (joint-major,
    /// padded).
    pub fn add_excess(&self, robot: &Robot, motion: &Motion, penalty: f64, to_q: &mut [f64]) -> f64 {
        let (mut frames, mut total) = (Vec::new(), 0.0);
        let weight = penalty / motion.samples() as f64;
        for s in 0..motion.samples() {
            poses(robot, &|j| motion.positions(j)[s], &mut frames);
            for pair in &self.pairs {
                let at = pair.distance(&frames);
                let excess = (self.clearance - at.value) / LENGTH;
                if excess > 0.0 {
                    total += weight * excess * excess;
                    let slope = -2.0 * weight * excess / LENGTH;
                    pair.gradient(robot, &frames, &at, |k, change| {
                        to_q[k * motion.stride() + s] += slope * change
                    });
                }
            }
        }
        total
    }

    /// Whether every distance is at least the clearance at all samples.
    pub fn holds(&self, robot: &Robot, motion: &Motion, room: f64) -> bool {
        let mut frames: Vec<Transform> = Vec::new();
        (0..motion.samples()).all(|s| {
            poses(robot, &|j| motion.positions(j)[s], &mut frames);
            let kept = |at: Distance| at.value >= self.clearance + room;
            self.pairs.iter().all(|p| kept(p.distance(&frames)))
        })
    }
}

/// No obstacle of an arm is farther away (m); distances are computed from squares and differences of such numbers.
const FARTHEST: f64 = 1e4;

fn check(asked: &SpaceLimits, robot: &Robot, found: &mut Vec<FieldProblem>) {
    let mut complain =
        |pointer: String, detail: String| found.push(FieldProblem::new(format!("/constraints/space{pointer}"), detail));
    let (shapes, obstacles) = (capsules(robot).count(), asked.half_spaces.len() + asked.boxes.len());
    // Of two links, each pair of capsules counts once.
    let among_links = asked.self_collision.as_ref().map_or(0, |_| shapes * shapes / 2);
    let pairs = shapes.saturating_mul(obstacles).saturating_add(among_links);
    if obstacles > INPUT_LIMITS.obstacles || pairs > INPUT_LIMITS.distance_pairs {
        complain(
            String::new(),
            format!(
                "asks for {pairs} distances between {shapes} capsules, {obstacles} obstacles and each other, the most accepted are {} distances and {} \
                 obstacles: use fewer, larger shapes",
                INPUT_LIMITS.distance_pairs, INPUT_LIMITS.obstacles
            ),
        );
        return;
    }
    let far = |v: &f64| v.abs() > FARTHEST;
    if robot.joints().iter().all(|j| j.geometry.is_empty()) {
        complain(
            String::new(),
            "needs shapes of the links, and no joint of the robot has `geometry`: give capsules (from, to, radius)".into(),
        );
    }
    // A metre or more is a unit mistake: millimetres.
    if !(0.0..1.0).contains(&asked.clearance) {
        complain(
            "/clearance".into(),
            format!("is {}; give metres, from 0 to below 1", asked.clearance),
        );
    }
    for (i, HalfSpace { normal, offset, .. }) in asked.half_spaces.iter().enumerate() {
        if !(normal.norm().is_finite() && normal.norm() > 1e-6 && !far(&(offset / normal.norm()))) {
            complain(
                format!("/half_spaces/{i}"),
                format!(
                    "needs a normal with a direction and an offset within {FARTHEST} m: the arm stays where normal · p ≥ offset"
                ),
            );
        }
    }
    for (i, Obstacle { center, size, .. }) in asked.boxes.iter().enumerate() {
        let out_of_reach = center.iter().chain(size.iter()).any(far);
        if out_of_reach || size.iter().any(|&v| v <= 0.0) {
            complain(
                format!("/boxes/{i}"),
                format!("needs a center and three edges of positive length, all within {FARTHEST} m"),
            );
        }
    }
}

fn pairs(asked: &SpaceLimits, robot: &Robot) -> Vec<Pair> {
    let mut all = Vec::new();
    for (link, capsule) in capsules(robot) {
        let mut add = |name: &str, against: Against| {
            all.push(Pair {
                link,
                capsule,
                against,
                name: name.to_string(),
            })
        };
        for h in &asked.half_spaces {
            let (normal, length) = (h.normal.normalize(), h.normal.norm());
            add(
                &h.name,
                Against::HalfSpace {
                    normal,
                    offset: h.offset / length,
                },
            );
        }
        for b in &asked.boxes {
            add(
                &b.name,
                Against::Box {
                    center: b.center,
                    size: b.size,
                },
            );
        }
        for (other, second) in capsules(robot) {
            let apart = asked.self_collision.as_ref().is_some_and(|s| keeps_off(s, other, link));
            if apart {
                add(
                    &robot.joints()[other].name,
                    Against::Link {
                        link: other,
                        capsule: second,
                    },
                );
            }
        }
    }
    all
}

/// Whether two links overlap wherever the joints are, as those around a common elbow do: nothing to keep apart.
fn always_touch(robot: &Robot, pair: &Pair) -> bool {
    let Against::Link { .. } = pair.against else { return false };
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut frames = Vec::new();
    (0..RANDOM_POSTURES).all(|_| {
        let q: Vec<f64> = robot.joints().iter().map(|j| anywhere(j, &mut rng)).collect();
        poses(robot, &|j| q[j], &mut frames);
        pair.distance(&frames).value <= 0.0
    })
}

/// A pair that is apart in one posture of a hundred is missed with probability 0.99^200 = 13 %; such pairs are next to never
/// apart anyway.
const RANDOM_POSTURES: usize = 200;

fn anywhere(joint: &Joint, rng: &mut ChaCha8Rng) -> f64 {
    let free = if joint.is_revolute() { PI } else { 0.5 };
    let [low, high] = joint.limits.position.unwrap_or([-free, free]);
    rng.random_range(low..high)
}

/// Links joined by one joint always touch; the smaller comes first.
fn keeps_off(s: &SelfCollision, one: usize, other: usize) -> bool {
    one + 1 < other && !s.ignored.contains(&(one, other))
}

fn capsules(robot: &Robot) -> impl Iterator<Item = (usize, Capsule)> + '_ {
    let joints = robot.joints().iter().enumerate();
    joints.flat_map(|(link, joint)| joint.geometry.iter().map(move |c| (link, *c)))
}
