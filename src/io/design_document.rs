//! Results of an excitation design.

use super::excitation_request::{ExcitationRequest, criterion_name};
use crate::excitation::{Criteria, Design, Margin, Outcome, Predicted, Problem, Quantity};
use crate::model::Joint;
use crate::trajectory::FourierSeries;
use nalgebra::DMatrix;
use serde::Serialize;
use serde_json::Value;

/// A designed excitation trajectory and what it is worth.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = ExcitationResult))]
pub struct DesignDocument {
    /// How the search ended. Every outcome but `Infeasible` comes with a trajectory that meets all constraints.
    #[cfg_attr(feature = "service", schema(example = "Converged"))]
    pub status: &'static str,
    /// Why, where it is `Infeasible`.
    pub reason: Option<String>,
    /// Of the true observation matrix Y_b on the asked samples, with the true sign of every velocity.
    #[cfg_attr(feature = "service", schema(example = 57.3))]
    pub condition_number: Option<f64>,
    pub criteria: Option<CriteriaDocument>,
    pub predicted: Option<PredictedDocument>,
    /// Of `q_i(t) = offset_i + Σ_l a_il/(ω l) sin(ω l t) − b_il/(ω l) cos(ω l t)`, ω = 2π · fundamental_hz.
    pub coefficients: Option<Coefficients>,
    /// Position of every joint around which it moves [rad or m].
    pub offset: Option<Vec<f64>>,
    pub fundamental_hz: f64,
    pub order: usize,
    pub period_s: f64,
    pub sample_rate_hz: f64,
    /// Samples in one period: rows of Y_b per joint.
    pub samples: usize,
    /// Names of the joints, in the order of all lists.
    pub joints: Vec<String>,
    /// Both sides of every stated limit of every joint.
    pub margins: Vec<MarginDocument>,
    /// Of every pair that keeps a distance, where limits in space are asked for.
    pub clearances: Vec<ClearanceDocument>,
    pub starts: Vec<StartDocument>,
    /// Names of the base parameters: columns of Y_b, and the order of `predicted`.
    pub base_parameters: Vec<String>,
    pub search: SearchDocument,
    pub robot: String,
    /// What to know about how the robot was read.
    pub notes: Vec<String>,
    /// The request as it was made.
    #[cfg_attr(feature = "service", schema(value_type = Object))]
    pub request: Value,
    /// Version of the program.
    pub version: &'static str,
}

/// Fourier coefficients: one row per joint, in each the harmonics 1 … L.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct Coefficients {
    /// `a[i][l-1]` of joint i, harmonic l [rad/s or m/s].
    pub a: Vec<Vec<f64>>,
    /// `b[i][l-1]` of joint i, harmonic l [rad/s or m/s].
    pub b: Vec<Vec<f64>>,
}

/// Every criterion of the trajectory, whichever was minimised.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct CriteriaDocument {
    /// The one that was minimised.
    #[cfg_attr(feature = "service", schema(example = "condition_number"))]
    pub minimised: &'static str,
    pub condition_number: f64,
    /// After scaling every column of Y_b to length one.
    pub scaled_condition_number: f64,
    /// `det(M)^(−1/(2b))`, M = Y_bᵀ Y_b.
    pub d_optimality: f64,
    /// `sqrt(tr(M⁻¹)/b)`
    pub a_optimality: f64,
    /// Expected torque-prediction error per unit of noise [N·m or N].
    pub i_optimality: f64,
}

/// Accuracy to be expected of an identification from one period of this trajectory.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct PredictedDocument {
    /// Torque noise assumed, one standard deviation per joint [N·m or N].
    pub torque_noise: Vec<f64>,
    /// Standard deviation of every base parameter, in its SI unit.
    pub std_dev: Vec<Option<f64>>,
    /// `100 σ/|value|`, where the robot has prior link parameters; null where the prior value is zero.
    pub relative_std_dev_percent: Option<Vec<Option<f64>>>,
}

/// One side of one limit of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct MarginDocument {
    pub joint: String,
    /// `position`, `velocity`, `acceleration`, `jerk`, or with torque limits `torque`.
    pub quantity: &'static str,
    /// `lower` or `upper`.
    pub side: &'static str,
    pub limit: f64,
    /// Extreme value reached.
    pub peak: f64,
    /// Bound on the extreme over all time: proven for motions; for torques the extreme of a dense sampling and half its largest step.
    pub certified_peak: f64,
    /// Time of the extreme (s).
    pub at_s: f64,
    /// Part of the way from the middle of the range to the limit that is left.
    pub margin: f64,
    /// Left side over right side of the paper's bound (14d) or (14e), with the paper's constraints.
    pub bound_used: Option<f64>,
    #[cfg_attr(feature = "service", schema(example = "rad/s"))]
    pub unit: &'static str,
}

/// How near a link comes to an obstacle or another link.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct ClearanceDocument {
    /// Joint that carries the link.
    pub joint: String,
    /// Name of the obstacle, or of the joint that carries the other link.
    pub from: String,
    /// Least distance seen (m).
    pub least: f64,
    /// When (s).
    pub at_s: f64,
    /// Proven bound on the least distance over all time (m).
    pub certified: f64,
    /// Distance asked for (m).
    pub asked: f64,
}

