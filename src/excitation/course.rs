//! The course of a local solve, for people to watch: what the criterion was worth at its best point after so many evaluations.

use super::criterion::{SmoothCriterion, true_log_value};
use super::evaluator::Evaluator;
use crate::dynamics::Coulomb;

/// A point is taken when the evaluations have grown by this part since the last: close together at first, where the criterion
/// falls fast, and some 25 in the 200 evaluations of a random start, which cost it a twentieth of its time.
const GROWTH: f64 = 0.2;

/// Takes points of a solve that goes on.
pub(super) struct Course<'a> {
    evaluator: Evaluator<'a>,
    criterion: SmoothCriterion<'a>,
    /// What the asked samples add to the logarithm of the criterion on the few that are used here, as seen at the start.
    shift: f64,
    evaluations: u32,
    next: u32,
    /// Least smoothed value of the stage, and where.
    least: f64,
    best: Vec<f64>,
    points: Vec<(u32, f64)>,
}

impl<'a> Course<'a> {
    /// `initial`: logarithm of the true criterion at `start` on the asked samples.
    pub fn from(start: &[f64], initial: f64, mut evaluator: Evaluator<'a>, criterion: SmoothCriterion<'a>) -> Self {
        let here = true_log_value(&criterion, evaluator.gram_at(Coulomb::Sign, start));
        let shift = initial - here;
        Self {
            evaluator,
            criterion,
            shift: if shift.is_finite() { shift } else { 0.0 },
            evaluations: 0,
            next: 1,
            least: f64::INFINITY,
            best: start.to_vec(),
            points: vec![(0, initial)],
        }
    }

    /// Another stage smooths differently: its values do not compare with those before.
    pub fn next_stage(&mut self) {
        self.least = f64::INFINITY;
    }

    /// After an evaluation at `x`, with its smoothed value.
    pub fn see(&mut self, x: &[f64], smoothed: f64) {
        self.evaluations += 1;
        if smoothed < self.least {
            self.least = smoothed;
            self.best.copy_from_slice(x);
        }
        if self.evaluations < self.next {
            return;
        }
        self.next = self.evaluations + ((GROWTH * f64::from(self.evaluations)) as u32).max(1);
        let value = true_log_value(&self.criterion, self.evaluator.gram_at(Coulomb::Sign, &self.best)) + self.shift;
        self.points.push((self.evaluations, value));
    }

    /// The points, the criterion itself and not its logarithm; the last is what the solve reached.
    pub fn end(mut self, reached: f64) -> Vec<(u32, f64)> {
        self.points.retain(|p| p.0 < self.evaluations);
        self.points.push((self.evaluations, reached));
        self.points.into_iter().map(|(n, value)| (n, value.exp())).collect()
    }
}
