//! Global search: local solves from random starts, then around the best points found.
//!
//! Work is done in rounds of a fixed number of jobs, each with random numbers of its own made from (seed, round, job). A round's
//! results are merged in job order when all are done, so the answer depends on the seed and the number of evaluations alone, not on
//! the number of threads or on which finished first. Rounds end early only when time is up or the caller cancels.

use super::criterion::{SmoothCriterion, true_log_value};
use super::evaluator::Evaluator;
use super::problem::{Criterion, Problem};
use super::report::{Design, Outcome, StartReport};
use super::solver::{Ending, Method, StopRule, minimize};
use super::variables::Variables;
use super::workspace::workspace_gram;
use crate::dynamics::Coulomb;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// How long and how widely to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchOptions {
    pub seed: u64,
    /// Random starts.
    pub starts: usize,
    /// Evaluations of the criterion after which no new round begins; the count that makes a run repeatable to the bit.
    pub max_evaluations: Option<u64>,
}

/// Why a search should end now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Halt {
    TimeUp,
    Cancelled,
}

/// What a running search tells and asks; called from many threads.
pub trait Control: Sync {
    /// Asked before every evaluation.
    fn halt(&self) -> Option<Halt>;
    /// Told after every job.
    fn progress(&self, progress: &Progress);
}

/// State of a running search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Value of the criterion at the best point so far (condition number, not its logarithm); infinite before the first.
    pub best: f64,
    pub starts_finished: usize,
    pub starts: usize,
    pub evaluations: u64,
    pub rounds_finished: usize,
}

/// One stage of a local solve: how smooth, on how many samples, for how long.
#[derive(Debug, Clone, Copy)]
struct Stage {
    /// p of the smoothed condition number.
    power: f64,
    /// Velocity at which the smoothed Coulomb column has reached 70 %, as a fraction of each... [rad/s]
    eps: f64,
    samples: usize,
    max_evaluations: u32,
}

/// A point of the search and what it is worth.
#[derive(Debug, Clone)]
struct Point {
    x: Vec<f64>,
    /// Logarithm of the criterion of the true Y_b.
    value: f64,
    polished: bool,
}

fn env(name: &str, default: f64) -> f64 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

struct Search<'a> {
    problem: &'a Problem,
    variables: &'a Variables,
    workspace: &'a DMatrix<f64>,
    control: &'a dyn Control,
    evaluations: AtomicU64,
}

