//! One evaluation of the criterion with its exact gradient: variables → coefficients → motion → Y_b → M, and the way back.

use super::added::Beside;
use super::criterion::SmoothCriterion;
use super::problem::{Problem, Start};
use super::variables::Variables;
use crate::dynamics::{ColumnSet, Coulomb, LANES, Motion, MotionGradient, RowBlocks};
use crate::trajectory::harmonic;
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
    /// Weight of every joint's rows in M: one for the condition number of a trajectory alone; otherwise `1/σ²` times the measurements that a
    /// sample stands for.
    row_weights: Vec<f64>,
    /// Basis of q, qd, qdd: `stride × (2L + 1)` column-major, zero in the padding.
    basis: [Vec<f64>; 3],
    /// What is known beside the motion.
    known: Option<DMatrix<f64>>,
    motion: Motion,
    rows: RowBlocks,
    /// Columns of effects, where there are any.
    beside: Option<Beside>,
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
        let period = 1.0 / problem.spec().fundamental_hz;
        let added = problem.spec().knowledge.added.as_ref();
        let beside = added.map(|a| Beside::new(a, problem.base().len(), joints, period / samples as f64, motion.stride()));
        Self {
            problem,
            variables,
            row_weights: row_weights(problem, samples),
            known: problem.known_before(),
            basis: basis(problem.spec().order, problem.spec().fundamental_hz, samples, motion.stride()),
            motion,
            weights: rows.clone(),
            rows,
            beside,
            gradient: MotionGradient::new(joints, samples),
            columns,
        }
    }

    /// Value and gradient at `x`.
    pub fn evaluate(&mut self, criterion: &SmoothCriterion, smoothing: Smoothing, x: &[f64], gradient: &mut [f64]) -> f64 {
        let coulomb = smoothing.coulomb;
        let projected = self.variables.project(x);
        self.set_motion(&projected.coefficients);
        self.fill(coulomb);
        let (value, slope) = criterion.evaluate(self.gram());
        self.set_weights(&slope);
        let excess = self.add_torque_excess(smoothing.penalty);
        self.gradient
            .fill(self.problem.chain(), &self.columns, &self.motion, coulomb, &self.weights);
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
        self.fill(coulomb);
        self.gram()
    }

    fn fill(&mut self, coulomb: Coulomb) {
        self.rows.fill(self.problem.chain(), &self.columns, &self.motion, coulomb);
        if let Some(beside) = &mut self.beside {
            beside.fill(&self.columns, &self.rows, &self.motion, coulomb);
        }
    }

    /// All columns that are not zero on the rows of a joint, and which they are.
    fn block(&self, joint: usize) -> (&[f64], &[usize]) {
        match &self.beside {
            Some(beside) => (beside.block(joint), beside.outputs(joint)),
            None => (self.rows.block(joint), self.columns.row(joint)),
        }
    }

    /// Largest torque of every joint over what it is allowed, at the samples of `x` with the true sign; none without torque limits.
    fn torque_used(&mut self, x: &[f64]) -> Vec<f64> {
        self.set_motion(&self.variables.project(x).coefficients);
        self.rows
            .fill(self.problem.chain(), &self.columns, &self.motion, Coulomb::Sign);
        let Some(limits) = self.problem.torque() else {
            return Vec::new();
        };
        let mut torque = Vec::new();
        (0..self.columns.joints())
            .map(|j| {
                self.torque_of(j, &limits.base, &mut torque);
                torque.iter().fold(0.0f64, |most, t| most.max(t.abs())) / limits.allowed[j]
            })
            .collect()
    }

    /// Whether all limits along the path hold at the samples, with the true sign; `room` of each limit is left for rounding.
    pub fn path_holds(&mut self, x: &[f64], room: f64) -> bool {
        let torques = self.torque_used(x);
        let (robot, motion) = (self.problem.robot(), &self.motion);
        torques.iter().all(|used| *used <= 1.0 - room) && self.problem.space().is_none_or(|set| set.holds(robot, motion, room))
    }

    /// Adds what comes too near in space to the gradient, and returns its part of the criterion.
    fn add_intrusion(&mut self, penalty: f64) -> f64 {
        let Some(set) = self.problem.space() else { return 0.0 };
        set.add_excess(self.problem.robot(), &self.motion, penalty, &mut self.gradient.q)
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
        // At rest by (14c), but for rounding, which would give Coulomb friction a direction; what is returned is rounded so that it has none.
        if self.problem.spec().start == Start::Zero {
            self.motion.qd.iter_mut().step_by(stride).for_each(|v| *v = 0.0);
        }
    }

    /// `M = Σ_j w_j A_jᵀ A_j` over the row blocks, and what is given.
    fn gram(&self) -> DMatrix<f64> {
        let stride = self.rows.stride();
        let size = self.problem.columns();
        let mut total = self.known.clone().unwrap_or_else(|| DMatrix::zeros(size, size));
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
        total
    }

    /// `∂F/∂Y = 2 w Y G`, block by block.
    fn set_weights(&mut self, slope: &DMatrix<f64>) {
        let stride = self.rows.stride();
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
            let to = self.weights.block_mut(j);
            let Some(beside) = &mut self.beside else {
                let sizes = [stride, width, width];
                multiply(sizes, (self.rows.block(j), [1, stride]), (&part, [1, width]), 0.0, to);
                continue;
            };
            let block = beside.block(j).to_vec();
            let all = beside.weights_mut(j);
            multiply([stride, width, width], (&block, [1, stride]), (&part, [1, width]), 0.0, all);
            to.copy_from_slice(&all[..to.len()]);
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
    use crate::excitation::added::{Added, AddedColumn, AddedColumns, Course};
    use crate::excitation::problem::{Criterion, Form, Given, Knowledge, ProblemSpec, Start};
    use crate::excitation::rivals::{Hypothesis, Rivals};
    use crate::model::{Friction, Joint, JointKind, Limits, Mdh, Robot};
    use nalgebra::Vector3;
    use std::sync::Arc;

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
            space: None,
            harmonics: None,
            knowledge: Knowledge::default(),
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

    /// A column of one sample's states with a sign in it, and one that looks at the sample before.
    #[derive(Debug)]
    struct Stand;

    impl AddedColumns for Stand {
        fn count(&self) -> usize {
            2
        }

        fn groups(&self) -> usize {
            2
        }

        fn columns(&self, group: usize, course: &Course) -> Vec<AddedColumn> {
            let (motion, n) = (course.motion, course.motion.samples());
            let local = |s: usize| {
                let ([q, v, _], [p, _, a]) = (motion.get(0, s), motion.get(2, s));
                (3.0 * q).sin() * course.coulomb.value(v) + 0.2 * p * a
            };
            let late = |s: usize| {
                let before = motion.get(1, (s + n - 1) % n);
                before[0] * motion.get(1, s)[1] + 0.1 * before[2]
            };
            let column = |rows: Vec<(usize, Vec<f64>)>| vec![AddedColumn { at: group, rows }];
            match group {
                0 => column(vec![
                    (0, (0..n).map(local).collect()),
                    (2, (0..n).map(|s| 2.0 * local(s)).collect()),
                ]),
                _ => column(vec![(1, (0..n).map(late).collect())]),
            }
        }

        fn joints(&self, group: usize) -> Vec<usize> {
            [vec![0, 2], vec![1]][group].clone()
        }

        fn is_local(&self, group: usize) -> bool {
            group == 0
        }
    }

    /// `problem` with the columns of [`Stand`] beside its own, and something known before.
    fn with_columns(problem: &Problem, criterion: Criterion) -> Problem {
        let side = |at: usize, value: f64| Hypothesis {
            columns: at..at + 1,
            values: vec![value],
            borders: Vec::new(),
        };
        let rivals = Rivals {
            finding: side(0, 0.4),
            rival: side(1, 0.7),
            recorded: None,
            nested: [false; 2],
        };
        let size = problem.base().len() + 2;
        let known = DMatrix::from_fn(size, size, |r, c| if r == c { 0.3 } else { 0.01 * ((r * c) as f64).cos() });
        let knowledge = Knowledge {
            added: Some(Added(Arc::new(Stand))),
            rivals: Some(rivals),
            given: vec![Given::Information(&known + known.transpose())],
            periods: 3.0,
        };
        Problem::new(ProblemSpec {
            criterion,
            knowledge,
            ..problem.spec().clone()
        })
        .unwrap()
    }

    #[test]
    fn prop_gradient_goes_through_added_columns_and_what_is_given() {
        for criterion in [Criterion::DOptimality, Criterion::RivalEvidence, Criterion::ConditionNumber] {
            let problem = with_columns(&problem(Form::Exact, Start::Free, Criterion::DOptimality), criterion);
            let smooth = match criterion {
                Criterion::DOptimality => SmoothCriterion::DOptimality,
                Criterion::RivalEvidence => SmoothCriterion::RivalEvidence {
                    rivals: problem.spec().knowledge.rivals.as_ref().unwrap(),
                    base: problem.base().len(),
                    power: 10.0,
                },
                _ => SmoothCriterion::ConditionNumber { power: 5.0 },
            };
            assert_gradient(&problem, &smooth);
        }
    }

    #[test]
    fn prop_gradient_with_harmonics_of_every_joint_s_own() {
        let whole = problem(Form::Exact, Start::Zero, Criterion::DOptimality);
        let harmonics = Some(vec![vec![1, 2, 3, 4], vec![2, 3], vec![1, 3, 4]]);
        let own = Problem::new(ProblemSpec {
            harmonics,
            ..whole.spec().clone()
        })
        .unwrap();
        assert_gradient(&own, &SmoothCriterion::DOptimality);
        let variables = Variables::new(&own);
        let x: Vec<f64> = (0..variables.len()).map(|i| ((i * 5 + 1) as f64).cos()).collect();
        let series = variables.series(&x);
        for (j, list) in [vec![1, 2, 3, 4], vec![2, 3], vec![1, 3, 4]].iter().enumerate() {
            for l in 1..=4 {
                assert_eq!(series.amplitude(j, l) > 0.0, list.contains(&l), "joint {j} harmonic {l}");
            }
            // Rest at the start, to the last bit and in either order.
            let (a, b) = (series.a.row(j), series.b.row(j));
            assert_eq!(a.iter().sum::<f64>(), 0.0);
            assert_eq!((1..=4).map(|l| l as f64 * b[l - 1]).sum::<f64>(), 0.0);
            assert_eq!((1..=4).rev().map(|l| b[l - 1] / l as f64).sum::<f64>(), 0.0);
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
