//! Minimisation without constraints in many variables.
//!
//! What `LD_SLSQP` (Kraft 1988) does where nothing is constrained, step for step: directions `−H ∇f`, Armijo's line search with
//! the quadratic through what is known, at least a tenth of the last step, and the BFGS update with Powell's damping (Nocedal &
//! Wright 2006, sections 6.1 and 18.3). It keeps the inverse H of the approximate Hessian, which costs `O(n²)` per step; NLopt
//! solves a least-squares problem with n inequalities for the same direction, which costs `O(n³)`.

use super::{Ending, Minimum, NOT_A_NUMBER, Objective, StopRule};
use nalgebra::{DMatrix, DVector};

/// A step is long enough when it gains this share of what the slope promises (Kraft's constant, as the others below).
const ARMIJO: f64 = 0.1;
const SHORTEST_SHARE: f64 = 0.1;
const MOST_STEPS: usize = 11;
/// Times that H is the identity, the start included.
const MOST_RESETS: usize = 5;
/// Powell's: the curvature along a step that H takes over is at least this share of the one that it has.
const LEAST_CURVATURE: f64 = 0.2;

/// A point with its value and gradient.
struct Point {
    x: DVector<f64>,
    value: f64,
    gradient: DVector<f64>,
}

/// Minimises `objective` from `start` as [`super::minimize`] does.
pub(super) fn minimize(start: &[f64], rule: StopRule, objective: &mut Objective<'_>) -> Minimum {
    let mut run = Run {
        objective,
        rule,
        best: Minimum {
            x: start.to_vec(),
            value: f64::INFINITY,
            evaluations: 0,
            ending: Ending::Converged,
        },
    };
    run.best.ending = run.descend(start).unwrap_or_else(|ending| ending);
    run.best
}

struct Run<'a, 'f> {
    objective: &'a mut Objective<'f>,
    rule: StopRule,
    best: Minimum,
}

impl Run<'_, '_> {
    fn descend(&mut self, start: &[f64]) -> Result<Ending, Ending> {
        let mut here = self.at(DVector::from_column_slice(start))?;
        let mut inverse = InverseHessian::identity(start.len());
        let (mut resets, mut first) = (1, true);
        loop {
            let direction = inverse.direction(&here.gradient);
            let slope = direction.dot(&here.gradient);
            if slope.is_nan() || slope >= 0.0 {
                if resets == MOST_RESETS {
                    return Ok(Ending::Converged);
                }
                resets += 1;
                inverse = InverseHessian::identity(start.len());
                continue;
            }
            let (there, share) = self.line_search(&here, &direction, slope)?;
            let gain = here.value - there.value;
            if there.value == NOT_A_NUMBER || (!first && gain.abs() < self.rule.least_improvement) {
                return Ok(Ending::Converged);
            }
            inverse.update(&direction, share, slope, &here.gradient, &there.gradient);
            (here, first) = (there, false);
        }
    }

    /// A point along the direction, and the share of the direction that leads there.
    fn line_search(&mut self, from: &Point, direction: &DVector<f64>, slope: f64) -> Result<(Point, f64), Ending> {
        let mut share = 1.0;
        for _ in 1..MOST_STEPS {
            let there = self.at(&from.x + direction * share)?;
            let (promised, change) = (share * slope, there.value - from.value);
            if change <= ARMIJO * promised {
                return Ok((there, share));
            }
            share *= f64::max(promised / (2.0 * (promised - change)), SHORTEST_SHARE);
        }
        Ok((self.at(&from.x + direction * share)?, share))
    }

    fn at(&mut self, x: DVector<f64>) -> Result<Point, Ending> {
        if self.best.evaluations == self.rule.max_evaluations {
            return Err(Ending::EvaluationsSpent);
        }
        let mut gradient = DVector::zeros(x.len());
        let value = (self.objective)(x.as_slice(), gradient.as_mut_slice()).ok_or(Ending::Interrupted)?;
        self.best.evaluations += 1;
        if !value.is_finite() || gradient.iter().any(|g| !g.is_finite()) {
            let value = NOT_A_NUMBER;
            return Ok(Point { x, value, gradient });
        }
        if value < self.best.value {
            self.best.value = value;
            self.best.x.copy_from_slice(x.as_slice());
        }
        Ok(Point { x, value, gradient })
    }
}

/// Inverse of the approximate Hessian B.
struct InverseHessian(DMatrix<f64>);

impl InverseHessian {
    fn identity(n: usize) -> Self {
        Self(DMatrix::identity(n, n))
    }

