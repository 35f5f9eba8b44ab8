//! Motions that are worth the same: mirror images and reversal in time.
//!
//! Run backwards, a motion has the same accelerations and opposite velocities, which changes signs of friction columns only.
//! Mirrored at a plane that holds gravity, some joints turn the other way; which ones depends on the robot. All these have the
//! same singular values, so two searches that found the same joint motions may hold them as mirror images, and an exchange
//! between them is worth nothing until one is turned into the image nearest to the other.

use super::criterion::is_finite;
use super::evaluator::Evaluator;
use super::moves::{random_numbers, random_start};
use super::problem::Problem;
use super::variables::Variables;
use crate::dynamics::Coulomb;
use nalgebra::DVector;

/// The group of a problem's symmetries.
#[derive(Debug, Clone)]
pub(super) struct Symmetries {
    /// Sign of every joint's variables; the first is the identity.
    signs: Vec<Vec<f64>>,
}

/// Sign patterns tried: all up to this many joints, beyond it reversal in time alone (a thousand patterns cost 0.1 s).
const MOST_JOINTS: usize = 10;
/// Samples that tell symmetric from not: enough for full rank, else meaningless.
const SAMPLES: usize = 64;
/// Eigenvalues of a Gram matrix are exact to about `ε λ_max b`; what differs by more than this part of λ_max is not the same.
const EQUAL: f64 = 1e-10;

impl Symmetries {
    pub fn for_problem(problem: &Problem, variables: &Variables) -> Self {
        let joints = problem.robot().joint_count();
        let mut evaluator = Evaluator::new(problem, variables, SAMPLES.min(problem.samples()));
        let x = random_start(variables, &mut random_numbers(0, 0, 0));
        let mut spectrum = |x: &[f64]| {
            let gram = evaluator.gram_at(Coulomb::Smooth(0.1), x);
            // Decompositions do not end on what is not finite.
            match is_finite(&gram) {
                true => sorted(gram.symmetric_eigenvalues()),
                false => DVector::from_element(gram.nrows(), f64::INFINITY),
            }
        };
        let reference = spectrum(&x);
        let allowed = EQUAL * reference.max();
        let mut signs = vec![vec![1.0; joints]];
        // The overall sign is left to the pattern of the first joint: all 2ⁿ are tried.
        for pattern in 1..(1usize << joints.min(MOST_JOINTS)) {
            if joints > MOST_JOINTS {
                break;
            }
            let sign: Vec<f64> = (0..joints).map(|j| if pattern >> j & 1 == 1 { -1.0 } else { 1.0 }).collect();
            if (spectrum(&flipped(variables, &x, &sign)) - &reference).amax() <= allowed {
                signs.push(sign);
            }
        }
        Self { signs }
    }

    /// All images of `x`, itself first.
    pub fn images(&self, variables: &Variables, x: &[f64]) -> Vec<Vec<f64>> {
        let x = variables.settled(x);
        let reversed = variables.reversed(&x);
        let both = [x, reversed];
        both.iter()
            .flat_map(|x| self.signs.iter().map(move |s| flipped(variables, x, s)))
            .collect()
    }
}

fn sorted(mut values: DVector<f64>) -> DVector<f64> {
    values.as_mut_slice().sort_by(f64::total_cmp);
    values
}

fn flipped(variables: &Variables, x: &[f64], signs: &[f64]) -> Vec<f64> {
    let per_joint = variables.per_joint();
    x.iter().enumerate().map(|(i, v)| v * signs[i / per_joint]).collect()
}
