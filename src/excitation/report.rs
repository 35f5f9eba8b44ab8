//! What a search hands back: the trajectory, what it is worth, how far every limit is away, how it was found.

use super::criterion::Criteria;
use super::margins::{Margin, margins};
use super::problem::Problem;
use super::space::{Clearance, certified_clearances};
use super::workspace::workspace_gram;
use crate::dynamics::{ColumnSet, Coulomb, RowBlocks};
use crate::trajectory::{FourierSeries, Trajectory};
use nalgebra::{DMatrix, DVector};

/// How a search ended. Outcomes are values: every one but [`Outcome::Infeasible`] comes with a trajectory that meets all constraints.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// The best point is a local minimum of the criterion, and searching around it found nothing better for a while.
    Converged,
    /// Time or evaluations ran out while it was still improving.
    BudgetExhausted,
    /// No start got anywhere.
    Stalled,
    /// No trajectory of this kind can do it; the reason in words.
    Infeasible(String),
    Cancelled,
}

impl Outcome {
    /// Name in documents.
    pub fn name(&self) -> &'static str {
        match self {
            Outcome::Converged => "Converged",
            Outcome::BudgetExhausted => "BudgetExhausted",
            Outcome::Stalled => "Stalled",
            Outcome::Infeasible(_) => "Infeasible",
            Outcome::Cancelled => "Cancelled",
        }
    }
}

/// What became of one random start.
#[derive(Debug, Clone, PartialEq)]
pub struct StartReport {
    /// Value of the criterion at the random point, scaled into the limits.
    pub initial: f64,
    /// After its local solve.
    pub reached: f64,
    pub evaluations: u32,
    pub converged: bool,
    /// Evaluations of this start, and the criterion at its best point then; from `initial` to `reached`, closer together at first.
    pub course: Vec<(u32, f64)>,
}

/// Accuracy to be expected of an identification with this trajectory, one period.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// Torque noise assumed, one standard deviation per joint [N·m or N].
    pub torque_noise: Vec<f64>,
    /// Standard deviation of every base parameter with weighted least squares: `diag((Σ_j A_jᵀ A_j / σ_j²)⁻¹)^½`.
    pub std_dev: DVector<f64>,
    /// `100 σ / |π_b|` where all links have prior parameters.
    pub relative_std_dev_percent: Option<DVector<f64>>,
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    pub status: Outcome,
    /// Meets every constraint; at rest when infeasible.
    pub series: FourierSeries,
    /// Of the true Y_b (true sign) on the asked samples, computed afresh from `series`; `None` without a trajectory.
    pub criteria: Option<Criteria>,
    pub predicted: Option<Predicted>,
    pub margins: Vec<Margin>,
    /// Of every pair that keeps a distance, with limits in space.
    pub clearances: Vec<Clearance>,
    pub starts: Vec<StartReport>,
    pub evaluations: u64,
    pub rounds: usize,
}

/// Everything about a found trajectory, computed from its coefficients alone.
pub(super) fn design(
    problem: &Problem,
    series: FourierSeries,
    status: Outcome,
    starts: Vec<StartReport>,
    evaluations: u64,
    rounds: usize,
) -> Design {
    let (criteria, predicted) = assess(problem, &series);
    let margins = margins(problem, &series);
    let clearances = problem
        .space()
        .map_or(Vec::new(), |set| certified_clearances(problem.robot(), set, &series));
    Design {
        status,
        criteria: Some(criteria),
        predicted: Some(predicted),
        margins,
        clearances,
        series,
        starts,
        evaluations,
        rounds,
    }
}

/// No trajectory: at rest, with the reason.
pub(super) fn infeasible(problem: &Problem, reason: String) -> Design {
    let rest = (0..problem.robot().joint_count()).map(|j| problem.rest_position(j)).collect();
    let spec = problem.spec();
    Design {
        status: Outcome::Infeasible(reason),
        series: FourierSeries::at_rest(rest, spec.order, spec.fundamental_hz),
        criteria: None,
        predicted: None,
        margins: Vec::new(),
        clearances: Vec::new(),
        starts: Vec::new(),
        evaluations: 0,
        rounds: 0,
    }
}

/// Criteria and predicted accuracy of a series on the problem's samples, with the true sign.
pub fn assess(problem: &Problem, series: &FourierSeries) -> (Criteria, Predicted) {
    let motion = series.sample(problem.spec().sample_rate_hz);
    let columns = ColumnSet::new(problem.robot(), problem.layout(), &problem.base().kept);
    let mut rows = RowBlocks::new(&columns, motion.samples());
    rows.fill(problem.chain(), &columns, &motion, Coulomb::Sign);
    let y_b = rows.observation_matrix(&columns);
    let torque_noise = problem.torque_noise();
    let whitened = whiten(&y_b, &torque_noise);
    let criteria = Criteria::of(&y_b, &whitened, &workspace_gram(problem), problem.robot().joint_count());
    let std_dev = standard_deviations(&whitened);
    let prior = problem
        .layout()
        .prior(problem.robot())
        .map(|phi| problem.base().project(phi.as_slice()));
    let relative_std_dev_percent = prior.map(|pi| std_dev.zip_map(&pi, |s, v| 100.0 * s / v.abs()));
    (
        criteria,
        Predicted {
            torque_noise,
            std_dev,
            relative_std_dev_percent,
        },
    )
}

/// Every row over the noise of its joint; rows go joint by joint within a sample.
fn whiten(y_b: &DMatrix<f64>, noise: &[f64]) -> DMatrix<f64> {
    let mut whitened = y_b.clone();
    for (r, mut row) in whitened.row_iter_mut().enumerate() {
        row /= noise[r % noise.len()];
    }
    whitened
}

/// `diag((WᵀW)⁻¹)^½` by the triangular factor: row norms of `R⁻¹`.
fn standard_deviations(w: &DMatrix<f64>) -> DVector<f64> {
    let r = w.clone().qr().r();
    let inverse = r.solve_upper_triangular(&DMatrix::identity(r.ncols(), r.ncols()));
    match inverse {
        Some(inverse) => DVector::from_iterator(r.ncols(), inverse.row_iter().map(|row| row.norm())),
        None => DVector::from_element(r.ncols(), f64::INFINITY),
    }
}
