//! One evaluation of the criterion with its exact gradient: variables → coefficients → motion → Y_b → M, and the way back.

use super::criterion::SmoothCriterion;
use super::problem::{Criterion, Problem};
use super::variables::Variables;
use crate::dynamics::{ColumnSet, Coulomb, LANES, Motion, MotionGradient, RowBlocks};
use crate::trajectory::{FourierSeries, harmonic};
use matrixmultiply::dgemm;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

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
    /// Weight of every joint's rows in M: one for the condition number, `1/σ²` for the optimality criteria.
    row_weights: Vec<f64>,
    /// Basis of q, qd, qdd: `stride × (2L + 1)` column-major, zero in the padding.
    basis: [Vec<f64>; 3],
    motion: Motion,
    rows: RowBlocks,
    weights: RowBlocks,
    gradient: MotionGradient,
}

impl<'a> Evaluator<'a> {
    /// On `samples` equispaced samples of one period, the first at t = 0.
    pub fn new(problem: &'a Problem, variables: &'a Variables, samples: usize) -> Self {
        let joints = problem.robot().joint_count();
        let columns = ColumnSet::new(problem.robot(), problem.layout(), &problem.base().kept);
        let rows = RowBlocks::new(&columns, samples);
        let motion = Motion::zeros(joints, samples);
        let row_weights = match problem.spec().criterion {
            Criterion::ConditionNumber | Criterion::ScaledConditionNumber => vec![1.0; joints],
            _ => problem.torque_noise().iter().map(|s| 1.0 / (s * s)).collect(),
        };
        Self {
            problem,
            variables,
            row_weights,
            basis: basis(problem.spec().order, problem.spec().fundamental_hz, samples, motion.stride()),
            motion,
            weights: rows.clone(),
            rows,
            gradient: MotionGradient::new(joints, samples),
            columns,
        }
    }

    /// Value and gradient at `x`.
    pub fn evaluate(&mut self, criterion: &SmoothCriterion, smoothing: Smoothing, x: &[f64], gradient: &mut [f64]) -> f64 {
        let coulomb = smoothing.coulomb;
        let projected = self.variables.project(x);
        self.set_motion(&projected.coefficients);
        self.rows.fill(self.problem.chain(), &self.columns, &self.motion, coulomb);
        let (value, slope) = criterion.evaluate(self.gram());
        self.set_weights(&slope);
        let excess = self.add_torque_excess(smoothing.penalty);
        self.gradient
            .fill(self.problem.chain(), &self.columns, &self.motion, coulomb, &self.weights);
        let to_coefficients = self.to_coefficients();
        self.variables.pull_back(&projected, &to_coefficients, gradient);
        value + excess
    }

    /// `M` at `x` without gradient.
    pub fn gram_at(&mut self, coulomb: Coulomb, x: &[f64]) -> DMatrix<f64> {
        let projected = self.variables.project(x);
        self.set_motion(&projected.coefficients);
        self.rows.fill(self.problem.chain(), &self.columns, &self.motion, coulomb);
        self.gram()
    }

    /// Largest torque of every joint over what it is allowed, and the sample where, at `x` with the true sign; empty without torque limits.
    pub fn torque_peaks(&mut self, x: &[f64]) -> Vec<TorquePeak> {
        self.peaks(&self.variables.project(x).coefficients)
    }

    /// The same of a finished series.
    pub fn torque_peaks_of(&mut self, series: &FourierSeries) -> Vec<TorquePeak> {
        let order = series.order();
        let coefficients = DMatrix::from_fn(2 * order + 1, series.offset.len(), |i, j| match i {
            i if i < order => series.a[(j, i)],
            i if i < 2 * order => series.b[(j, i - order)],
            _ => series.offset[j] - self.variables.rest()[j],
        });
        self.peaks(&coefficients)
    }

    fn peaks(&mut self, coefficients: &DMatrix<f64>) -> Vec<TorquePeak> {
        self.set_motion(coefficients);
        self.rows
            .fill(self.problem.chain(), &self.columns, &self.motion, Coulomb::Sign);
        let Some(limits) = self.problem.torque() else {
            return Vec::new();
        };
        let mut torque = Vec::new();
        (0..self.columns.joints())
            .map(|j| {
                self.torque_of(j, &limits.base, &mut torque);
                TorquePeak::of(&torque, self.motion.velocities(j), limits.allowed[j])
            })
            .collect()
    }

