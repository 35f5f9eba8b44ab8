//! Global search: local solves from random starts, then around the best points found.
//!
//! The search goes in epochs ([`super::epoch`]). An epoch opens with random starts, keeps a small pool of the best niches and hops on
//! from those until nothing has improved for a while; its best point is a champion. As soon as there are two, every second epoch starts
//! from the champions instead. Searches of one problem that run beside each other hand each other their champions at the end of every
//! epoch, and one that was broken off goes on from those it had. Work is done in rounds of a fixed number of jobs, each with random numbers made from (seed, round, job),
//! and a round's results are merged in job order: the answer depends on the seed and the number of evaluations alone, not on the number
//! of threads or on which finished first. Only time and cancellation end a round early.

use super::descent::{Descended, Descent, FROM_HOP, FROM_NEAR, POLISH, ROOM_FOR_ROUNDING, drawn_in_until};
use super::epoch::{Epoch, Job, NOTICEABLE, Result};
use super::moves::{hop, random_numbers, random_start, shake};
use super::pool::{Point, Pool, is_near};
use super::problem::{Criterion, Problem};
use super::report::{Design, Outcome, StartReport, design, infeasible};
use super::space::certified_clearances;
use super::symmetry::Symmetries;
use super::torque_proof::torques_hold;
use super::variables::Variables;
use crate::trajectory::FourierSeries;
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
            jobs_per_round: 16,
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
    /// Told after every round what a search that goes on from here would need.
    fn found(&self, _found: &Found) {}
    /// Asked at the beginning and at the end of every epoch for what other searches of the same problem have found since it was last
    /// asked. An answer that depends on how fast others are makes this search depend on it too.
    fn others(&self) -> Vec<Point> {
        Vec::new()
    }
}

/// What a search has found.
pub struct Found<'a> {
    /// Epochs that are over.
    pub epochs: usize,
    pub evaluations: u64,
    variables: &'a Variables,
    champions: &'a [Point],
    running: Option<&'a Point>,
}

impl Found<'_> {
    /// Logarithm of the criterion at the best point; infinite before the first.
    pub fn best(&self) -> f64 {
        self.all().map(|p| p.value).fold(f64::INFINITY, f64::min)
    }

    /// The champions and the best point of the running epoch: the best of each niche, best first.
    pub fn points(&self) -> Vec<Point> {
        Pool::of(self.variables, self.all().cloned()).points().to_vec()
    }

    fn all(&self) -> impl Iterator<Item = &Point> {
        self.champions.iter().chain(self.running)
    }
}

/// State of a running search.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// Value of the criterion at the best point so far (the condition number, not its logarithm); infinite before the first.
    pub best: f64,
    pub starts_finished: usize,
    pub starts: usize,
    pub evaluations: u64,
    pub rounds_finished: usize,
    /// The random start that has just ended; `None` after local solves around known points.
    pub start: Option<StartReport>,
    /// What is minimised.
    pub criterion: Criterion,
}

/// What the jobs of a search share.
struct Run<'a> {
    variables: &'a Variables,
    symmetries: Symmetries,
    descent: Descent<'a>,
    seed: u64,
    control: &'a dyn Control,
    progress: Mutex<Progress>,
}

impl Run<'_> {
    /// A point brought within the limits, with its true value.
    fn known(&self, x: Vec<f64>, polished: bool) -> Point {
        let x = self.descent.admissible(x);
        let value = self.descent.true_value(&x);
        let mut progress = self.progress.lock().expect("holders of the lock do not panic");
        progress.best = progress.best.min(value.exp());
        Point { x, value, polished }
    }

    /// Takes in what other searches have found: new niches, and better points of known ones.
    fn adopt(&self, champions: &mut Vec<Point>) {
        let others = self.control.others();
        let usable = |p: &Point| p.x.len() == self.variables.len() && p.x.iter().all(|v| v.is_finite());
        // Values are computed afresh: what comes from elsewhere may be of another version of the program.
        let known: Vec<Point> = others
            .into_par_iter()
            .filter(usable)
            .map(|p| self.known(p.x, p.polished))
            .collect();
        for point in known {
            let better = |c: &Point| c.value <= point.value && is_near(self.variables, &c.x, &point.x);
            if !champions.iter().any(better) {
                champions.push(point);
            }
        }
    }

    fn round(&self, epoch: &Epoch, round: usize, jobs: usize) -> Vec<(Result, Option<StartReport>)> {
        let results = (0..jobs).into_par_iter().map(|index| self.job(epoch, round, index)).collect();
        self.progress
            .lock()
            .expect("holders of the lock do not panic")
            .rounds_finished = round + 1;
        results
    }

    fn job(&self, epoch: &Epoch, round: usize, index: usize) -> (Result, Option<StartReport>) {
        let mut rng = random_numbers(self.seed, round, index);
        let job = epoch.job(index);
        let points = epoch.pool.points();
        let mut report = None;
        let mut halfway = None;
        let end = match job {
            Job::Start => {
                let start = random_start(self.variables, &mut rng);
                let (end, course) = self.descent.run_from_random(start);
                report = Some(StartReport {
                    initial: course.first().map_or(f64::INFINITY, |p| p.1),
                    reached: end.value.exp(),
                    evaluations: end.evaluations,
                    converged: end.converged,
                    course,
                });
                end
            }
            Job::Hop => {
                let start = hop(self.variables, &self.symmetries, points, &mut rng);
                self.descent.run_while(start, &FROM_HOP, &mut |x, value| {
                    let home = points.iter().any(|p| is_near(self.variables, &p.x, x));
                    halfway = (!home).then_some(value);
                    !home && value <= epoch.promising()
                })
            }
            Job::Shake => self.descent.run(shake(self.variables, points, &mut rng), &FROM_NEAR),
            Job::Polish(at) => self.descent.run(points[at].x.clone(), &POLISH),
        };
        self.tell(&end, report.clone());
        let point = Point {
            x: end.x,
            value: end.value,
            polished: matches!(job, Job::Polish(_)),
        };
        (Result { job, point, halfway }, report)
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
    search_from(problem, options, None, control)
}