impl Search<'_> {
    fn criterion(&self, power: f64) -> SmoothCriterion<'_> {
        match self.problem.spec().criterion {
            Criterion::ConditionNumber => SmoothCriterion::ConditionNumber { power },
            Criterion::DOptimality => SmoothCriterion::DOptimality,
            Criterion::AOptimality => SmoothCriterion::AOptimality,
            Criterion::IOptimality => {
                SmoothCriterion::IOptimality { workspace: self.workspace, joints: self.problem.robot().joint_count() }
            }
        }
    }

    fn true_value(&self, x: &[f64]) -> f64 {
        let mut evaluator = Evaluator::new(self.problem, self.variables, self.problem.samples());
        true_log_value(&self.criterion(1.0), evaluator.gram_at(Coulomb::Sign, x))
    }

    /// Runs the stages one after the other; (point, evaluations, whether the last stage converged).
    fn descend(&self, start: Vec<f64>, stages: &[Stage]) -> (Vec<f64>, u32, bool) {
        let (mut x, mut evaluations, mut converged) = (start, 0, false);
        for stage in stages {
            let criterion = self.criterion(stage.power);
            let mut evaluator = Evaluator::new(self.problem, self.variables, stage.samples);
            let rule = StopRule { max_evaluations: stage.max_evaluations, least_improvement: 1e-6 };
            let found = minimize(Method::Slsqp, &x, rule, &mut |x, g| {
                if self.control.halt().is_some() {
                    return None;
                }
                self.evaluations.fetch_add(1, Ordering::Relaxed);
                Some(evaluator.evaluate(&criterion, Coulomb::Smooth(stage.eps), x, g))
            });
            evaluations += found.evaluations;
            converged = found.ending == Ending::Converged;
            x = found.x;
            if found.ending == Ending::Interrupted {
                break;
            }
        }
        (x, evaluations, converged)
    }

    /// Every joint's variables brought onto its limits: radius means the same for all joints.
    fn normalised(&self, x: &[f64]) -> Vec<f64> {
        self.variables.from_coefficients(&self.variables.project(x).coefficients)
    }

    fn random_start(&self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let raw: Vec<f64> = (0..self.variables.len()).map(|_| rng.random_range(-1.0..1.0)).collect();
        self.normalised(&raw)
    }

    /// A neighbour: every joint's coefficients moved by a normal step of relative length `size`.
    fn neighbour(&self, from: &[f64], size: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let per_joint = self.variables.per_joint();
        let mut x = self.normalised(from);
        for joint in x.chunks_exact_mut(per_joint) {
            let length = joint.iter().map(|v| v * v).sum::<f64>().sqrt();
            let step = size * length / (per_joint as f64).sqrt();
            joint.iter_mut().for_each(|v| *v += step * normal(rng));
        }
        x
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    // Box and Muller; the first draw is kept from zero.
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

pub fn experiment_search(problem: &Problem, options: &SearchOptions, control: &dyn Control) -> f64 {
    let variables = Variables::new(problem);
    let workspace = workspace_gram(problem);
    let s = Search { problem, variables: &variables, workspace: &workspace, control, evaluations: AtomicU64::new(0) };
    let n1 = env("N1", 200.0) as usize;
    let batch = env("BATCH", 8.0) as usize;
    let start_stages = [
        Stage { power: 2.0, eps: 0.1, samples: n1, max_evaluations: env("C1", 100.0) as u32 },
        Stage { power: env("P2", 10.0), eps: 0.05, samples: n1, max_evaluations: env("C2", 150.0) as u32 },
    ];
    let hop_stages = [
        Stage { power: env("P2", 10.0), eps: 0.05, samples: n1, max_evaluations: env("C3", 100.0) as u32 },
        Stage { power: env("P3", 50.0), eps: 0.03, samples: n1, max_evaluations: env("C4", 150.0) as u32 },
    ];
    let polish_stages = [
        Stage { power: 200.0, eps: 0.015, samples: problem.samples(), max_evaluations: 100 },
        Stage { power: 1000.0, eps: 0.01, samples: problem.samples(), max_evaluations: 150 },
    ];
    let gens = env("GEN0", 2.0) as usize;
    let elite_size = env("ELITE", 6.0) as usize;
    let mut pool: Vec<Point> = vec![];
    let mut best_polished = f64::INFINITY;
    let t0 = std::time::Instant::now();
    for round in 0.. {
        if control.halt().is_some() { break; }
        let pool_ref = &pool;
        let results: Vec<Point> = (0..batch).into_par_iter().map(|job| {
            let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
            rng.set_stream((round as u64) << 20 | job as u64);
            let (x, stages): (Vec<f64>, &[Stage]) = if round < gens || pool_ref.is_empty() {
                (s.random_start(&mut rng), &start_stages)
            } else if job == 0 && !pool_ref[0].polished {
                (pool_ref[0].x.clone(), &polish_stages)
            } else {
                // rank-biased elite
                let u: f64 = rng.random();
                let at = ((u * u) * pool_ref.len() as f64) as usize;
                let size = (env("H0", 0.05).ln() + rng.random::<f64>() * (env("H1", 0.5) / env("H0", 0.05)).ln()).exp();
                let u: f64 = rng.random();
                if u < env("PJ", 0.3) {
                    // one joint anew
                    let pj = s.variables.per_joint();
                    let j = rng.random_range(0..s.variables.len() / pj);
                    let mut x = s.normalised(&pool_ref[at].x);
                    let y = s.random_start(&mut rng);
                    x[j * pj..(j + 1) * pj].copy_from_slice(&y[j * pj..(j + 1) * pj]);
                    (x, &hop_stages)
                } else if u < env("PJ", 0.3) + env("PC", 0.1) && pool_ref.len() > 1 {
                    let other = rng.random_range(0..pool_ref.len());
                    let pj = s.variables.per_joint();
                    let mut x = s.normalised(&pool_ref[at].x);
                    let y = s.normalised(&pool_ref[other].x);
                    for j in 0..s.variables.len() / pj { if rng.random::<bool>() { x[j * pj..(j + 1) * pj].copy_from_slice(&y[j * pj..(j + 1) * pj]); } }
                    (x, &hop_stages)
                } else {
                (s.neighbour(&pool_ref[at].x, size, &mut rng), &hop_stages)
                }
            };
            let polished = std::ptr::eq(stages, &polish_stages[..]);
            let (x, _, _) = s.descend(x, stages);
            let value = s.true_value(&x);
            Point { x, value, polished }
        }).collect();
        for r in results {
            if r.polished {
                best_polished = r.value.min(best_polished);
                if r.value < pool[0].value { pool[0] = r; } else { pool[0].polished = true; }
            } else {
                pool.push(r);
            }
        }
        pool.sort_by(|a, b| a.value.total_cmp(&b.value));
        pool.dedup_by(|a, b| (a.value - b.value).abs() < 1e-3);
        pool.truncate(elite_size);
        control.progress(&Progress { best: pool[0].value.exp(), starts_finished: 0, starts: 0, evaluations: s.evaluations.load(Ordering::Relaxed), rounds_finished: round });
        if std::env::var("V").is_ok() { println!("{:.1}s round {round} best {:.3} pool {:?}", t0.elapsed().as_secs_f64(), pool[0].value.exp(), pool.iter().map(|p| (p.value.exp() * 100.0).round() / 100.0).collect::<Vec<_>>()); }
    }
    pool[0].value.exp()
}

