//! Global search: local solves from random starts, then around the best points found.
//!
//! The search goes in epochs ([`super::epoch`]). An epoch opens with random starts, keeps a small pool of the best niches and
//! hops on from those until nothing has improved for a while; its best point is a champion. As soon as there are two, every
//! second epoch starts from the champions instead. Searches of one problem that run beside each other hand each other their
//! champions at the end of every epoch, and one that was broken off continues from those it had. Work is done in rounds of a
//! fixed number of jobs, each with random numbers made from (seed, round, job), and a round's results are merged in job order:
//! the answer depends on the seed and the number of evaluations alone, not on the number of threads or on which finished first.
//! Only time and cancellation end a round early.

mod control;
mod run;

pub use control::{Control, Found, Halt, Progress, SearchOptions};

use self::run::Run;
use super::descent::{Descent, ROOM_FOR_ROUNDING, drawn_in_until};
use super::epoch::{Epoch, NOTICEABLE};
use super::moves::{random_numbers, random_start};
use super::pool::Point;
use super::problem::Problem;
use super::report::{Design, Outcome, design, infeasible};
use super::space::certified_clearances;
use super::symmetry::Symmetries;
use super::torque_proof::torques_hold;
use super::variables::Variables;
use crate::trajectory::FourierSeries;
use std::sync::Mutex;

/// Minimises the criterion over all admissible trajectories.
///
/// Ends when `control` says so, when evaluations run out, or, with neither limit in sight, when all starts are used and two
/// epochs in a row have found nothing better. The result meets every constraint whatever ended the search.
pub fn search(problem: &Problem, options: &SearchOptions, control: &dyn Control) -> Design {
    search_from(problem, options, None, control)
}

/// [`search`], continued from an earlier trajectory, which may come from another problem: it is brought within the limits of
/// this one.
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
        symmetries: Symmetries::for_problem(problem, &variables),
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

/// A random trajectory within every limit, the `index`-th of a seed: where the search begins, and something to compare designs
/// with.
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