    /// `τ_j = Y_b,j π` over the samples.
    fn torque_of(&self, joint: usize, base: &[f64], torque: &mut Vec<f64>) {
        let (stride, samples) = (self.rows.stride(), self.motion.samples());
        torque.clear();
        torque.resize(samples, 0.0);
        for (c, &column) in self.columns.row(joint).iter().enumerate() {
            let values = &self.rows.block(joint)[c * stride..c * stride + samples];
            torque.iter_mut().zip(values).for_each(|(t, y)| *t += y * base[column]);
        }
    }

    /// Adds `penalty · mean over samples of Σ_j max(0, |τ_j|/allowed_j − 1)²`: its derivative by Y to the weights, its value to the criterion.
    fn add_torque_excess(&mut self, penalty: f64) -> f64 {
        let Some(limits) = self.problem.torque() else { return 0.0 };
        let (stride, samples) = (self.rows.stride(), self.motion.samples());
        let (mut torque, mut total) = (Vec::new(), 0.0);
        for j in 0..self.columns.joints() {
            self.torque_of(j, &limits.base, &mut torque);
            let allowed = limits.allowed[j];
            for t in torque.iter_mut() {
                let excess = (t.abs() / allowed - 1.0).max(0.0);
                total += penalty / samples as f64 * excess * excess;
                *t = penalty / samples as f64 * 2.0 * excess * t.signum() / allowed;
            }
            for (c, &column) in self.columns.row(j).iter().enumerate() {
                let weights = &mut self.weights.block_mut(j)[c * stride..c * stride + samples];
                weights
                    .iter_mut()
                    .zip(&torque)
                    .for_each(|(w, t)| *w += t * limits.base[column]);
            }
        }
        total
    }

    fn set_motion(&mut self, coefficients: &DMatrix<f64>) {
        let (stride, size, joints) = (self.motion.stride(), coefficients.nrows(), coefficients.ncols());
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
    }

