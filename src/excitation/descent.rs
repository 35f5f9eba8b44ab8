//! One local solve: smoothing and continuation, then the polish for the nonsmooth end.

use super::course::Course;
use super::criterion::{SmoothCriterion, true_log_value};
use super::evaluator::{Basis, Evaluator, Smoothing, basis_of};
use super::problem::{Criterion, Problem};
use super::search::Control;
use super::variables::Variables;
use super::workspace::workspace_gram;
use crate::dynamics::Coulomb;
use crate::solver::{Ending, StopRule, minimize};
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

/// One stage of a continuation: how smooth, on how many samples, for how long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stage {
    /// p of the smoothed condition number.
    pub power: f64,
    /// Velocity at which the smooth Coulomb column has reached 0.7, as a fraction of the slowest joint's top velocity.
    pub coulomb_fraction: f64,
    pub grid: Grid,
    pub max_evaluations: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Grid {
    /// About twenty samples per harmonic: M differs from that of the asked samples by less than neighbouring local minima do.
    Coarse,
    /// The asked samples.
    Asked,
}

/// From a random point to the neighbourhood of a local minimum. The first stage sees all singular values, the second the extreme
/// ones.
const FROM_RANDOM: [Stage; 2] = [
    Stage {
        power: 2.0,
        coulomb_fraction: 0.08,
        grid: Grid::Coarse,
        max_evaluations: 80,
    },
    Stage {
        power: 10.0,
        coulomb_fraction: 0.04,
        grid: Grid::Coarse,
        max_evaluations: 120,
    },
];

/// The end of a local solve. Sharp: with p = 50 the smoothed minimum lies some 2 % above the true one, more than neighbouring
/// basins differ, and improvements drown. Over 40,000 evaluations and four seeds on the paper's problem, ending at p = 200
/// instead of 50 took the mean from 61.1 to 60.4 and the best from 60.0 to 57.6; more stages, or p = 300, changed nothing more.
const SHARP: Stage = Stage {
    power: 200.0,
    coulomb_fraction: 0.015,
    grid: Grid::Coarse,
    max_evaluations: 180,
};

/// From far beside a good point to a local minimum.
pub(super) const FROM_HOP: [Stage; 2] = [
    Stage {
        power: 15.0,
        coulomb_fraction: 0.04,
        grid: Grid::Coarse,
        max_evaluations: 60,
    },
    SHARP,
];

/// From close beside a good point: p = 15 would carry it 5 % uphill, to where it was before.
pub(super) const FROM_NEAR: [Stage; 2] = [
    Stage {
        power: 50.0,
        coulomb_fraction: 0.03,
        grid: Grid::Coarse,
        max_evaluations: 60,
    },
    SHARP,
];

/// The nonsmooth end: the smoothed criterion within `ln(b)/1000` of the true one, on the asked samples.
pub(super) const POLISH: [Stage; 2] = [
    Stage {
        power: 200.0,
        coulomb_fraction: 0.012,
        grid: Grid::Asked,
        max_evaluations: 120,
    },
    Stage {
        power: 1000.0,
        coulomb_fraction: 0.008,
        grid: Grid::Asked,
        max_evaluations: 150,
    },
];

/// Weight of the excess over limits along the path, per p of the smoothed criterion. At p = 200 a limit binding for 2 % of the
/// samples is exceeded by about a percent where a percent of amplitude is worth a percent of the criterion; drawing in takes that
/// back.
const PENALTY_PER_POWER: f64 = 5.0;

/// Power of the soft minimum of the evidence in both directions: within 3.5 % of the minimum.
const SOFT_MINIMUM: f64 = 10.0;

/// Stop a stage when an iteration gains less than this relative part of the criterion; below what a user would notice.
const LEAST_IMPROVEMENT: f64 = 1e-6;

/// What all local solves of a search share.
pub(super) struct Descent<'a> {
    problem: &'a Problem,
    variables: &'a Variables,
    workspace: Option<DMatrix<f64>>,
    control: &'a dyn Control,
    evaluations: AtomicU64,
    slowest: f64,
    /// Of the asked samples: constants, and at the highest order as large as all else that an evaluation holds.
    basis: OnceLock<Arc<Basis>>,
}