/// [`search`], going on from an earlier trajectory, which may come from another problem: it is brought within the limits of this one.
///
/// # Panics
/// If `earlier` has another number of joints than the robot.
pub fn search_from(problem: &Problem, options: &SearchOptions, earlier: Option<&FourierSeries>, control: &dyn Control) -> Design {
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
        criterion: problem.spec().criterion,
    };
    let descent = Descent::new(problem, &variables, control);
    let run = Run {
        variables: &variables,
        symmetries: Symmetries::of(problem, &variables),
        descent,
        seed: options.seed,
        control,
        progress: Mutex::new(progress),
    };
    let (mut champions, mut starts) = (Vec::<Point>::new(), Vec::new());
    if let Some(series) = earlier {
        champions.push(run.known(variables.of_series(series), false));
    }
    run.adopt(&mut champions);
    let mut epoch = match champions.is_empty() {
        true => Epoch::fresh(),
        false => Epoch::of_champions(&variables, &champions),
    };
    // One champion alone is not crossed with others.
    let mut crossed = champions.len() > 1;
    let (mut best, mut epochs, mut epochs_without_gain, mut round) = (f64::INFINITY, 0, 0, 0);
    let status = loop {
        let results = run.round(&epoch, round, options.jobs_per_round.max(1));
        round += 1;
        starts.extend(results.iter().filter_map(|r| r.1.clone()));
        let over = epoch.merge(&variables, results.into_iter().map(|r| r.0));
        if epoch.best() < best - NOTICEABLE {
            epochs_without_gain = 0;
        }
        best = best.min(epoch.best());
        if over {
            champions.extend(epoch.pool.best().cloned());
            epochs += 1;
            epochs_without_gain += 1;
        }
        control.found(&Found {
            epochs,
            evaluations: run.descent.evaluations(),
            variables: &variables,
            champions: &champions,
            running: epoch.pool.best(),
        });
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
            run.adopt(&mut champions);
            crossed = !crossed && champions.len() > 1;
            epoch = if crossed {
                Epoch::of_champions(&variables, &champions)
            } else {
                Epoch::fresh()
            };
        }
    };
    champions.extend(epoch.pool.best().cloned());
    champions.sort_by(|a, b| a.value.total_cmp(&b.value));
    match champions.first().filter(|p| has_full_rank(problem, p.value)) {
        Some(best) => design(
            problem,
            variables.series(&certified(problem, &variables, best.x.clone())),
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

/// A random trajectory within every limit, the `index`-th of a seed: where the search begins, and something to compare designs with.
///
/// Limits along the path are met by drawing it in. `None` where the arm cannot even stand where the motion starts.
pub fn random_design(problem: &Problem, seed: u64, index: usize) -> Option<FourierSeries> {
    if problem.no_room().is_some() {
        return None;
    }
    let variables = Variables::new(problem);
    let x = random_start(&variables, &mut random_numbers(seed, 0, index));
    Some(variables.series(&certified(problem, &variables, x)))
}

/// With limits along the path held between the samples too.
fn certified(problem: &Problem, variables: &Variables, x: Vec<f64>) -> Vec<f64> {
    if !problem.has_path_limits() {
        return x;
    }
    drawn_in_until(variables, x, |x| {
        let series = variables.series(x);
        let near = |set| certified_clearances(problem.robot(), set, &series);
        torques_hold(problem, &series, ROOM_FOR_ROUNDING)
            && problem
                .space()
                .is_none_or(|set| near(set).iter().all(|c| c.certified >= c.asked))
    })
}

/// A condition number at the floor that rounding sets, `1/sqrt(ε b)`, is that of a regressor with dependent columns.
fn has_full_rank(problem: &Problem, log_value: f64) -> bool {
    !problem.spec().criterion.is_condition_number() || log_value < -0.5 * (f64::EPSILON * problem.columns() as f64).ln()
}
