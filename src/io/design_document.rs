//! Results of an excitation design.

use super::excitation_request::{ExcitationRequest, criterion_name};
use super::knowledge_request::DesignTerms;
use crate::excitation::{
    Criteria, Design, ExpectedEvidence, FirstRun, Margin, Outcome, Predicted, Problem, Quantity, RivalReport, margins,
};
use crate::model::Joint;
use crate::residual::{Term, reported};
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
    /// The criterion that is recommended, and why.
    pub recommended_criterion: RecommendedDocument,
    /// Effects of the model whose columns stand beside those of Y_b, with the accuracy to be expected of them.
    pub effects: Vec<EffectDocument>,
    /// How well two explanations of a residual are told apart, where they are asked for.
    pub rivals: Option<RivalsDocument>,
    /// Of `q_i(t) = offset_i + Σ_l a_il/(ω l) sin(ω l t) − b_il/(ω l) cos(ω l t)`, ω = 2π · fundamental_hz.
    pub coefficients: Option<Coefficients>,
    /// Position of every joint around which it moves [rad or m].
    pub offset: Option<Vec<f64>>,
    pub fundamental_hz: f64,
    pub order: usize,
    pub period_s: f64,
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
    /// Expected torque-prediction error [N·m or N], by the torque noise assumed.
    pub i_optimality: f64,
    /// Least expected evidence between two rivals, twice the logarithm of the odds: the larger the better.
    pub rival_evidence: Option<f64>,
}

/// The recommended criterion.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct RecommendedDocument {
    #[cfg_attr(feature = "service", schema(example = "i_optimality"))]
    pub criterion: &'static str,
    pub reason: &'static str,
}

/// An effect of the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = DesignEffect))]
pub struct EffectDocument {
    #[cfg_attr(feature = "service", schema(example = "torque_offset"))]
    pub effect: String,
    /// None for an effect of the whole robot.
    pub joints: Vec<String>,
    pub parameters: Vec<EffectParameterDocument>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct EffectParameterDocument {
    pub name: String,
    pub value: f64,
    pub unit: String,
    /// To be expected; null where the trajectory does not determine it.
    pub std_dev: Option<f64>,
}

/// Two explanations, and the evidence to be expected between them.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = DesignRivals))]
pub struct RivalsDocument {
    pub finding: EffectDocument,
    pub rival: EffectDocument,
    pub expected_evidence: ExpectedDocument,
    /// `finding` or `rival` where that one is a special case of the other: if it is true the other fits as well, whatever the motion. Evidence is then
    /// that against what the other could really be (a spring with its rest within a turn); 0 where it could be anything, and `least` looks at the other
    /// case alone.
    #[cfg_attr(feature = "service", schema(example = "finding"))]
    pub nested: Option<&'static str>,
    /// Whether the evidence of all data together is at least 6, odds of 20 to 1, in either case; 9, three standard deviations, where the special case of
    /// `nested` is true.
    pub decides: bool,
}

/// Twice the logarithm of the odds to be expected: 6 is 20 to 1, 10 is 150 to 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = ExpectedEvidence))]
pub struct ExpectedDocument {
    /// From the new trajectory alone, with what is given of all other parameters: what the search makes as large as it can.
    pub designed: EvidenceDocument,
    /// From the data that both explanations came from.
    pub recorded: Option<EvidenceDocument>,
    /// From what is given and the new trajectory, fitted together.
    pub together: EvidenceDocument,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = EvidenceEitherWay))]
pub struct EvidenceDocument {
    pub if_finding: f64,
    pub if_rival: f64,
    pub least: f64,
}

/// A smaller version of the trajectory.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = FirstRun))]
pub struct FirstRunDocument {
    /// Factor on the amplitudes around where the motion starts; smaller than asked for where a limit along the path would not hold.
    pub backoff: f64,
    pub coefficients: Coefficients,
    pub offset: Vec<f64>,
    pub fundamental_hz: f64,
    pub margins: Vec<MarginDocument>,
}

/// One of several trajectories.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = FurtherTrajectory))]
pub struct FurtherDocument {
    pub status: &'static str,
    pub coefficients: Coefficients,
    pub offset: Vec<f64>,
    pub fundamental_hz: f64,
    /// Of this trajectory and all before it together.
    pub criteria: CriteriaDocument,
    pub predicted: PredictedDocument,
    pub effects: Vec<EffectDocument>,
    pub rivals: Option<RivalsDocument>,
    pub margins: Vec<MarginDocument>,
    pub clearances: Vec<ClearanceDocument>,
}