/// What became of one random start.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct StartDocument {
    /// Criterion at the random point, scaled into the limits; null where it is infinite.
    pub initial: Option<f64>,
    /// After its local solve.
    pub reached: Option<f64>,
    pub evaluations: u32,
    pub converged: bool,
    /// Its course, `[evaluations of this start, criterion at its best point then]`, closer together at first.
    #[cfg_attr(feature = "service", schema(example = json!([[0.0, 912.4], [1.0, 804.1], [180.0, 71.3]])))]
    pub course: Vec<[f64; 2]>,
}

/// How the search went.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct SearchDocument {
    pub seed: u64,
    pub starts: usize,
    /// Evaluations of the criterion, with gradient.
    pub evaluations: u64,
    pub rounds: usize,
    pub elapsed_s: f64,
    /// Searches that took part, one on every machine that had nothing else to do; the best of all is the result.
    pub searches: usize,
}

impl DesignDocument {
    pub fn new(request: &ExcitationRequest, design: &Design, elapsed_s: f64) -> Self {
        let problem = &request.problem;
        let spec = problem.spec();
        let found = design.criteria.is_some();
        let joints = problem.robot().joints();
        Self {
            status: design.status.name(),
            reason: match &design.status {
                Outcome::Infeasible(reason) => Some(reason.clone()),
                _ => None,
            },
            condition_number: design.criteria.map(|c| c.condition_number),
            criteria: design.criteria.map(|c| criteria_document(problem, &c)),
            predicted: design.predicted.as_ref().map(predicted_document),
            coefficients: found.then(|| Coefficients::of(&design.series)),
            offset: found.then(|| design.series.offset.clone()),
            fundamental_hz: spec.fundamental_hz,
            order: spec.order,
            period_s: 1.0 / spec.fundamental_hz,
            sample_rate_hz: spec.sample_rate_hz,
            samples: problem.samples(),
            joints: joints.iter().map(|j| j.name.clone()).collect(),
            margins: design.margins.iter().map(|m| margin_document(&joints[m.joint], m)).collect(),
            clearances: design
                .clearances
                .iter()
                .map(|c| ClearanceDocument {
                    joint: joints[c.joint].name.clone(),
                    from: c.from.clone(),
                    least: c.least,
                    at_s: c.at_s,
                    certified: c.certified,
                    asked: c.asked,
                })
                .collect(),
            starts: design.starts.iter().map(StartDocument::of).collect(),
            base_parameters: problem.base().names.clone(),
            search: SearchDocument {
                seed: request.search.options.seed,
                starts: request.search.options.starts,
                evaluations: design.evaluations,
                rounds: design.rounds,
                elapsed_s,
                searches: 1,
            },
            robot: problem.robot().name().to_string(),
            notes: request.notes.clone(),
            request: request.document.clone(),
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

impl Coefficients {
    fn of(series: &FourierSeries) -> Self {
        let rows = |m: &DMatrix<f64>| m.row_iter().map(|r| r.iter().copied().collect()).collect();
        Self {
            a: rows(&series.a),
            b: rows(&series.b),
        }
    }
}

fn criteria_document(problem: &Problem, c: &Criteria) -> CriteriaDocument {
    CriteriaDocument {
        minimised: criterion_name(problem.spec().criterion),
        condition_number: c.condition_number,
        scaled_condition_number: c.scaled_condition_number,
        d_optimality: c.d_optimality,
        a_optimality: c.a_optimality,
        i_optimality: c.i_optimality,
    }
}

fn predicted_document(p: &Predicted) -> PredictedDocument {
    PredictedDocument {
        torque_noise: p.torque_noise.clone(),
        std_dev: p.std_dev.iter().copied().map(finite).collect(),
        relative_std_dev_percent: p
            .relative_std_dev_percent
            .as_ref()
            .map(|v| v.iter().copied().map(finite).collect()),
    }
}

fn margin_document(joint: &Joint, m: &Margin) -> MarginDocument {
    MarginDocument {
        joint: joint.name.clone(),
        quantity: m.quantity.name(),
        side: if m.limit < m.peak { "lower" } else { "upper" },
        limit: m.limit,
        peak: m.peak,
        certified_peak: m.certified_peak,
        at_s: m.at_s,
        margin: m.margin,
        bound_used: m.bound_used,
        unit: unit(joint, m.quantity),
    }
}

fn unit(joint: &Joint, quantity: Quantity) -> &'static str {
    let units = if joint.is_revolute() {
        ["rad", "rad/s", "rad/s^2", "rad/s^3", "N m"]
    } else {
        ["m", "m/s", "m/s^2", "m/s^3", "N"]
    };
    units[quantity as usize]
}

impl StartDocument {
    pub fn of(s: &crate::excitation::StartReport) -> Self {
        Self {
            initial: finite(s.initial),
            reached: finite(s.reached),
            evaluations: s.evaluations,
            converged: s.converged,
            course: s
                .course
                .iter()
                .filter(|p| p.1.is_finite())
                .map(|&(n, v)| [f64::from(n), v])
                .collect(),
        }
    }
}

/// JSON has no infinity.
fn finite(v: f64) -> Option<f64> {
    v.is_finite().then_some(v)
}
