//! What a search hands back: the trajectory, what it is worth, how far every limit is away, how it was found.

use super::criterion::{Criteria, is_finite};
use super::margins::{Margin, margins};
use super::problem::Problem;
use super::rivals::ExpectedEvidence;
use super::space::{Clearance, certified_clearances};
use super::workspace::workspace_gram;
use crate::trajectory::FourierSeries;
use nalgebra::{DMatrix, DVector};

/// How a search ended. Outcomes are values: every one but [`Outcome::Infeasible`] comes with a trajectory that meets all
/// constraints.
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
    /// It was cancelled.
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
    /// Evaluations of the criterion.
    pub evaluations: u32,
    /// Whether the minimiser ended at a minimum.
    pub converged: bool,
    /// Evaluations of this start, and the criterion at its best point then; from `initial` to `reached`, closer together at
    /// first.
    pub course: Vec<(u32, f64)>,
}

/// Accuracy to be expected of an identification with this trajectory, as many periods as asked for, and what is given.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// Torque noise assumed, one standard deviation per joint [N·m or N].
    pub torque_noise: Vec<f64>,
    /// Standard deviation of every base parameter with weighted least squares: `diag((Σ_j A_jᵀ A_j / σ_j²)⁻¹)^½`.
    pub std_dev: DVector<f64>,
    /// Covariance of the parameters of effects, in the order of their columns.
    pub of_effects: DMatrix<f64>,
    /// `100 σ / |π_b|` where all links have prior parameters.
    pub relative_std_dev_percent: Option<DVector<f64>>,
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// How the search ended.
    pub status: Outcome,
    /// Meets every constraint; at rest when infeasible.
    pub series: FourierSeries,
    /// Of the true Y_b (true sign) on the asked samples, computed afresh from `series`; `None` without a trajectory.
    pub criteria: Option<Criteria>,
    /// Deviations that a recording is expected to give; `None` without torque noise.
    pub predicted: Option<Predicted>,
    /// How well two rivals can be distinguished, where there are two.
    pub rivals: Option<RivalReport>,
    /// What is left to every limit.
    pub margins: Vec<Margin>,
    /// Of every pair that keeps a distance, with limits in space.
    pub clearances: Vec<Clearance>,
    /// Every start and how it ended.
    pub starts: Vec<StartReport>,
    /// Evaluations of the criterion, of all starts.
    pub evaluations: u64,
    /// Rounds of starts.
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
        rivals: rival_report(problem, &series),
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
        rivals: None,
        margins: Vec::new(),
        clearances: Vec::new(),
        starts: Vec::new(),
        evaluations: 0,
        rounds: 0,
    }
}

/// Criteria and predicted accuracy of a series on the problem's samples, with the true sign.
pub fn assess(problem: &Problem, series: &FourierSeries) -> (Criteria, Predicted) {
    let [every, whitened] = problem.factors(series);
    let torque_noise = problem.torque_noise();
    let mut all = whitened * problem.spec().knowledge.periods.sqrt();
    if let Some(given) = problem.given() {
        all = stacked(&all, &root(given));
    }
    let model = own_columns(problem, Side::Finding);
    let (rows, whitened) = (every.select_columns(&model), all.select_columns(&model));
    let workspace = workspace_gram(problem).select_rows(&model).select_columns(&model);
    // With earlier data the rows of one trajectory are a part only: its condition is that of all that is known, by its noise.
    let plain = if problem.given().is_some() { &whitened } else { &rows };
    let mut criteria = Criteria::from_regressor(plain, &whitened, &workspace, problem.robot().joint_count());
    criteria.rival_evidence = rival_report(problem, series).map(|r| r.designed.least());
    let (std_dev, of_effects) = expected_accuracies(problem, &all);
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
            of_effects,
            relative_std_dev_percent,
        },
    )
}

/// Which of two rivals is in the model.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Finding,
    Rival,
}