/// Accuracy to be expected of an identification from this trajectory, as many periods as asked for, and what is given.
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
    /// Proven bound on the extreme over all time.
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
    /// # Panics
    /// If there is no design: a search hands out one even where it is infeasible.
    pub fn new(request: &ExcitationRequest, designs: &[(Problem, Design)], first_run: Option<&FirstRun>, elapsed_s: f64) -> Self {
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
            coefficients: found.then(|| Coefficients::of(&design.series)),
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
            starts: design.starts.iter().map(StartDocument::of).collect(),
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
        rival_evidence: c.rival_evidence,
    }
}

const RECOMMENDATION: RecommendedDocument = RecommendedDocument {
    criterion: "i_optimality",
    reason: "a model is identified to predict torques, and this is the expected error of that prediction over the workspace, in N m or N, by the torque \
             noise of every joint; it depends neither on the units of the parameters nor on which set of them is called base. Give torque_noise, and \
             constraints exact and free: they are worth more than any criterion",
};

fn effects(problem: &Problem, terms: &DesignTerms, design: &Design) -> Vec<EffectDocument> {
    let mut first = 0;
    let of = |term: &Term| {
        let k = term.parameters();
        let covariance = design
            .predicted
            .as_ref()
            .map(|p| p.of_effects.view((first, first), (k, k)).into_owned());
        first += k;
        effect(problem, term, covariance)
    };
    terms.terms.iter().map(of).collect()
}

fn effect(problem: &Problem, term: &Term, covariance: Option<DMatrix<f64>>) -> EffectDocument {
    let robot = problem.robot();
    let k = term.parameters();
    let unknown = covariance.is_none();
    let values = reported(term, &covariance.unwrap_or_else(|| DMatrix::zeros(k, k)));
    let infos = term.effect.parameters(term.form, robot, &term.joints).into_iter();
    EffectDocument {
        effect: term.effect.code().to_string(),
        joints: term.joints.iter().map(|&j| robot.joints()[j].name.clone()).collect(),
        parameters: infos
            .zip(values)
            .map(|(info, (value, std_dev))| EffectParameterDocument {
                name: info.name,
                value,
                unit: info.unit,
                std_dev: finite(std_dev).filter(|_| !unknown),
            })
            .collect(),
    }
}

fn rivals(problem: &Problem, terms: &DesignTerms, design: &Design) -> Option<RivalsDocument> {
    let ([finding, rival], report) = terms.rivals.zip(design.rivals)?;
    let all = effects(problem, terms, design);
    let RivalReport {
        designed,
        recorded,
        together,
    } = report;
    let evidence = |e: ExpectedEvidence| EvidenceDocument {
        if_finding: e.if_finding,
        if_rival: e.if_rival,
        least: e.least(),
    };
    Some(RivalsDocument {
        finding: all[finding].clone(),
        rival: all[rival].clone(),
        nested: match problem.spec().knowledge.rivals.as_ref().map(|r| r.nested) {
            Some([true, false]) => Some("finding"),
            Some([false, true]) => Some("rival"),
            _ => None,
        },
        decides: together.decides(DECISIVE),
        expected_evidence: ExpectedDocument {
            designed: evidence(designed),
            recorded: recorded.map(evidence),
            together: evidence(together),
        },
    })
}

/// Odds of 20 to 1, as what tracing calls excluded: `2 ln 20`.
const DECISIVE: f64 = 6.0;

fn first_run_document(problem: &Problem, run: &FirstRun) -> FirstRunDocument {
    FirstRunDocument {
        backoff: run.amplitude,
        coefficients: Coefficients::of(&run.series),
        offset: run.series.offset.clone(),
        fundamental_hz: run.series.fundamental_hz,
        margins: margin_documents(problem, &margins(problem, &run.series)),
    }
}

fn further_document(problem: &Problem, terms: &DesignTerms, design: &Design) -> Option<FurtherDocument> {
    Some(FurtherDocument {
        status: design.status.name(),
        coefficients: Coefficients::of(&design.series),
        offset: design.series.offset.clone(),
        fundamental_hz: design.series.fundamental_hz,
        criteria: criteria_document(problem, design.criteria.as_ref()?),
        predicted: predicted_document(design.predicted.as_ref()?),
        effects: effects(problem, terms, design),
        rivals: rivals(problem, terms, design),
        margins: margin_documents(problem, &design.margins),
        clearances: clearance_documents(problem, design),
    })
}

fn margin_documents(problem: &Problem, margins: &[Margin]) -> Vec<MarginDocument> {
    let joints = problem.robot().joints();
    margins.iter().map(|m| margin_document(&joints[m.joint], m)).collect()
}

fn clearance_documents(problem: &Problem, design: &Design) -> Vec<ClearanceDocument> {
    let joints = problem.robot().joints();
    let of = |c: &crate::excitation::Clearance| ClearanceDocument {
        joint: joints[c.joint].name.clone(),
        from: c.from.clone(),
        least: c.least,
        at_s: c.at_s,
        certified: c.certified,
        asked: c.asked,
    };
    design.clearances.iter().map(of).collect()
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