/// End of a local solve.
#[derive(Debug, Clone)]
pub(super) struct Descended {
    pub x: Vec<f64>,
    /// Logarithm of the criterion of the true Y_b.
    pub value: f64,
    pub evaluations: u32,
    pub converged: bool,
}

impl<'a> Descent<'a> {
    pub fn new(problem: &'a Problem, variables: &'a Variables, control: &'a dyn Control) -> Self {
        let needs_workspace = problem.spec().criterion == Criterion::IOptimality;
        Self {
            problem,
            variables,
            workspace: needs_workspace.then(|| workspace_gram(problem)),
            control,
            evaluations: AtomicU64::new(0),
            slowest: slowest_top_velocity(problem),
            basis: OnceLock::new(),
        }
    }

    /// Evaluations of the criterion with gradient so far, by all threads.
    pub fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// Runs the stages one after the other from `start`.
    pub fn run(&self, start: Vec<f64>, stages: &[Stage]) -> Descended {
        self.run_while(start, stages, &mut |_, _| true)
    }

    /// From a random start, with its course: evaluations of its own and the criterion at its best point then.
    pub fn run_from_random(&self, start: Vec<f64>) -> (Descended, Vec<(u32, f64)>) {
        let evaluator = self.evaluator(self.samples(Grid::Coarse));
        let mut course = Course::from(&start, self.true_value(&start), evaluator, self.criterion(1.0));
        let end = self.run_watched(start, &FROM_RANDOM, &mut |_, _| true, Some(&mut course));
        let points = course.end(end.value);
        (end, points)
    }

    /// Runs the stages as long as `go_on` says so of the point and the smoothed value between two of them; a solve that is given
    /// up has an infinite value.
    pub fn run_while(&self, start: Vec<f64>, stages: &[Stage], go_on: &mut dyn FnMut(&[f64], f64) -> bool) -> Descended {
        self.run_watched(start, stages, go_on, None)
    }

    fn run_watched(
        &self,
        start: Vec<f64>,
        stages: &[Stage],
        go_on: &mut dyn FnMut(&[f64], f64) -> bool,
        mut course: Option<&mut Course>,
    ) -> Descended {
        let (mut x, mut evaluations, mut converged) = (start, 0, false);
        let mut between = None;
        for stage in self.distinct(stages) {
            if between.is_some_and(|value| !go_on(&x, value)) {
                return Descended {
                    x,
                    value: f64::INFINITY,
                    evaluations,
                    converged: false,
                };
            }
            let criterion = self.criterion(stage.power);
            let smoothing = Smoothing {
                coulomb: Coulomb::Smooth(stage.coulomb_fraction * self.slowest),
                penalty: PENALTY_PER_POWER * stage.power,
            };
            let mut evaluator = self.evaluator(self.samples(stage.grid));
            let rule = StopRule {
                max_evaluations: stage.max_evaluations,
                least_improvement: LEAST_IMPROVEMENT,
            };
            course.iter_mut().for_each(|c| c.next_stage());
            let found = minimize(&x, rule, &mut |x, gradient| {
                if self.control.halt().is_some() {
                    return None;
                }
                self.evaluations.fetch_add(1, Ordering::Relaxed);
                let value = evaluator.evaluate(&criterion, smoothing, x, gradient);
                course.iter_mut().for_each(|c| c.see(x, value));
                Some(value)
            });
            evaluations += found.evaluations;
            converged = found.ending == Ending::Converged;
            x = found.x;
            between = Some(found.value);
            if found.ending == Ending::Interrupted {
                break;
            }
        }
        let x = self.admissible(x);
        Descended {
            value: self.true_value(&x),
            x,
            evaluations,
            converged,
        }
    }

    /// Limits along the path held at the asked samples.
    pub fn admissible(&self, x: Vec<f64>) -> Vec<f64> {
        if !self.problem.has_path_limits() {
            return x;
        }
        let mut evaluator = self.evaluator(self.problem.samples());
        drawn_in_until(self.variables, x, |x| evaluator.path_holds(x, ROOM_FOR_ROUNDING))
    }

