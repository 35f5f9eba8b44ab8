//! Minimisation subject to inequalities.

use super::{Ending, LONGEST_SOLVE_S, NOT_A_NUMBER, Objective, STOP_ANSWER, STOP_VALUE, StopRule};
use nlopt::{Algorithm, FailState, Nlopt, SuccessState, Target};
use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::rc::{Rc, Weak};

/// `g(x) ≤ 0`: m values into the second argument and, where asked for, the m × n Jacobian row by row into the third.
pub type Constraints<'a> = dyn FnMut(&[f64], &mut [f64], Option<&mut [f64]>) + 'a;

/// Where a constrained solve ended.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstrainedMinimum {
    /// The best point evaluated that meets every constraint to the tolerance; where there was none, the one that breaks them
    /// least.
    pub x: Vec<f64>,
    /// Value of the objective there.
    pub value: f64,
    /// Largest g beyond its tolerance at `x`; at most 0 where the point is feasible.
    pub violation: f64,
    /// Evaluations of the objective.
    pub evaluations: u32,
    /// Why it ended.
    pub ending: Ending,
}

struct State<'a, 'f, 'c> {
    objective: &'a mut Objective<'f>,
    constraints: &'a mut Constraints<'c>,
    tolerances: &'a [f64],
    best: ConstrainedMinimum,
    interrupted: bool,
    panic: Option<Box<dyn Any + Send>>,
    gradient: Vec<f64>,
    excess: Vec<f64>,
}

impl State<'_, '_, '_> {
    fn evaluate(&mut self, x: &[f64], gradient: Option<&mut [f64]>) -> f64 {
        if self.interrupted {
            return STOP_ANSWER;
        }
        let called = catch_unwind(AssertUnwindSafe(|| {
            (self.constraints)(x, &mut self.excess, None);
            (self.objective)(x, &mut self.gradient)
        }));
        let value = match called {
            Ok(Some(value)) => value,
            other => {
                self.interrupted = true;
                self.panic = other.err();
                return STOP_ANSWER;
            }
        };
        self.best.evaluations += 1;
        let usable = value.is_finite() && self.gradient.iter().all(|g| g.is_finite());
        if let Some(out) = gradient {
            out.fill(0.0);
            if usable {
                out.copy_from_slice(&self.gradient);
            }
        }
        if !usable {
            return NOT_A_NUMBER;
        }
        self.keep_if_better(x, value);
        value
    }

    /// Feasible before infeasible, then the lower value; among infeasible points the one that breaks constraints less.
    fn keep_if_better(&mut self, x: &[f64], value: f64) {
        let beyond = self.excess.iter().zip(self.tolerances).map(|(g, t)| g - t);
        let violation = beyond.fold(f64::NEG_INFINITY, f64::max);
        let (feasible, was) = (violation <= 0.0, self.best.violation <= 0.0);
        let better = match (feasible, was) {
            (true, true) => value < self.best.value,
            (false, false) => violation < self.best.violation,
            (feasible, _) => feasible,
        };
        if better {
            self.best.x.copy_from_slice(x);
            (self.best.value, self.best.violation) = (value, violation);
        }
    }

    fn constrain(&mut self, x: &[f64], out: &mut [f64], jacobian: Option<&mut [f64]>) {
        if self.interrupted {
            return out.fill(-1.0);
        }
        let called = catch_unwind(AssertUnwindSafe(|| (self.constraints)(x, out, jacobian)));
        if let Err(panic) = called {
            (self.interrupted, self.panic) = (true, Some(panic));
            out.fill(-1.0);
        }
    }
}

/// Minimises `objective` from `start` subject to constraints `g(x) ≤ 0`, by `LD_SLSQP` (Kraft 1988).
///
/// `tolerances` has one number for every constraint: what it may be exceeded by. NLopt itself hands back its start when it runs
/// out of evaluations between feasible points; the best point is therefore kept here.
pub fn minimize_subject_to(
    start: &[f64],
    rule: StopRule,
    objective: &mut Objective<'_>,
    constraints: &mut Constraints<'_>,
    tolerances: &[f64],
) -> ConstrainedMinimum {
    let n = start.len();
    let state = Rc::new(RefCell::new(State {
        objective,
        constraints,
        tolerances,
        best: ConstrainedMinimum {
            x: start.to_vec(),
            value: f64::INFINITY,
            violation: f64::INFINITY,
            evaluations: 0,
            ending: Ending::Failed,
        },
        interrupted: false,
        panic: None,
        gradient: vec![0.0; n],
        excess: vec![0.0; tolerances.len()],
    }));
    let result = run(start, rule, tolerances, &state);
    let state = Rc::into_inner(state).expect("the solver is gone, and constraints hold weak references");
    let state = state.into_inner();
    if let Some(panic) = state.panic {
        resume_unwind(panic);
    }
    let ending = if state.interrupted { Ending::Interrupted } else { result };
    ConstrainedMinimum { ending, ..state.best }
}

