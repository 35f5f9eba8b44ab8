//! The gradient held against differences, for every path of the chain rule.

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

/// As many threads as there are, each with the rows of a block: what they hold does not grow with the number of samples.
#[test]
fn prop_blocks_of_samples_add_up_to_the_whole() {
    let plain = problem(Form::Exact, Start::Zero, Criterion::DOptimality);
    for problem in [with_columns(&plain, Criterion::DOptimality), plain] {
        let variables = Variables::new(&problem);
        let x: Vec<f64> = (0..variables.len()).map(|i| ((i * 7 + 3) as f64).sin()).collect();
        let smoothing = Smoothing {
            coulomb: Coulomb::Smooth(0.1),
            penalty: 3.0,
        };
        for samples in [50, 47, 96] {
            let at = |numbers: usize| {
                let basis = Arc::new(basis_of(&problem, samples));
                let mut evaluator = Evaluator::in_blocks(&problem, &variables, samples, basis, numbers);
                let mut gradient = vec![0.0; x.len()];
                let value = evaluator.evaluate(&SmoothCriterion::DOptimality, smoothing, &x, &mut gradient);
                (evaluator.block.count(), value, gradient)
            };
            let (one, whole, slope) = at(usize::MAX);
            let (many, parts, slope_of_parts) = at(1);
            assert!(one == 1 && many == samples.div_ceil(LANES), "{one} {many}");
            // Sums in another order: rounding, times the condition of M.
            assert!((whole - parts).abs() < 1e-9 * whole.abs().max(1.0), "{whole} {parts}");
            let size = slope.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            for (a, b) in slope.iter().zip(&slope_of_parts) {
                assert!((a - b).abs() < 1e-8 * size, "{a} {b}");
            }
        }
    }
}
