//! One evaluation of the criterion with its exact gradient: variables → coefficients → motion → Y_b → M, and the way back.

mod block;
mod path;
#[cfg(test)]
mod tests;

use super::added::Beside;
use super::criterion::SmoothCriterion;
use super::problem::{Problem, Start};
use super::variables::Variables;
use crate::dynamics::{ColumnSet, Coulomb, LANES, Motion, MotionGradient};
use crate::trajectory::harmonic;
use block::Block;
use matrixmultiply::dgemm;
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::sync::Arc;

/// How smooth an evaluation is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Smoothing {
    pub coulomb: Coulomb,
    /// Weight of the mean square of what exceeds the limits along the path.
    pub penalty: f64,
}

/// Storage and constants for evaluations on a given number of samples. One per thread.
#[derive(Debug, Clone)]
pub(super) struct Evaluator<'a> {
    problem: &'a Problem,
    variables: &'a Variables,
    columns: ColumnSet,
    /// Weight of every joint's rows in M: one for the condition number of a trajectory alone; otherwise `1/σ²` times the
    /// measurements that a sample stands for.
    row_weights: Vec<f64>,
    basis: Arc<Basis>,
    /// What is known beside the motion.
    known: Option<DMatrix<f64>>,
    motion: Motion,
    /// Columns of effects, where there are any.
    beside: Option<Beside>,
    /// The samples that rows are computed of at a time.
    block: Block,
    gradient: MotionGradient,
}

/// Numbers that the rows of one block of samples hold, 4 MB: what a core keeps near itself, and what a thread of a search holds
/// twice, whatever the number of samples.
const BLOCK_NUMBERS: usize = 500_000;

/// Values of the harmonics at the samples, for q, qd and qdd: `stride × (2L + 1)` column-major, zero in the padding.
pub(super) type Basis = [Vec<f64>; 3];

impl<'a> Evaluator<'a> {
    /// On `samples` equispaced samples of one period, the first at t = 0.
    pub fn new(problem: &'a Problem, variables: &'a Variables, samples: usize) -> Self {
        Self::with_basis(problem, variables, samples, Arc::new(basis_of(problem, samples)))
    }

    /// [`Self::new`] with the [`basis_of`] so many samples, which all threads share.
    pub fn with_basis(problem: &'a Problem, variables: &'a Variables, samples: usize, basis: Arc<Basis>) -> Self {
        Self::in_blocks(problem, variables, samples, basis, BLOCK_NUMBERS)
    }

    fn in_blocks(problem: &'a Problem, variables: &'a Variables, samples: usize, basis: Arc<Basis>, numbers: usize) -> Self {
        let joints = problem.robot().joint_count();
        let columns = ColumnSet::new(problem.robot(), problem.layout(), &problem.base().kept);
        let motion = Motion::zeros(joints, samples);
        let period = 1.0 / problem.spec().fundamental_hz;
        let added = problem.spec().knowledge.added.as_ref();
        let beside = added.map(|a| Beside::new(a, problem.base().len(), joints, period / samples as f64, motion.stride()));
        Self {
            problem,
            variables,
            row_weights: row_weights(problem, samples),
            known: problem.known_before(),
            basis,
            motion,
            beside,
            block: Block::new(&columns, samples, numbers),
            gradient: MotionGradient::new(joints, samples),
            columns,
        }
    }

    /// Value and gradient at `x`.
    pub fn evaluate(&mut self, criterion: &SmoothCriterion, smoothing: Smoothing, x: &[f64], gradient: &mut [f64]) -> f64 {
        let coulomb = smoothing.coulomb;
        let projected = self.variables.project(x);
        self.set_motion(&projected.coefficients);
        let (value, slope) = criterion.evaluate(self.gram(coulomb));
        let mut excess = 0.0;
        // The last block is still filled: where there is only one, it is filled once.
        for index in (0..self.block.count()).rev() {
            self.fill(index, coulomb);
            self.set_weights(&slope);
            excess += self.add_torque_excess(smoothing.penalty);
            self.set_gradient(coulomb);
        }
        let intrusion = self.add_intrusion(smoothing.penalty);
        if let Some(beside) = &self.beside {
            beside.add_local(&self.motion, coulomb, &mut self.gradient);
        }
        let mut to_coefficients = self.to_coefficients();
        if let Some(beside) = &self.beside {
            beside.add_course(&self.motion, coulomb, &self.basis, &mut to_coefficients);
        }
        self.variables.pull_back(&projected, &to_coefficients, gradient);
        value + excess + intrusion
    }

