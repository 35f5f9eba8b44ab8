//! A request as it was made: criterion, form, start, and what is known already.

use crate::excitation::added::Added;
use crate::excitation::path::TorqueLimits;
use crate::excitation::rivals::Rivals;
use crate::excitation::space::SpaceLimits;
use crate::model::Robot;
use crate::trajectory::FourierSeries;
use nalgebra::DMatrix;

/// What makes one trajectory better than another; all are functions of the Gram matrix `M = Y_bᵀ Y_b`, the columns of effects
/// beside those of `Y_b` where there are any, and are minimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// `cond(Y_b) = sqrt(λ_max / λ_min)`, the paper's (13).
    ConditionNumber,
    /// The condition number after scaling every column of Y_b to length one: does not depend on units.
    ScaledConditionNumber,
    /// `det(M)^(−1/(2b))`: the geometric mean of the standard deviations along the principal directions.
    DOptimality,
    /// `sqrt(tr(M⁻¹)/b)`: the root-mean-square standard deviation of the base parameters.
    AOptimality,
    /// `sqrt(tr(M⁻¹ C)/n)`, C the mean of `Y_bᵀ Y_b` over random states inside the limits: the expected torque-prediction error.
    IOptimality,
    /// One over the root of the expected BIC difference between two explanations of a residual ([`crate::excitation::Rivals`]),
    /// in the worse of the two cases.
    RivalEvidence,
}

impl Criterion {
    /// Whether it is a ratio of singular values, which has kinks where they meet.
    pub fn is_condition_number(self) -> bool {
        matches!(self, Self::ConditionNumber | Self::ScaledConditionNumber)
    }
}

/// How limits on the series become constraints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// (14d)–(14g): triangle-inequality bounds and boxes on the coefficients. Sufficient, not necessary.
    Paper,
    /// The true extremes over time, certified between the samples.
    Exact,
}

/// Where the motion starts; it starts and ends at rest without acceleration either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// At the start position (14c).
    Zero,
    /// Anywhere: the robot moves there first. The mean position of every joint becomes a variable.
    Free,
}

/// What is known already, whose information is added to that of the new trajectory.
#[derive(Debug, Clone, PartialEq)]
pub enum Given {
    /// A trajectory that has been or will be recorded, so many periods of it, with the noise of the problem.
    Motion {
        /// The trajectory.
        series: FourierSeries,
        /// Periods of it.
        periods: f64,
    },
    /// `WᵀW` over all columns, rows over their noise.
    Information(DMatrix<f64>),
}

/// What the information matrix holds beside one period of `Y_b`.
#[derive(Debug, Clone, PartialEq)]
pub struct Knowledge {
    /// Columns of effects beside the regressor's.
    pub added: Option<Added>,
    /// Two of the effects, for [`Criterion::RivalEvidence`].
    pub rivals: Option<Rivals>,
    /// Trajectories that are recorded anyway, whose information counts.
    pub given: Vec<Given>,
    /// Periods of the new trajectory that will be recorded.
    pub periods: f64,
}

impl Default for Knowledge {
    fn default() -> Self {
        Self {
            added: None,
            rivals: None,
            given: Vec::new(),
            periods: 1.0,
        }
    }
}

/// A request as it was made; [`Problem::new`](crate::excitation::Problem::new) checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct ProblemSpec {
    /// The robot that is to move.
    pub robot: Robot,
    /// Harmonics of the Fourier series N_f, equation (12).
    pub order: usize,
    /// Harmonics that every joint has, from 1 to `order`; for `None` all of them.
    pub harmonics: Option<Vec<Vec<usize>>>,
    /// Fundamental frequency ω_f/2π (Hz).
    pub fundamental_hz: f64,
    /// Rate at which the criterion is evaluated (Hz).
    pub sample_rate_hz: f64,
    /// What is minimised.
    pub criterion: Criterion,
    /// How limits are imposed.
    pub form: Form,
    /// How the trajectory begins.
    pub start: Start,
    /// Position of every joint at the start [rad or m]; for `None` zero where the limits allow it, else the middle of the range.
    pub start_position: Option<Vec<f64>>,
    /// Standard deviation of the torque noise of every joint [N·m or N], for predicted accuracies and the optimality criteria;
    /// for `None` one unit on every joint.
    pub torque_noise: Option<Vec<f64>>,
    /// Limits on the torques that the robot's prior parameters predict.
    pub torque: Option<TorqueLimits>,
    /// Obstacles and self-collision to avoid.
    pub space: Option<SpaceLimits>,
    /// What is known before: noise, priors, an earlier model.
    pub knowledge: Knowledge,
}