/// All columns but those of the rival that is not in the model: two explanations of the same residual are never estimated beside
/// each other.
fn own_columns(problem: &Problem, side: Side) -> Vec<usize> {
    let other = problem.spec().knowledge.rivals.as_ref().map(|r| match side {
        Side::Finding => r.rival.columns.clone(),
        Side::Rival => r.finding.columns.clone(),
    });
    let base = problem.base().len();
    let is_other = |c: usize| other.as_ref().is_some_and(|o| c >= base && o.contains(&(c - base)));
    (0..problem.columns()).filter(|&c| !is_other(c)).collect()
}

/// Deviations of the base parameters, and the covariance of effects, the rival's with the rival in the finding's place.
fn expected_accuracies(problem: &Problem, all: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let base = problem.base().len();
    let mut effects = DMatrix::zeros(problem.columns() - base, problem.columns() - base);
    let mut place = |columns: &[usize], covariance: &DMatrix<f64>| {
        for (r, &row) in columns[base..].iter().enumerate() {
            for (c, &column) in columns[base..].iter().enumerate() {
                effects[(row - base, column - base)] = covariance[(r, c)];
            }
        }
    };
    if problem.spec().knowledge.rivals.is_some() {
        let columns = own_columns(problem, Side::Rival);
        place(&columns, &accuracies(&all.select_columns(&columns), base).1);
    }
    let columns = own_columns(problem, Side::Finding);
    let (std_dev, covariance) = accuracies(&all.select_columns(&columns), base);
    place(&columns, &covariance);
    (std_dev, effects)
}

/// Evidence to be expected between two rivals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RivalReport {
    /// From the new trajectory alone, with what is given of all other parameters: what the search makes as large as it can.
    pub designed: ExpectedEvidence,
    /// From the data that both came from; `None` where they are not known.
    pub recorded: Option<ExpectedEvidence>,
    /// From both fitted together: what is given and the new trajectory.
    pub together: ExpectedEvidence,
}

fn rival_report(problem: &Problem, series: &FourierSeries) -> Option<RivalReport> {
    let knowledge = &problem.spec().knowledge;
    let rivals = knowledge.rivals.as_ref()?;
    let base = problem.base().len();
    let own = problem.information_of(series) * knowledge.periods;
    let together = problem.given().map_or_else(|| own.clone(), |given| given + &own);
    Some(RivalReport {
        designed: rivals.expected(&(&own + problem.given_of_others()), base),
        recorded: rivals.recorded.as_ref().map(|data| rivals.expected(data, base)),
        together: rivals.expected(&together, base),
    })
}

fn stacked(upper: &DMatrix<f64>, lower: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = upper.clone().resize_vertically(upper.nrows() + lower.nrows(), 0.0);
    both.rows_mut(upper.nrows(), lower.nrows()).copy_from(lower);
    both
}

/// F with `FᵀF = M`; what rounding has made negative counts as nothing.
fn root(information: &DMatrix<f64>) -> DMatrix<f64> {
    if !is_finite(information) {
        return DMatrix::zeros(information.nrows(), information.ncols());
    }
    let eigen = information.clone().symmetric_eigen();
    let mut rows = eigen.eigenvectors.transpose();
    for (mut row, value) in rows.row_iter_mut().zip(eigen.eigenvalues.iter()) {
        row *= value.max(0.0).sqrt();
    }
    rows
}

/// `diag((WᵀW)⁻¹)^½` of the first `base` columns and `(WᵀW)⁻¹` of the others, by the triangular factor: of `R⁻¹ R⁻ᵀ`.
fn accuracies(w: &DMatrix<f64>, base: usize) -> (DVector<f64>, DMatrix<f64>) {
    let r = w.clone().qr().r();
    let more = r.ncols() - base;
    let Some(inverse) = r.solve_upper_triangular(&DMatrix::identity(r.ncols(), r.ncols())) else {
        return (
            DVector::from_element(base, f64::INFINITY),
            DMatrix::from_element(more, more, f64::INFINITY),
        );
    };
    let rest = inverse.rows(base, more);
    (
        DVector::from_iterator(base, inverse.row_iter().take(base).map(|row| row.norm())),
        rest * rest.transpose(),
    )
}
