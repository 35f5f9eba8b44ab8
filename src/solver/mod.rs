//! The only place that knows NLopt.
//!
//! NLopt's objects are not `Send` and its callbacks are C: one optimiser is made, run and dropped inside one call, a panic in the
//! objective is caught before it can cross into C and goes on afterwards, and stopping goes through `stopval`, which every
//! algorithm honours within two evaluations.

mod constrained;
mod variable_metric;

pub use constrained::{ConstrainedMinimum, Constraints, minimize_subject_to};

use nlopt::{Algorithm, FailState, Nlopt, SuccessState, Target};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopRule {
    /// Most evaluations of the objective.
    pub max_evaluations: u32,
    /// Stop when an iteration improves f by less than this (f is a logarithm: relative change of what it is the logarithm of).
    pub least_improvement: f64,
}

/// Where the solver ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// The best point evaluated, which need not be the last.
    pub x: Vec<f64>,
    /// Value of the objective there.
    pub value: f64,
    /// Evaluations of the objective.
    pub evaluations: u32,
    /// Why it ended.
    pub ending: Ending,
}

/// Why a minimisation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Improvement per iteration fell below the rule, or to rounding.
    Converged,
    /// The evaluations are spent.
    EvaluationsSpent,
    /// The objective asked to stop.
    Interrupted,
    /// NLopt gave up; the best point is still the best point.
    Failed,
}

/// Value at a point, or the wish to stop. The gradient goes into the second argument.
pub type Objective<'a> = dyn FnMut(&[f64], &mut [f64]) -> Option<f64> + 'a;

struct State<'a, 'f> {
    objective: &'a mut Objective<'f>,
    best: Vec<f64>,
    value: f64,
    evaluations: u32,
    interrupted: bool,
    panic: Option<Box<dyn Any + Send>>,
    gradient: Vec<f64>,
}

/// Below any value an objective here can have (logarithms of ratios of doubles lie within ±1500).
const STOP_VALUE: f64 = -1e200;
const STOP_ANSWER: f64 = -1e250;
/// Stands for values that are not numbers: NLopt would go on with a NaN until its time is up.
const NOT_A_NUMBER: f64 = 1e100;

impl State<'_, '_> {
    fn evaluate(&mut self, x: &[f64], gradient: Option<&mut [f64]>) -> f64 {
        if self.interrupted {
            return STOP_ANSWER;
        }
        let called = catch_unwind(AssertUnwindSafe(|| (self.objective)(x, &mut self.gradient)));
        match called {
            Ok(Some(value)) => {
                self.evaluations += 1;
                let usable = value.is_finite() && self.gradient.iter().all(|g| g.is_finite());
                if let Some(out) = gradient {
                    if usable {
                        out.copy_from_slice(&self.gradient)
                    } else {
                        out.fill(0.0)
                    }
                }
                if usable && value < self.value {
                    self.value = value;
                    self.best.copy_from_slice(x);
                }
                if usable { value } else { NOT_A_NUMBER }
            }
            other => {
                self.interrupted = true;
                self.panic = other.err();
                STOP_ANSWER
            }
        }
    }
}

/// Most variables that NLopt is asked to minimise over without constraints. Its direction costs `O(n³)`: the 77 of an arm of
/// seven joints at order 5 are a small part of a search, the 266 at order 20 took 57 % of it.
const MOST_FOR_NLOPT: usize = 80;

/// Minimises `objective` from `start` without constraints, by `LD_SLSQP` (Kraft 1988), which then is a dense BFGS with line
/// search; with more variables than 80 by the same method with a direction that costs `O(n²)`. The start counts as the best point
/// until a better one is evaluated.
pub fn minimize(start: &[f64], rule: StopRule, objective: &mut Objective<'_>) -> Minimum {
    if start.len() > MOST_FOR_NLOPT {
        return variable_metric::minimize(start, rule, objective);
    }
    minimize_by_slsqp(start, rule, objective)
}

fn minimize_by_slsqp(start: &[f64], rule: StopRule, objective: &mut Objective<'_>) -> Minimum {
    let n = start.len();
    let state = State {
        objective,
        best: start.to_vec(),
        value: f64::INFINITY,
        evaluations: 0,
        interrupted: false,
        panic: None,
        gradient: vec![0.0; n],
    };
    let callback = |x: &[f64], gradient: Option<&mut [f64]>, state: &mut State<'_, '_>| state.evaluate(x, gradient);
    let mut solver = Nlopt::new(Algorithm::Slsqp, n, callback, Target::Minimize, state);
    let set_up = solver
        .set_maxeval(rule.max_evaluations)
        .and(solver.set_ftol_abs(rule.least_improvement))
        .and(solver.set_stopval(STOP_VALUE))
        // The search decides about time; this only bounds a solver that would loop without evaluating.
        .and(solver.set_maxtime(LONGEST_SOLVE_S));
    let mut x = start.to_vec();
    let ending = match set_up.and_then(|_| solver.optimize(&mut x).map(|(s, _)| s).map_err(|(e, _)| e)) {
        Ok(SuccessState::MaxEvalReached | SuccessState::MaxTimeReached) => Ending::EvaluationsSpent,
        Ok(_) | Err(FailState::RoundoffLimited) => Ending::Converged,
        Err(_) => Ending::Failed,
    };
    let state = solver.recover_user_data();
    if let Some(panic) = state.panic {
        resume_unwind(panic);
    }
    let ending = if state.interrupted { Ending::Interrupted } else { ending };
    Minimum {
        x: state.best,
        value: state.value,
        evaluations: state.evaluations,
        ending,
    }
}

/// One day: longer than any search that is asked for.
const LONGEST_SOLVE_S: f64 = 86_400.0;

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: StopRule = StopRule {
        max_evaluations: 500,
        least_improvement: 1e-14,
    };

    /// Rosenbrock's valley, minimum 0 at (1, 1).
    fn rosenbrock(x: &[f64], g: &mut [f64]) -> Option<f64> {
        let (u, v) = (1.0 - x[0], x[1] - x[0] * x[0]);
        g[0] = -2.0 * u - 400.0 * x[0] * v;
        g[1] = 200.0 * v;
        Some(u * u + 100.0 * v * v)
    }

    #[test]
    fn val_finds_the_minimum_of_rosenbrocks_valley() {
        let found = minimize(&[-1.2, 1.0], RULE, &mut rosenbrock);
        assert!(found.value < 1e-10, "{found:?}");
    }

    #[test]
    fn prop_stops_within_two_evaluations_of_the_wish_and_keeps_the_best() {
        let mut calls = 0;
        let found = minimize(&[-1.2, 1.0], RULE, &mut |x, g| {
            calls += 1;
            if calls > 10 { None } else { rosenbrock(x, g) }
        });
        assert_eq!(found.ending, Ending::Interrupted);
        assert_eq!(found.evaluations, 10);
        let mut g = [0.0; 2];
        assert_eq!(rosenbrock(&found.x, &mut g), Some(found.value));
    }

    #[test]
    fn prop_values_that_are_not_numbers_do_not_become_the_best() {
        let found = minimize(&[0.5], RULE, &mut |x, g| {
            g[0] = 1.0;
            Some(if x[0] < 0.0 { f64::NAN } else { x[0] })
        });
        assert!(found.value >= 0.0 && found.value <= 0.5);
    }

    #[test]
    #[should_panic(expected = "from the objective")]
    fn prop_a_panic_in_the_objective_comes_out_again() {
        minimize(&[0.0], RULE, &mut |_, _| panic!("from the objective"));
    }
}
