//! Global search: local solves from random starts, then around the best points found.
//!
//! The search goes in epochs. An epoch opens with random starts, keeps a small pool of the best points and goes on from those until
//! nothing has improved for a while; its best point is polished and kept as a champion. As soon as there are two, every second epoch starts from
//! the champions instead. Work is done in rounds of a fixed number of jobs, each with random numbers made from (seed, round, job), and
//! a round's results are merged in job order: the answer depends on the seed and the number of evaluations alone, not on the number
//! of threads or on which finished first. Only time and cancellation end a round early.

use super::descent::{Descended, Descent, FROM_NEIGHBOUR, FROM_RANDOM, POLISH};
use super::moves::{from_pool, random_numbers, random_start};
use super::problem::{Criterion, Problem};
use super::report::{Design, Outcome, StartReport, design, infeasible};
use super::variables::Variables;
use rayon::prelude::*;
use std::sync::Mutex;

/// How long and how widely to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchOptions {
    pub seed: u64,
    /// Random starts at least made before a search without limits may end.
    pub starts: usize,
    /// Evaluations of the criterion after which no new round begins; the count that makes a run repeatable to the bit.
    pub max_evaluations: Option<u64>,
    /// Local solves per round, at most so many run at the same time. Part of what makes a run repeatable.
    pub jobs_per_round: usize,
    /// Whether some outer limit (of time) will end the search. Without any limit it ends when it has converged.
    pub until_halted: bool,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            starts: 64,
            max_evaluations: None,
            jobs_per_round: 8,
            until_halted: false,
        }
    }
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
    /// Told after every local solve.
    fn progress(&self, progress: &Progress);
}

/// State of a running search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Value of the criterion at the best point so far (the condition number, not its logarithm); infinite before the first.
    pub best: f64,
    pub starts_finished: usize,
    pub starts: usize,
    pub evaluations: u64,
    pub rounds_finished: usize,
    /// The random start that has just ended; `None` after local solves around known points.
    pub start: Option<StartReport>,
}

/// Points that stay in the pool of an epoch: enough for exchange between different basins, few enough to press on.
const POOL: usize = 8;
/// Rounds of random starts that open an epoch.
const OPENING_ROUNDS: usize = 2;
/// Rounds without improvement of the epoch's best by more than [`NOTICEABLE`] after which it ends: with eight jobs a round, some
/// hundred local solves that led nowhere.
const PATIENCE: usize = 12;
/// Relative improvement that counts; a user cannot tell condition numbers closer than this.
const NOTICEABLE: f64 = 1e-3;
/// Points closer in value than this are one local minimum reached twice.
const SAME: f64 = 1e-4;

#[derive(Debug, Clone)]
struct Point {
    x: Vec<f64>,
    /// Logarithm of the criterion.
    value: f64,
    polished: bool,
}

/// What a job is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Job {
    Start,
    Around,
    /// Of the epoch's best.
    Polish,
}

struct Epoch {
    pool: Vec<Point>,
    opening_rounds_left: usize,
    rounds_without_gain: usize,
}

impl Epoch {
    fn fresh() -> Self {
        Self {
            pool: Vec::new(),
            opening_rounds_left: OPENING_ROUNDS,
            rounds_without_gain: 0,
        }
    }

    fn of_champions(champions: &[Point]) -> Self {
        let mut pool = champions.to_vec();
        keep_best(&mut pool);
        Self {
            pool,
            opening_rounds_left: 0,
            rounds_without_gain: 0,
        }
    }

    fn job(&self, index: usize) -> Job {
        if self.opening_rounds_left > 0 || self.pool.is_empty() {
            Job::Start
        } else if index == 0 && !self.pool[0].polished {
            Job::Polish
        } else {
            Job::Around
        }
    }

    fn best(&self) -> f64 {
        self.pool.first().map_or(f64::INFINITY, |p| p.value)
    }

    /// Takes a round's results in; tells whether the epoch is over.
    fn merge(&mut self, results: Vec<(Job, Point)>) -> bool {
        let before = self.best();
        for (job, point) in results {
            if job == Job::Polish {
                self.pool[0].polished = true;
            }
            self.pool.push(point);
        }
        keep_best(&mut self.pool);
        self.opening_rounds_left = self.opening_rounds_left.saturating_sub(1);
        let gained = self.best() < before - NOTICEABLE;
        self.rounds_without_gain = if gained || self.opening_rounds_left > 0 {
            0
        } else {
            self.rounds_without_gain + 1
        };
        self.rounds_without_gain >= PATIENCE && self.pool.first().is_some_and(|p| p.polished)
    }
}

fn keep_best(pool: &mut Vec<Point>) {
    pool.retain(|p| p.value.is_finite());
    pool.sort_by(|a, b| a.value.total_cmp(&b.value));
    pool.dedup_by(|later, kept| {
        let same = later.value - kept.value < SAME;
        kept.polished |= same && later.polished;
        same
    });
    pool.truncate(POOL);
}

/// What the jobs of a search share.
struct Run<'a> {
    variables: &'a Variables,
    descent: Descent<'a>,
    seed: u64,
    control: &'a dyn Control,
    progress: Mutex<Progress>,
}