    /// `M` at `x` without gradient.
    pub fn gram_at(&mut self, coulomb: Coulomb, x: &[f64]) -> DMatrix<f64> {
        let projected = self.variables.project(x);
        self.set_motion(&projected.coefficients);
        self.gram(coulomb)
    }

    /// The rows of a block along the motion, unless they are those that are there.
    fn fill(&mut self, index: usize, coulomb: Coulomb) {
        if self.block.filled == Some(index) {
            return;
        }
        self.block
            .fill(index, self.problem.chain(), &self.columns, &self.motion, coulomb);
        if let Some(beside) = &mut self.beside {
            beside.join(&self.columns, &self.block.rows, self.block.first());
        }
    }

    /// All columns that are not zero on the rows of a joint, and which they are.
    fn block(&self, joint: usize) -> (&[f64], &[usize]) {
        match &self.beside {
            Some(beside) => (beside.block(joint), beside.outputs(joint)),
            None => (self.block.rows.block(joint), self.columns.row(joint)),
        }
    }

    /// The derivative by the motion of the block, from its weights.
    fn set_gradient(&mut self, coulomb: Coulomb) {
        let block = &mut self.block;
        let (chain, columns) = (self.problem.chain(), &self.columns);
        block.gradient.fill(chain, columns, &block.motion, coulomb, &block.weights);
        self.gradient.put(&block.gradient, block.first());
    }

    fn set_motion(&mut self, coefficients: &DMatrix<f64>) {
        let (stride, size, joints) = (self.motion.stride(), coefficients.nrows(), coefficients.ncols());
        self.block.filled = None;
        let parts = [&mut self.motion.q, &mut self.motion.qd, &mut self.motion.qdd];
        for (basis, part) in self.basis.iter().zip(parts) {
            multiply(
                [stride, size, joints],
                (basis, [1, stride]),
                (coefficients.as_slice(), [1, size]),
                0.0,
                part,
            );
        }
        for (j, rest) in self.variables.rest().iter().enumerate() {
            self.motion.q[j * stride..(j + 1) * stride]
                .iter_mut()
                .for_each(|q| *q += rest);
        }
        // At rest by (14c), but for rounding, which would give Coulomb friction a direction; what is returned is rounded so that
        // it has none.
        if self.problem.spec().start == Start::Zero {
            self.motion.qd.iter_mut().step_by(stride).for_each(|v| *v = 0.0);
        }
    }

    /// `M = Σ_j w_j A_jᵀ A_j` over the row blocks, and what is given.
    fn gram(&mut self, coulomb: Coulomb) -> DMatrix<f64> {
        let size = self.problem.columns();
        let mut total = self.known.clone().unwrap_or_else(|| DMatrix::zeros(size, size));
        if let Some(beside) = &mut self.beside {
            beside.see(&self.motion, coulomb);
        }
        for index in 0..self.block.count() {
            self.fill(index, coulomb);
            self.add_gram(&mut total);
        }
        total
    }

    /// Adds the part of the block that is filled.
    fn add_gram(&self, total: &mut DMatrix<f64>) {
        let stride = self.block.stride();
        let mut product = Vec::new();
        for j in 0..self.columns.joints() {
            let (block, outputs) = self.block(j);
            let width = outputs.len();
            product.resize(width * width, 0.0);
            multiply(
                [width, stride, width],
                (block, [stride, 1]),
                (block, [1, stride]),
                0.0,
                &mut product,
            );
            for (c, &column) in outputs.iter().enumerate() {
                for (r, &row) in outputs.iter().enumerate() {
                    total[(row, column)] += self.row_weights[j] * product[c * width + r];
                }
            }
        }
    }

