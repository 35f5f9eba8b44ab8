//! The `residual` document of a report of the diagnosis, before its sentences are written.

use super::residual::*;
use crate::diagnosis::{
    self, Change, DataFault, Evaluated, Finding, HeldOut, HeldOutVerdict, JointFit, Perturbation, Remainder, ReportedParameter,
    ResidualReport, RmsPair, Verdict, is_determined,
};

/// What is no finite number is null.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn all_finite(values: &[f64]) -> Vec<Option<f64>> {
    values.iter().map(|v| finite(*v)).collect()
}

impl From<Evaluated> for EvaluatedFigure {
    fn from(value: Evaluated) -> Self {
        value.value().map_or_else(Self::default, |v| Self::Value(finite(v)))
    }
}

impl From<Verdict> for VerdictCode {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::NothingMissing => Self::NothingMissing,
            Verdict::Explained => Self::Explained,
            Verdict::PartlyExplained => Self::PartlyExplained,
            Verdict::Unexplained => Self::Unexplained,
        }
    }
}

impl From<Change> for ChangeCode {
    fn from(change: Change) -> Self {
        match change {
            Change::Better => Self::Better,
            Change::Same => Self::Same,
            Change::Worse => Self::Worse,
            Change::NotTested => Self::NotTested,
        }
    }
}

impl From<HeldOutVerdict> for HeldOutCode {
    fn from(verdict: HeldOutVerdict) -> Self {
        match verdict {
            HeldOutVerdict::Confirmed => Self::Confirmed,
            HeldOutVerdict::NotConfirmed => Self::NotConfirmed,
            HeldOutVerdict::NotTested => Self::NotTested,
        }
    }
}

impl From<Perturbation> for PerturbationCode {
    fn from(perturbation: Perturbation) -> Self {
        match perturbation {
            Perturbation::SixDigits => Self::SixDigits,
            Perturbation::EverySecondRow => Self::EverySecondRow,
            Perturbation::FirstHalf => Self::FirstHalf,
            Perturbation::SecondHalf => Self::SecondHalf,
            Perturbation::LowerCutoff => Self::LowerCutoff,
            Perturbation::HigherCutoff => Self::HigherCutoff,
        }
    }
}

impl From<&ReportedParameter> for EffectParameter {
    fn from(p: &ReportedParameter) -> Self {
        Self {
            name: p.name.clone(),
            value: finite(p.value),
            unit: p.unit.clone(),
            std_dev: is_determined(p.std_dev).then_some(p.std_dev),
        }
    }
}

impl From<&RmsPair> for RmsPerJoint {
    fn from(rms: &RmsPair) -> Self {
        Self {
            identification: all_finite(&rms.identification),
            held_out: all_finite(&rms.held_out),
        }
    }
}

impl From<&JointFit> for LackOfFit {
    fn from(fit: &JointFit) -> Self {
        Self {
            joint: fit.joint.clone(),
            statistic: finite(fit.statistic),
            p_value: finite(fit.p_value),
            degrees_of_freedom: fit.degrees_of_freedom.map(finite),
            residual_rms: finite(fit.residual_rms),
            expected_rms: finite(fit.expected_rms),
        }
    }
}

impl From<&DataFault> for DataFaultDocument {
    fn from(fault: &DataFault) -> Self {
        Self {
            code: fault.fault.code().into(),
            joints: fault.joints.clone(),
            detail: fault.detail.clone(),
            remedy: fault.remedy.sentence().into(),
            parameters: fault.parameters.iter().map(Into::into).collect(),
        }
    }
}

impl From<&HeldOut> for HeldOutDocument {
    fn from(held_out: &HeldOut) -> Self {
        let joint = |j: &diagnosis::JointHeldOut| HeldOutJoint {
            joint: j.joint.clone(),
            before: finite(j.before),
            after: finite(j.after),
            floor: finite(j.floor),
            change: j.change.into(),
            p_value: finite(j.p_value),
        };
        Self {
            verdict: held_out.verdict.into(),
            source: held_out.source.clone(),
            p_value: held_out.p_value.into(),
            joints: held_out.joints.iter().map(joint).collect(),
        }
    }
}