impl Run<'_> {
    fn round(&self, epoch: &Epoch, round: usize, jobs: usize) -> Vec<(Job, Point, Option<StartReport>)> {
        let results = (0..jobs).into_par_iter().map(|index| self.job(epoch, round, index)).collect();
        self.progress
            .lock()
            .expect("holders of the lock do not panic")
            .rounds_finished = round + 1;
        results
    }

    fn job(&self, epoch: &Epoch, round: usize, index: usize) -> (Job, Point, Option<StartReport>) {
        let mut rng = random_numbers(self.seed, round, index);
        let job = epoch.job(index);
        let (start, stages) = match job {
            Job::Start => (random_start(self.variables, &mut rng), FROM_RANDOM),
            Job::Polish => (epoch.pool[0].x.clone(), POLISH),
            Job::Around => {
                let pool: Vec<&[f64]> = epoch.pool.iter().map(|p| p.x.as_slice()).collect();
                (from_pool(self.variables, &pool, &mut rng), FROM_NEIGHBOUR)
            }
        };
        let initial = if job == Job::Start {
            self.descent.true_value(&start)
        } else {
            0.0
        };
        let end = self.descent.run(start, &stages);
        let report = (job == Job::Start).then(|| StartReport {
            initial: initial.exp(),
            reached: end.value.exp(),
            evaluations: end.evaluations,
            converged: end.converged,
        });
        self.tell(&end, report);
        (
            job,
            Point {
                x: end.x,
                value: end.value,
                polished: job == Job::Polish,
            },
            report,
        )
    }

    fn tell(&self, end: &Descended, start: Option<StartReport>) {
        let mut progress = self.progress.lock().expect("holders of the lock do not panic");
        progress.best = progress.best.min(end.value.exp());
        progress.starts_finished += usize::from(start.is_some());
        progress.start = start;
        progress.evaluations = self.descent.evaluations();
        self.control.progress(&progress);
    }
}

/// Minimises the criterion over all admissible trajectories.
///
/// Ends when `control` says so, when evaluations run out, or, with neither limit in sight, when all starts are used and two epochs in
/// a row have found nothing better. The result meets every constraint whatever ended the search.
pub fn search(problem: &Problem, options: &SearchOptions, control: &dyn Control) -> Design {
    if let Some(reason) = problem.no_room() {
        return infeasible(problem, reason);
    }
    let variables = Variables::new(problem);
    let progress = Progress {
        best: f64::INFINITY,
        starts_finished: 0,
        starts: options.starts,
        evaluations: 0,
        rounds_finished: 0,
        start: None,
    };
    let descent = Descent::new(problem, &variables, control);
    let run = Run {
        variables: &variables,
        descent,
        seed: options.seed,
        control,
        progress: Mutex::new(progress),
    };
    let (mut champions, mut starts) = (Vec::<Point>::new(), Vec::new());
    let mut epoch = Epoch::fresh();
    let (mut best, mut epochs_without_gain, mut round) = (f64::INFINITY, 0, 0);
    let status = loop {
        let results = run.round(&epoch, round, options.jobs_per_round.max(1));
        round += 1;
        starts.extend(results.iter().filter_map(|r| r.2));
        let over = epoch.merge(results.into_iter().map(|(job, point, _)| (job, point)).collect());
        if epoch.best() < best - NOTICEABLE {
            epochs_without_gain = 0;
        }
        best = best.min(epoch.best());
        if over {
            champions.push(epoch.pool[0].clone());
            epochs_without_gain += 1;
        }
        let spent = options.max_evaluations.is_some_and(|most| run.descent.evaluations() >= most);
        let halt = control.halt();
        if halt == Some(Halt::Cancelled) {
            break Outcome::Cancelled;
        }
        if halt.is_some() || spent {
            break if epochs_without_gain > 0 {
                Outcome::Converged
            } else {
                Outcome::BudgetExhausted
            };
        }
        let unlimited = !options.until_halted && options.max_evaluations.is_none();
        if unlimited && starts.len() >= options.starts && epochs_without_gain >= 2 {
            break Outcome::Converged;
        }
        if over {
            epoch = if champions.len() % 2 == 0 {
                Epoch::of_champions(&champions)
            } else {
                Epoch::fresh()
            };
        }
    };
    champions.extend(epoch.pool);
    keep_best(&mut champions);
    match champions.first().filter(|p| has_full_rank(problem, p.value)) {
        Some(best) => design(
            problem,
            variables.series(&best.x),
            status,
            starts,
            run.descent.evaluations(),
            round,
        ),
        None if status == Outcome::Cancelled => Design {
            status,
            ..infeasible(problem, String::new())
        },
        None => infeasible(
            problem,
            "no start made all base parameters visible: the order is too low, or the limits leave too little motion".into(),
        ),
    }
}

/// A condition number at the floor that rounding sets, `1/sqrt(ε b)`, is that of a regressor with dependent columns.
fn has_full_rank(problem: &Problem, log_value: f64) -> bool {
    problem.spec().criterion != Criterion::ConditionNumber || log_value < -0.5 * (f64::EPSILON * problem.base().len() as f64).ln()
}