    /// Criteria other than the condition number are smooth by themselves: one stage with the budget of all.
    fn distinct(&self, stages: &[Stage]) -> Vec<Stage> {
        if self.problem.spec().criterion.is_condition_number() {
            return stages.to_vec();
        }
        let budget = stages.iter().map(|s| s.max_evaluations).sum();
        stages
            .last()
            .map(|s| Stage {
                max_evaluations: budget,
                ..*s
            })
            .into_iter()
            .collect()
    }

    /// Logarithm of the criterion at `x` with the true sign on the asked samples.
    pub fn true_value(&self, x: &[f64]) -> f64 {
        let mut evaluator = self.evaluator(self.problem.samples());
        true_log_value(&self.criterion(1.0), evaluator.gram_at(Coulomb::Sign, x))
    }

    fn evaluator(&self, samples: usize) -> Evaluator<'a> {
        let basis = match samples == self.problem.samples() {
            true => Arc::clone(self.basis.get_or_init(|| Arc::new(basis_of(self.problem, samples)))),
            false => Arc::new(basis_of(self.problem, samples)),
        };
        Evaluator::with_basis(self.problem, self.variables, samples, basis)
    }

    fn samples(&self, grid: Grid) -> usize {
        let asked = self.problem.samples();
        match grid {
            Grid::Asked => asked,
            Grid::Coarse => {
                // Effects of friction and ripple are finer than bodies are.
                let per_harmonic = if self.problem.spec().knowledge.added.is_some() {
                    80
                } else {
                    20
                };
                asked.min((per_harmonic * self.problem.spec().order).next_multiple_of(8))
            }
        }
    }

    fn criterion(&self, power: f64) -> SmoothCriterion<'_> {
        match (self.problem.spec().criterion, &self.workspace) {
            (Criterion::ScaledConditionNumber, _) => SmoothCriterion::ScaledConditionNumber { power },
            (Criterion::DOptimality, _) => SmoothCriterion::DOptimality,
            (Criterion::AOptimality, _) => SmoothCriterion::AOptimality,
            (Criterion::RivalEvidence, _) => SmoothCriterion::RivalEvidence {
                rivals: self
                    .problem
                    .spec()
                    .knowledge
                    .rivals
                    .as_ref()
                    .expect("checked with the problem"),
                base: self.problem.base().len(),
                power: SOFT_MINIMUM,
            },
            (Criterion::IOptimality, Some(workspace)) => SmoothCriterion::IOptimality {
                workspace,
                joints: self.problem.robot().joint_count(),
            },
            _ => SmoothCriterion::ConditionNumber { power },
        }
    }
}

/// Draws the motion towards rest until `holds`: at rest it does, and bisection finds a share of the motion, checked itself,
/// within a thousandth of where it ceases to.
pub(super) fn drawn_in_until(variables: &Variables, x: Vec<f64>, mut holds: impl FnMut(&[f64]) -> bool) -> Vec<f64> {
    if holds(&x) {
        return x;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while high - low > 1e-3 {
        let middle = 0.5 * (low + high);
        let fits = holds(&variables.drawn_in(&x, middle));
        *(if fits { &mut low } else { &mut high }) = middle;
    }
    variables.drawn_in(&x, low)
}

/// Coefficients are rounded to a grid at the end, by 1e-8 of themselves.
pub(super) const ROOM_FOR_ROUNDING: f64 = 1e-6;

/// Velocity [rad/s or m/s] that the slowest joint can reach: its limit, or what the highest harmonic makes of its range.
fn slowest_top_velocity(problem: &Problem) -> f64 {
    let fastest = TAU * problem.spec().fundamental_hz * problem.spec().order as f64;
    let top = |joint: &crate::model::Joint| {
        let by_range = joint
            .limits
            .position
            .map_or(f64::INFINITY, |[low, high]| 0.5 * (high - low) * fastest);
        let by_acceleration = joint
            .limits
            .acceleration
            .map_or(f64::INFINITY, |a| a / (TAU * problem.spec().fundamental_hz));
        joint
            .limits
            .velocity
            .unwrap_or(f64::INFINITY)
            .min(by_range)
            .min(by_acceleration)
    };
    let slowest = problem.robot().joints().iter().map(top).fold(f64::INFINITY, f64::min);
    if slowest.is_finite() { slowest } else { 1.0 }
}