impl From<&Finding> for EffectFinding {
    fn from(f: &Finding) -> Self {
        let rival = |r: &diagnosis::Rival| RivalDocument {
            effect: r.effect.clone(),
            joints: r.joints.clone(),
            evidence: finite(r.evidence),
            law: r.formula.as_ref().map(|f| LawDocument::new(f, &r.joints)),
        };
        let survival = |s: &diagnosis::Survival| SurvivalDocument {
            perturbation: s.perturbation.into(),
            survives: s.survives,
        };
        Self {
            effect: f.effect.clone(),
            joints: f.joints.clone(),
            law: f
                .formula
                .as_ref()
                .map(|formula| LawDocument::new(formula, &f.joints).with_covered(&f.covered)),
            parameters: f.parameters.iter().map(Into::into).collect(),
            rms_before: (&f.rms_before).into(),
            rms_after: (&f.rms_after).into(),
            evidence: FindingEvidence {
                gain: finite(f.evidence.gain),
                log_evidence_ratio: finite(f.evidence.log_evidence_ratio),
                p_value: finite(f.evidence.p_value),
                held_out_blocks: f.evidence.held_out_blocks.into(),
                held_out_periods: f.evidence.held_out_periods.into(),
            },
            held_out: FindingHeldOut {
                before: f.held_out.before.into(),
                after: f.held_out.after.into(),
                change: f.held_out.change.into(),
                p_value: f.held_out.p_value.into(),
            },
            in_model: f.in_model,
            rivals: f.rivals.iter().map(rival).collect(),
            survivals: f.survivals.iter().map(survival).collect(),
            note: f.note.clone(),
            ..Self::default()
        }
    }
}

impl From<&Remainder> for RemainderDocument {
    fn from(rest: &Remainder) -> Self {
        Self {
            joints: rest.joints.clone(),
            depends_on: rest.depends_on.clone(),
            predicted_share: finite(rest.predicted_share),
            rms: all_finite(&rest.rms),
            note: rest.note.clone(),
            sentence: String::new(),
        }
    }
}

impl From<&ResidualReport> for ResidualDocument {
    fn from(report: &ResidualReport) -> Self {
        let undetected = |u: &diagnosis::Undetected| UndetectedEffect {
            effect: u.effect.clone(),
            joint: u.joint.clone(),
            parameter: (&u.parameter).into(),
            in_model: u.in_model,
        };
        let untested = |n: &diagnosis::NotTested| UntestedJoint {
            joint: n.joint.clone(),
            reason: n.reason.clone(),
        };
        let at_rest = |r: &diagnosis::AtRest| RestErrors {
            seconds: all_finite(&r.seconds),
            rms_before: (&r.rms_before).into(),
            rms_after: (&r.rms_after).into(),
        };
        Self {
            summary: String::new(),
            verdict: report.verdict.into(),
            noise_floor: all_finite(&report.noise_floor),
            noise_source: report.noise_source.clone(),
            lack_of_fit: report.lack_of_fit.iter().map(Into::into).collect(),
            lack_of_fit_after: report.lack_of_fit_after.iter().map(Into::into).collect(),
            held_out: (&report.held_out).into(),
            data_faults: report.data_faults.iter().map(Into::into).collect(),
            findings: report.findings.iter().map(Into::into).collect(),
            remainder: report.remainder.as_ref().map(Into::into),
            undetected: report.undetected.iter().map(undetected).collect(),
            explains_nothing: report.explains_nothing,
            not_tested: report.not_tested.iter().map(untested).collect(),
            rms_before: (&report.rms_before).into(),
            rms_after: (&report.rms_after).into(),
            at_rest: report.at_rest.as_ref().map(at_rest),
        }
    }
}
