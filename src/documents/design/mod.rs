//! Results of an excitation design.

mod accuracy;
mod detectable;
mod effects;
mod margins;
mod runs;

pub use accuracy::{CriteriaDocument, PredictedDocument, RecommendedDocument};
pub use detectable::{Assessed, AssumedParameterDocument, DetectableDocument, DetectableEffectDocument, InseparableDocument};
pub use effects::{EffectDocument, RivalsDocument};
pub use margins::{ClearanceDocument, MarginDocument};
pub use runs::{Coefficients, FirstRunDocument, FurtherDocument};

use self::accuracy::{RECOMMENDATION, criteria_document, predicted_document};
use self::detectable::detectable;
use self::effects::{effects, rivals};
use self::margins::{clearance_documents, margin_documents};
use self::runs::{first_run_document, further_document};
use crate::documents::excitation_request::ExcitationRequest;
use crate::excitation::{Design, FirstRun, Outcome, Problem};
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
    /// All criteria of the trajectory, computed from its coefficients; null if the regressor is singular.
    pub criteria: Option<CriteriaDocument>,
    /// Predicted accuracy of the base parameters; null without knowledge of the torque noise, or if the regressor is singular.
    pub predicted: Option<PredictedDocument>,
    /// The criterion that is recommended, and why.
    pub recommended_criterion: RecommendedDocument,
    /// Effects of the model whose columns stand beside those of Y_b, with the accuracy to be expected of them.
    pub effects: Vec<EffectDocument>,
    /// How well two explanations of a residual can be distinguished; null if none were named.
    pub rivals: Option<RivalsDocument>,
    /// What a recording of all trajectories would reveal of what the model lacks, and what it would not tell apart; null
    /// without a trajectory, and for arms of more than 16 joints.
    pub detectable: Option<DetectableDocument>,
    /// Of `q_i(t) = offset_i + Σ_l a_il/(ω l) sin(ω l t) − b_il/(ω l) cos(ω l t)`, ω = 2π · fundamental_hz.
    pub coefficients: Option<Coefficients>,
    /// Position of every joint around which it moves [rad or m].
    pub offset: Option<Vec<f64>>,
    /// Fundamental frequency f of the Fourier series (Hz).
    pub fundamental_hz: f64,
    /// Number of harmonics of the series.
    pub order: usize,
    /// Period `1/f` (s).
    pub period_s: f64,
    /// Rate at which the regressor and the limits were sampled (Hz).
    pub sample_rate_hz: f64,
    /// Periods that will be recorded, for `predicted` and the evidence.
    pub periods: f64,
    /// Samples in one period: rows of Y_b per joint.
    pub samples: usize,
    /// Names of the joints, in the order of all lists.
    pub joints: Vec<String>,
    /// Both sides of every stated limit of every joint.
    pub margins: Vec<MarginDocument>,
    /// Of every pair that keeps a distance, where limits in space are asked for.
    pub clearances: Vec<ClearanceDocument>,
    /// Smaller amplitudes for a first run, where they are asked for.
    pub first_run: Option<FirstRunDocument>,
    /// The other trajectories, where several are asked for: each complements those before it.
    pub further: Vec<FurtherDocument>,
    /// Every random start with its local solve, in the order of the starts.
    pub starts: Vec<StartDocument>,
    /// Names of the base parameters: columns of Y_b, and the order of `predicted`.
    pub base_parameters: Vec<String>,
    /// Seed, effort and duration of the search.
    pub search: SearchDocument,
    /// Name of the robot.
    pub robot: String,
    /// What to know about how the robot was read.
    pub notes: Vec<String>,
    /// The request as it was made.
    #[cfg_attr(feature = "service", schema(value_type = Object))]
    pub request: Value,
    /// Version of the program.
    pub version: &'static str,
}

/// What became of one random start.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct StartDocument {
    /// Criterion at the random point, scaled into the limits; null where it is infinite.
    pub initial: Option<f64>,
    /// After its local solve.
    pub reached: Option<f64>,
    /// Evaluations of the criterion by this start.
    pub evaluations: u32,
    /// Whether the local solve met its tolerance before the budget ended.
    pub converged: bool,
    /// Its course, `[evaluations of this start, criterion at its best point then]`, closer together at first.
    #[cfg_attr(feature = "service", schema(example = json!([[0.0, 912.4], [1.0, 804.1], [180.0, 71.3]])))]
    pub course: Vec<[f64; 2]>,
}

/// How the search went.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct SearchDocument {
    /// Seed of all random numbers; the same seed and number of evaluations give the same design.
    pub seed: u64,
    /// Number of random starts.
    pub starts: usize,
    /// Evaluations of the criterion, with gradient.
    pub evaluations: u64,
    /// Rounds of local solves; points are recombined between them.
    pub rounds: usize,
    /// Wall-clock time of the search (s).
    pub elapsed_s: f64,
    /// Searches that took part, one on every machine that had nothing else to do; the best of all is the result.
    pub searches: usize,
}

impl DesignDocument {
    /// # Panics
    /// If there is no design: a search hands out one even where it is infeasible.
    pub fn new(
        request: &ExcitationRequest,
        designs: &[(Problem, Design)],
        first_run: Option<&FirstRun>,
        assessed: Option<&Assessed>,
        elapsed_s: f64,
    ) -> Self {
        let (problem, design) = &designs[0];
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
            recommended_criterion: RECOMMENDATION,
            effects: effects(problem, &request.effects, design),
            rivals: rivals(problem, &request.effects, design),
            detectable: assessed.map(|a| detectable(problem, a)),
            coefficients: found.then(|| Coefficients::from_series(&design.series)),
            offset: found.then(|| design.series.offset.clone()),
            fundamental_hz: spec.fundamental_hz,
            order: spec.order,
            period_s: 1.0 / spec.fundamental_hz,
            sample_rate_hz: spec.sample_rate_hz,
            periods: spec.knowledge.periods,
            samples: problem.samples(),
            joints: joints.iter().map(|j| j.name.clone()).collect(),
            margins: margin_documents(problem, &design.margins),
            clearances: clearance_documents(problem, design),
            first_run: first_run.map(|run| first_run_document(problem, run)),
            further: designs[1..]
                .iter()
                .filter_map(|(p, d)| further_document(p, &request.effects, d))
                .collect(),
            starts: design.starts.iter().map(StartDocument::from_report).collect(),
            base_parameters: problem.base().names.clone(),
            search: SearchDocument {
                seed: request.search.options.seed,
                starts: request.search.options.starts,
                evaluations: designs.iter().map(|(_, d)| d.evaluations).sum(),
                rounds: designs.iter().map(|(_, d)| d.rounds).sum(),
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

impl StartDocument {
    /// The entry for one start of the core's report.
    pub fn from_report(s: &crate::excitation::StartReport) -> Self {
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
