//! What a search hands back: the trajectory, what it is worth, how far every limit is away, how it was found.

use super::criterion::Criteria;
use super::margins::Margin;
use crate::trajectory::FourierSeries;
use nalgebra::DVector;

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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartReport {
    /// Value of the criterion at the random point, scaled into the limits.
    pub initial: f64,
    /// After its local solve.
    pub reached: f64,
    pub evaluations: u32,
    pub converged: bool,
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
    /// Of the true Y_b (true sign) on the asked samples, computed afresh from `series`; `None` when infeasible.
    pub criteria: Option<Criteria>,
    pub predicted: Option<Predicted>,
    pub margins: Vec<Margin>,
    pub starts: Vec<StartReport>,
    pub evaluations: u64,
    pub rounds: usize,
}