fn run(start: &[f64], rule: StopRule, tolerances: &[f64], state: &Rc<RefCell<State<'_, '_, '_>>>) -> Ending {
    let callback = |x: &[f64], gradient: Option<&mut [f64]>, state: &mut Rc<RefCell<State<'_, '_, '_>>>| {
        state.borrow_mut().evaluate(x, gradient)
    };
    // NLopt never frees what a constraint captures: a weak reference keeps nothing alive.
    let constrain =
        |out: &mut [f64], x: &[f64], jacobian: Option<&mut [f64]>, state: &mut Weak<RefCell<State<'_, '_, '_>>>| match state
            .upgrade()
        {
            Some(state) => state.borrow_mut().constrain(x, out, jacobian),
            None => out.fill(-1.0),
        };
    let mut solver = Nlopt::new(Algorithm::Slsqp, start.len(), callback, Target::Minimize, state.clone());
    let set_up = solver
        .set_maxeval(rule.max_evaluations)
        .and(solver.set_ftol_abs(rule.least_improvement))
        .and(solver.set_stopval(STOP_VALUE))
        .and(solver.set_maxtime(LONGEST_SOLVE_S))
        .and(solver.add_inequality_mconstraint(tolerances.len(), constrain, Rc::downgrade(state), tolerances));
    let mut x = start.to_vec();
    match set_up.and_then(|_| solver.optimize(&mut x).map(|(s, _)| s).map_err(|(e, _)| e)) {
        Ok(SuccessState::MaxEvalReached | SuccessState::MaxTimeReached) => Ending::EvaluationsSpent,
        Ok(_) | Err(FailState::RoundoffLimited) => Ending::Converged,
        Err(_) => Ending::Failed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: StopRule = StopRule {
        max_evaluations: 500,
        least_improvement: 1e-14,
    };

    /// Hock and Schittkowski 43 (Rosen-Suzuki): minimum −44 at (0, 1, 2, −1).
    fn rosen_suzuki(x: &[f64], g: &mut [f64]) -> Option<f64> {
        let [a, b, c, d] = [x[0], x[1], x[2], x[3]];
        g.copy_from_slice(&[2.0 * a - 5.0, 2.0 * b - 5.0, 4.0 * c - 21.0, 2.0 * d + 7.0]);
        Some(a * a + b * b + 2.0 * c * c + d * d - 5.0 * a - 5.0 * b - 21.0 * c + 7.0 * d)
    }

    fn rosen_suzuki_limits(x: &[f64], out: &mut [f64], jacobian: Option<&mut [f64]>) {
        let [a, b, c, d] = [x[0], x[1], x[2], x[3]];
        out[0] = a * a + b * b + c * c + d * d + a - b + c - d - 8.0;
        out[1] = a * a + 2.0 * b * b + c * c + 2.0 * d * d - a - d - 10.0;
        out[2] = 2.0 * a * a + b * b + c * c + 2.0 * a - b - d - 5.0;
        if let Some(j) = jacobian {
            j[..4].copy_from_slice(&[2.0 * a + 1.0, 2.0 * b - 1.0, 2.0 * c + 1.0, 2.0 * d - 1.0]);
            j[4..8].copy_from_slice(&[2.0 * a - 1.0, 4.0 * b, 2.0 * c, 4.0 * d - 1.0]);
            j[8..].copy_from_slice(&[4.0 * a + 2.0, 2.0 * b - 1.0, 2.0 * c, -1.0]);
        }
    }

    #[test]
    fn val_solves_the_problem_of_rosen_and_suzuki() {
        let found = minimize_subject_to(&[0.0; 4], RULE, &mut rosen_suzuki, &mut rosen_suzuki_limits, &[1e-10; 3]);
        assert!((found.value + 44.0).abs() < 1e-6 && found.violation <= 0.0, "{found:?}");
        for (x, expected) in found.x.iter().zip([0.0, 1.0, 2.0, -1.0]) {
            assert!((x - expected).abs() < 1e-4, "{found:?}");
        }
    }

    #[test]
    fn prop_what_is_kept_is_feasible_also_when_evaluations_run_out() {
        for most in 1..20 {
            let rule = StopRule {
                max_evaluations: most,
                ..RULE
            };
            let found = minimize_subject_to(&[0.0; 4], rule, &mut rosen_suzuki, &mut rosen_suzuki_limits, &[1e-10; 3]);
            assert!(found.violation <= 0.0 && found.value <= 0.0, "{most} {found:?}");
        }
    }

    #[test]
    fn prop_constraints_that_contradict_each_other_leave_a_violation() {
        let mut apart = |x: &[f64], out: &mut [f64], jacobian: Option<&mut [f64]>| {
            (out[0], out[1]) = (1.0 - x[0], x[0] + 1.0);
            if let Some(j) = jacobian {
                (j[0], j[1]) = (-1.0, 1.0);
            }
        };
        let mut square = |x: &[f64], g: &mut [f64]| {
            g[0] = 2.0 * x[0];
            Some(x[0] * x[0])
        };
        let found = minimize_subject_to(&[3.0], RULE, &mut square, &mut apart, &[1e-8; 2]);
        assert!(found.violation > 0.5, "{found:?}");
    }

    #[test]
    #[should_panic(expected = "from a constraint")]
    fn prop_a_panic_in_a_constraint_comes_out_again() {
        minimize_subject_to(
            &[0.0; 4],
            RULE,
            &mut rosen_suzuki,
            &mut |_, _, _| panic!("from a constraint"),
            &[1e-8],
        );
    }
}