    /// `∂F/∂Y = 2 w Y G` on the block that is filled.
    fn set_weights(&mut self, slope: &DMatrix<f64>) {
        let stride = self.block.stride();
        let first = self.block.first();
        let mut part = Vec::new();
        for j in 0..self.columns.joints() {
            let (_, outputs) = self.block(j);
            let width = outputs.len();
            let weight = 2.0 * self.row_weights[j];
            part.clear();
            for &c in outputs {
                let column = slope.column(c);
                part.extend(outputs.iter().map(|&r| weight * column[r]));
            }
            let Block { rows, weights, .. } = &mut self.block;
            let (to, sizes) = (weights.block_mut(j), [stride, width, width]);
            match &mut self.beside {
                None => multiply(sizes, (rows.block(j), [1, stride]), (&part, [1, width]), 0.0, to),
                Some(beside) => {
                    let mut all = vec![0.0; stride * width];
                    multiply(sizes, (beside.block(j), [1, stride]), (&part, [1, width]), 0.0, &mut all);
                    let base = to.len();
                    to.copy_from_slice(&all[..base]);
                    beside.set_weights(j, first, &all[base..]);
                }
            }
        }
    }

    fn to_coefficients(&self) -> DMatrix<f64> {
        let (stride, joints) = (self.motion.stride(), self.motion.joints());
        let size = self.basis[0].len() / stride;
        let mut total = DMatrix::zeros(size, joints);
        for (basis, part) in self
            .basis
            .iter()
            .zip([&self.gradient.q, &self.gradient.qd, &self.gradient.qdd])
        {
            multiply(
                [size, stride, joints],
                (basis, [stride, 1]),
                (part, [1, stride]),
                1.0,
                total.as_mut_slice(),
            );
        }
        total
    }
}

fn row_weights(problem: &Problem, samples: usize) -> Vec<f64> {
    if problem.spec().criterion.is_condition_number() && problem.given().is_none() {
        return vec![1.0; problem.robot().joint_count()];
    }
    let measurements = problem.spec().knowledge.periods * problem.samples() as f64 / samples as f64;
    problem.torque_noise().iter().map(|s| measurements / (s * s)).collect()
}

/// `C ← A B + beta C` with A m × k, B k × n, C m × n column-major; `[row stride, column stride]` beside each operand.
fn multiply([m, k, n]: [usize; 3], (a, sa): (&[f64], [usize; 2]), (b, sb): (&[f64], [usize; 2]), beta: f64, c: &mut [f64]) {
    let fits = |len: usize, rows: usize, columns: usize, s: [usize; 2]| (rows - 1) * s[0] + (columns - 1) * s[1] < len;
    assert!(m > 0 && k > 0 && n > 0 && fits(a.len(), m, k, sa) && fits(b.len(), k, n, sb) && c.len() >= m * n);
    let s = |v: usize| v as isize;
    // SAFETY: the assertion above bounds every element that the product reads or writes.
    unsafe {
        dgemm(
            m,
            k,
            n,
            1.0,
            a.as_ptr(),
            s(sa[0]),
            s(sa[1]),
            b.as_ptr(),
            s(sb[0]),
            s(sb[1]),
            beta,
            c.as_mut_ptr(),
            1,
            s(m),
        );
    }
}

/// The basis of `samples` equispaced samples of one period.
pub(super) fn basis_of(problem: &Problem, samples: usize) -> Basis {
    let stride = samples.next_multiple_of(LANES);
    basis(problem.spec().order, problem.spec().fundamental_hz, samples, stride)
}

fn basis(order: usize, fundamental_hz: f64, samples: usize, stride: usize) -> [Vec<f64>; 3] {
    debug_assert_eq!(stride % LANES, 0);
    let size = 2 * order + 1;
    let mut parts = [(); 3].map(|()| vec![0.0; stride * size]);
    for s in 0..samples {
        let t = s as f64 / (samples as f64 * fundamental_hz);
        for l in 1..=order {
            let [sine, cosine] = harmonic(TAU * fundamental_hz, l, t);
            for (d, part) in parts.iter_mut().enumerate() {
                part[(l - 1) * stride + s] = sine[d];
                part[(order + l - 1) * stride + s] = cosine[d];
            }
        }
        parts[0][2 * order * stride + s] = 1.0;
    }
    parts
}
