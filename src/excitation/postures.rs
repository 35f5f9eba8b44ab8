//! Where a motion can rest: limits along the path looked at in random postures.
//!
//! Motions scale from a point of rest, which has to keep every limit itself. A free start takes the middle of the joints' ranges
//! where that is allowed, else the random posture that stays farthest from all limits. Where none is allowed, the counts say
//! which limits fight.

use super::problem::Problem;
use crate::dynamics::{Coulomb, Motion, inverse_dynamics_batch};
use crate::model::Joint;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// If one posture in a thousand is allowed, one of these is with a probability of 87 %.
const POSTURES: usize = 2000;

/// How random postures fare.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Postures {
    /// Of all, those that the torque limits, the distances, and both allow.
    torque: usize,
    space: usize,
    both: usize,
    /// The allowed posture with the most left to every limit.
    pub best: Option<Vec<f64>>,
}

impl Postures {
    pub fn for_problem(problem: &Problem) -> Self {
        let joints = problem.robot().joints();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let all: Vec<Vec<f64>> = (0..POSTURES)
            .map(|_| joints.iter().map(|j| anywhere(j, &mut rng)).collect())
            .collect();
        let left = left_over(problem, &all);
        let count = |of: &dyn Fn(&[f64; 2]) -> bool| left.iter().filter(|l| of(l)).count();
        let allowed = |l: &[f64; 2]| l[0] > 0.0 && l[1] > 0.0;
        let best = all.iter().zip(&left).filter(|(_, l)| allowed(l));
        let best = best.max_by(|a, b| a.1[0].min(a.1[1]).total_cmp(&b.1[0].min(b.1[1])));
        Self {
            torque: count(&|l| l[0] > 0.0),
            space: count(&|l| l[1] > 0.0),
            both: count(&allowed),
            best: best.map(|(q, _)| q.clone()),
        }
    }

    /// Which limits fight, in words.
    pub fn in_words(&self, problem: &Problem) -> String {
        let percent = |n: usize| format!("{:.1} %", 100.0 * n as f64 / POSTURES as f64);
        let torque = problem
            .torque()
            .map(|_| format!("constraints.torque allows {}", percent(self.torque)));
        let space = problem
            .space()
            .map(|_| format!("constraints.space allows {}", percent(self.space)));
        let alone: Vec<String> = torque.into_iter().chain(space).collect();
        let together = match alone.len() {
            2 => format!(", both together {}", percent(self.both)),
            _ => String::new(),
        };
        format!("of random postures within the position limits {}{together}", alone.join(", "))
    }
}

/// Per posture what is left to the torque limits (part of the limit) and to the distances (part of 0.1 m, 1 at most); 1 where
/// there are none.
fn left_over(problem: &Problem, postures: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let n = problem.robot().joint_count();
    let mut left = vec![[1.0f64; 2]; postures.len()];
    if let (Some(limits), Some(prior)) = (problem.torque(), problem.layout().prior(problem.robot())) {
        // Just moving, one way and the other: friction is there as soon as anything moves.
        for speed in [-1e-9, 1e-9] {
            let motion = Motion::from_fn(n, postures.len(), |j, s| [postures[s][j], speed, 0.0]);
            let torque = inverse_dynamics_batch(problem.chain(), problem.layout(), prior.as_slice(), &motion, Coulomb::Sign);
            for (s, l) in left.iter_mut().enumerate() {
                for j in 0..n {
                    l[0] = l[0].min(1.0 - torque[j * motion.stride() + s].abs() / limits.allowed[j]);
                }
            }
        }
    }
    if let Some(set) = problem.space() {
        for (q, l) in postures.iter().zip(&mut left) {
            let nearest = set
                .nearest(problem.robot(), &|j| q[j])
                .map_or(f64::INFINITY, |(_, d)| d - set.clearance);
            l[1] = (nearest / 0.1).min(1.0);
        }
    }
    left
}

/// Within nine tenths of the range, so that there is room on both sides.
fn anywhere(joint: &Joint, rng: &mut ChaCha8Rng) -> f64 {
    let free = if joint.is_revolute() { PI } else { 0.5 };
    let [low, high] = joint.limits.position.unwrap_or([-free, free]);
    let spare = 0.05 * (high - low);
    rng.random_range(low + spare..high - spare)
}