    /// `M = Σ_j w_j A_jᵀ A_j` over the row blocks.
    fn gram(&self) -> DMatrix<f64> {
        let stride = self.rows.stride();
        let mut total = DMatrix::zeros(self.columns.len(), self.columns.len());
        let mut product = Vec::new();
        for j in 0..self.columns.joints() {
            let (block, outputs) = (self.rows.block(j), self.columns.row(j));
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
        total
    }

    /// `∂F/∂Y = 2 w Y G`, block by block.
    fn set_weights(&mut self, slope: &DMatrix<f64>) {
        let stride = self.rows.stride();
        let mut part = Vec::new();
        for j in 0..self.columns.joints() {
            let outputs = self.columns.row(j);
            let width = outputs.len();
            let weight = 2.0 * self.row_weights[j];
            part.clear();
            part.extend(
                outputs
                    .iter()
                    .flat_map(|&c| outputs.iter().map(move |&r| weight * slope[(r, c)])),
            );
            let to = self.weights.block_mut(j);
            multiply(
                [stride, width, width],
                (self.rows.block(j), [1, stride]),
                (&part, [1, width]),
                0.0,
                to,
            );
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

/// Extremes of one joint's torque over the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TorquePeak {
    /// Lowest and highest torque [N·m or N], and the samples where.
    pub lowest: (f64, usize),
    pub highest: (f64, usize),
    /// Largest change from one sample to the next, around the period, the jumps of friction at standstill left out: both their sides
    /// are among the samples.
    pub largest_smooth_step: f64,
    pub allowed: f64,
}

impl TorquePeak {
    fn of(torque: &[f64], velocity: &[f64], allowed: f64) -> Self {
        let numbered = || torque.iter().copied().zip(0..);
        let least = |a: (f64, usize), b: (f64, usize)| if b.0 < a.0 { b } else { a };
        let most = |a: (f64, usize), b: (f64, usize)| if b.0 > a.0 { b } else { a };
        let size = torque.len();
        let smooth = |s: &usize| Coulomb::Sign.value(velocity[*s]) == Coulomb::Sign.value(velocity[(s + 1) % size]);
        let steps = (0..size).filter(smooth).map(|s| (torque[(s + 1) % size] - torque[s]).abs());
        Self {
            lowest: numbered().fold((f64::INFINITY, 0), least),
            highest: numbered().fold((f64::NEG_INFINITY, 0), most),
            largest_smooth_step: steps.fold(0.0, f64::max),
            allowed,
        }
    }

    /// Largest magnitude over what is allowed.
    pub fn used(&self) -> f64 {
        self.highest.0.max(-self.lowest.0) / self.allowed
    }

    /// The same with room for what lies between two samples.
    pub fn used_between_samples(&self) -> f64 {
        self.used() + 0.5 * self.largest_smooth_step / self.allowed
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::problem::{Form, ProblemSpec, Start};
    use crate::model::{Friction, Joint, JointKind, Limits, Mdh, Robot};
    use nalgebra::Vector3;

    /// A sliding joint between two turning ones, off-centre limits: every path of the chain rule.
    fn problem(form: Form, start: Start, criterion: Criterion) -> Problem {
        let kinds = [JointKind::Revolute, JointKind::Prismatic, JointKind::Revolute];
        let joints = kinds.into_iter().enumerate().map(|(i, kind)| {
            let mdh = Mdh {
                alpha: 0.8 * i as f64,
                d: 0.1,
                theta: 0.2,
                r: 0.3,
            };
            let limits = Limits {
                position: Some([-1.0, 1.7]),
                velocity: Some(1.2),
                acceleration: Some(4.0),
                ..Limits::unlimited()
            };
            Joint::from_mdh(format!("j{i}"), kind, mdh).with_limits(limits)
        });
        let friction = Friction {
            viscous: true,
            coulomb: true,
        };
        let robot = Robot::new("test", Vector3::new(0.0, 2.0, -9.0), joints.collect(), friction).unwrap();
        let spec = ProblemSpec {
            robot,
            order: 4,
            fundamental_hz: 0.2,
            sample_rate_hz: 10.0,
            criterion,
            form,
            start,
            start_position: None,
            torque_noise: Some(vec![0.5, 2.0, 0.1]),
            torque: None,
        };
        Problem::new(spec).unwrap()
    }

    #[test]
    fn prop_gradient_equals_differences_for_every_form_start_and_criterion() {
        let criteria = [Criterion::ConditionNumber, Criterion::DOptimality, Criterion::AOptimality];
        for form in [Form::Paper, Form::Exact] {
            for start in [Start::Zero, Start::Free] {
                for criterion in criteria {
                    let problem = problem(form, start, criterion);
                    let smooth = match criterion {
                        Criterion::DOptimality => SmoothCriterion::DOptimality,
                        Criterion::AOptimality => SmoothCriterion::AOptimality,
                        _ => SmoothCriterion::ConditionNumber { power: 5.0 },
                    };
                    assert_gradient(&problem, &smooth);
                }
            }
        }
    }

    fn assert_gradient(problem: &Problem, criterion: &SmoothCriterion) {
        let variables = Variables::new(problem);
        let mut evaluator = Evaluator::new(problem, &variables, problem.samples());
        let x: Vec<f64> = (0..variables.len()).map(|i| ((i * 7 + 3) as f64).sin()).collect();
        let mut gradient = vec![0.0; x.len()];
        let mut unused = vec![0.0; x.len()];
        let smoothing = Smoothing {
            coulomb: Coulomb::Smooth(0.1),
            penalty: 3.0,
        };
        evaluator.evaluate(criterion, smoothing, &x, &mut gradient);
        for i in 0..x.len() {
            let h = 1e-6;
            let mut at = |step: f64| {
                let mut moved = x.clone();
                moved[i] += step;
                evaluator.evaluate(criterion, smoothing, &moved, &mut unused)
            };
            let difference = (at(h) - at(-h)) / (2.0 * h);
            // Rounding: 1e-16 times the condition of M (up to 1e6 here) over h; truncation h².
            assert!(
                (difference - gradient[i]).abs() < 1e-4 * (1.0 + gradient[i].abs()),
                "{i}: {difference} {}",
                gradient[i]
            );
        }
    }
}