    fn direction(&self, gradient: &DVector<f64>) -> DVector<f64> {
        -(&self.0 * gradient)
    }

    /// The BFGS update with the step `s = share · direction` and the change y of the gradient. Since `B direction = −gradient`,
    /// Powell's damping needs no B.
    fn update(&mut self, direction: &DVector<f64>, share: f64, slope: f64, before: &DVector<f64>, after: &DVector<f64>) {
        let step = direction * share;
        let mut change = after - before;
        let curved = -share * share * slope;
        let mut along = step.dot(&change);
        if along < LEAST_CURVATURE * curved {
            let kept = (1.0 - LEAST_CURVATURE) * curved / (curved - along);
            change = change * kept - before * ((1.0 - kept) * share);
            along = LEAST_CURVATURE * curved;
        }
        let turned = &self.0 * &change;
        let twice = (1.0 + change.dot(&turned) / along) / along;
        self.0.ger(-1.0 / along, &step, &turned, 1.0);
        self.0.ger(-1.0 / along, &turned, &step, 1.0);
        self.0.ger(twice, &step, &step, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::minimize_by_slsqp;

    const RULE: StopRule = StopRule {
        max_evaluations: 2000,
        least_improvement: 1e-16,
    };

    /// Rosenbrock's function in n variables, minimum 0 at ones (Moré, Garbow & Hillstrom 1981, problem 21).
    fn rosenbrock(x: &[f64], g: &mut [f64]) -> Option<f64> {
        let mut value = 0.0;
        for (x, g) in x.chunks_exact(2).zip(g.chunks_exact_mut(2)) {
            let (u, v) = (1.0 - x[0], x[1] - x[0] * x[0]);
            g.copy_from_slice(&[-2.0 * u - 400.0 * x[0] * v, 200.0 * v]);
            value += u * u + 100.0 * v * v;
        }
        Some(value)
    }

    fn start(n: usize) -> Vec<f64> {
        (0..n)
            .map(|i| if i % 2 == 0 { -1.2 + 0.01 * i as f64 } else { 1.0 })
            .collect()
    }

    #[test]
    fn val_finds_the_minimum_of_the_extended_rosenbrock_function() {
        let found = minimize(&start(100), RULE, &mut rosenbrock);
        assert_eq!(found.ending, Ending::Converged);
        assert!(found.value < 1e-12, "{found:?}");
    }

    /// NLopt's own iteration, until rounding has grown: here the values of the first evaluations are compared.
    #[test]
    fn val_the_iterates_are_those_of_nlopts_slsqp_without_constraints() {
        let watched = |minimize: &dyn Fn(&mut Objective<'_>) -> Minimum| {
            let mut values: Vec<f64> = Vec::new();
            minimize(&mut |x, g| {
                let value = rosenbrock(x, g)?;
                // NLopt evaluates the end of a line search of several steps once more, for a gradient that it did not ask for
                // before.
                if values.last() != Some(&value) {
                    values.push(value);
                }
                Some(value)
            });
            values
        };
        let ours = watched(&|objective| minimize(&start(10), RULE, objective));
        let nlopt = watched(&|objective| minimize_by_slsqp(&start(10), RULE, objective));
        for (k, (a, b)) in ours.iter().zip(&nlopt).take(25).enumerate() {
            assert!((a - b).abs() <= 1e-6 * b.abs(), "evaluation {k}: {a} {b}");
        }
    }

    #[test]
    fn prop_stops_on_the_wish_and_at_the_most_evaluations_and_keeps_the_best() {
        let mut calls = 0;
        let found = minimize(&start(100), RULE, &mut |x, g| {
            calls += 1;
            if calls > 10 { None } else { rosenbrock(x, g) }
        });
        assert_eq!((found.ending, found.evaluations), (Ending::Interrupted, 10));
        let mut g = vec![0.0; 100];
        assert_eq!(rosenbrock(&found.x, &mut g), Some(found.value));
        let rule = StopRule {
            max_evaluations: 7,
            ..RULE
        };
        let found = minimize(&start(100), rule, &mut rosenbrock);
        assert_eq!((found.ending, found.evaluations), (Ending::EvaluationsSpent, 7));
    }

    #[test]
    fn prop_values_that_are_not_numbers_do_not_become_the_best() {
        let found = minimize(&[0.5], RULE, &mut |x, g| {
            g[0] = 1.0;
            Some(if x[0] < 0.0 { f64::NAN } else { x[0] })
        });
        assert!(found.value >= 0.0 && found.value <= 0.5);
    }
}
