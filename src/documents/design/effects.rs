//! Effects of the model, and the evidence to be expected between two explanations.

use super::finite;
use crate::documents::knowledge::DesignTerms;
use crate::excitation::{Design, ExpectedEvidence, Problem, RivalReport};
use crate::regression::{Term, reported};
use nalgebra::DMatrix;
use serde::Serialize;

/// An effect of the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = DesignEffect))]
pub struct EffectDocument {
    /// Code of the effect, such as `torque_offset`.
    #[cfg_attr(feature = "service", schema(example = "torque_offset"))]
    pub effect: String,
    /// None for an effect of the whole robot.
    pub joints: Vec<String>,
    /// Its parameters with the standard deviations predicted for this trajectory.
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
    /// `finding` or `rival` where that one is a special case of the other: if it is true the other fits as well, whatever the
    /// motion. Evidence is then that against what the other could really be (a spring with its rest within a turn); 0 where it
    /// could be anything, and `least` looks at the other case alone.
    #[cfg_attr(feature = "service", schema(example = "finding"))]
    pub nested: Option<&'static str>,
    /// Whether the evidence of all data together is at least 6, odds of 20 to 1, in either case; 9, three standard deviations,
    /// where the special case of `nested` is true.
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

pub(super) fn effects(problem: &Problem, terms: &DesignTerms, design: &Design) -> Vec<EffectDocument> {
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
        joints: term.acts_on().iter().map(|&j| robot.joints()[j].name.clone()).collect(),
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

pub(super) fn rivals(problem: &Problem, terms: &DesignTerms, design: &Design) -> Option<RivalsDocument> {
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
