//! The `residual` part of an answer.

use super::parameter::ReportedParameter;
use crate::diagnosis::data_quality::DataFault;
use crate::diagnosis::stability::Survival;
use crate::effects::Formula;

/// What the diagnosis concludes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The declared model leaves nothing above the noise.
    NothingMissing,
    /// What it leaves is explained by the findings, down to the noise.
    Explained,
    /// The findings explain a part; the remainder says what is left.
    PartlyExplained,
    /// Something is left that no effect explains.
    Unexplained,
}

/// Lack of fit of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFit {
    /// Name of the joint.
    pub joint: String,
    /// Mean square of the whitened residual over its expectation under pure noise: F with the degrees of freedom below.
    pub statistic: f64,
    /// Probability of a statistic at least as large if only noise is left, from 0 to 1.
    pub p_value: f64,
    /// Degrees of freedom of numerator and denominator of the F distribution.
    pub degrees_of_freedom: [f64; 2],
    /// RMS of the residual of the mean over the periods, and what noise alone would leave there [N·m or N].
    pub residual_rms: f64,
    /// Root mean square that noise alone would leave [N·m or N].
    pub expected_rms: f64,
}

/// RMS per joint [N·m or N], of single measurements.
#[derive(Debug, Clone, PartialEq)]
pub struct RmsPair {
    /// NaN for a joint without rows.
    pub identification: Vec<f64>,
    /// Per joint over all held-out logs together; empty where there is none.
    pub held_out: Vec<f64>,
}

/// Errors where a joint stands still for half a second and more: locked-in friction holds it there, and those rows take no part
/// in fits and other errors.
#[derive(Debug, Clone, PartialEq)]
pub struct AtRest {
    /// Time at rest in the identification logs, per joint (s).
    pub seconds: Vec<f64>,
    /// Of the declared model and of the final one; zero for a joint that never rests.
    pub rms_before: RmsPair,
    /// Errors of the model with the effects.
    pub rms_after: RmsPair,
}

/// A figure, or that it was not computed: written as the number, or as `not_evaluated`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Evaluated {
    /// The figure.
    Value(f64),
    /// It was not computed.
    NotEvaluated,
}

impl Evaluated {
    /// The number, where there is one.
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Value(v) => Some(v),
            Self::NotEvaluated => None,
        }
    }
}

impl From<Option<f64>> for Evaluated {
    fn from(value: Option<f64>) -> Self {
        value.map_or(Self::NotEvaluated, Self::Value)
    }
}

/// Whether an error on data that fitted nothing changed beyond chance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// The error fell beyond chance.
    Better,
    /// No change beyond chance.
    Same,
    /// The error rose beyond chance.
    Worse,
    /// There are no held-out data for a test.
    NotTested,
}

/// What held-out data say of all effects in the model together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeldOutVerdict {
    /// The error fell beyond chance.
    Confirmed,
    /// It did not.
    NotConfirmed,
    /// No effect is in the model.
    NotTested,
}

/// The declared model and the final one on held-out data.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOut {
    /// The conclusion over all joints.
    pub verdict: HeldOutVerdict,
    /// Which data were held out, and how far that can be trusted.
    pub source: String,
    /// Chance of a change as large of the error over all joints.
    pub p_value: Evaluated,
    /// One entry per joint.
    pub joints: Vec<JointHeldOut>,
}

/// One joint on held-out data: RMS of single measurements [N·m or N].
#[derive(Debug, Clone, PartialEq)]
pub struct JointHeldOut {
    /// Name of the joint.
    pub joint: String,
    /// Of the declared model.
    pub before: f64,
    /// Of the final model.
    pub after: f64,
    /// Of the noise alone.
    pub floor: f64,
    /// Whether the error changed beyond chance.
    pub change: Change,
    /// Probability of a change at least as large by chance, from 0 to 1.
    pub p_value: f64,
}

/// The model without an effect and with it on held-out data: RMS over its joints [N·m or N].
#[derive(Debug, Clone, PartialEq)]
pub struct FindingHeldOut {
    /// Root mean square error without the effect [N·m or N].
    pub before: Evaluated,
    /// Root mean square error with the effect [N·m or N].
    pub after: Evaluated,
    /// Whether the error changed beyond chance.
    pub change: Change,
    /// Probability of a change at least as large by chance, from 0 to 1.
    pub p_value: Evaluated,
}

impl FindingHeldOut {
    /// Of what was not held against held-out data.
    pub fn not_tested() -> Self {
        Self {
            before: Evaluated::NotEvaluated,
            after: Evaluated::NotEvaluated,
            change: Change::NotTested,
            p_value: Evaluated::NotEvaluated,
        }
    }
}

/// Why an effect is believed.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// Decrease of the weighted sum of squares when the effect is added, divided by what is left per degree of freedom.
    pub gain: f64,
    /// Twice the log of the evidence ratio against leaving it out, parameters and shapes tried paid for (Schwarz).
    pub log_evidence_ratio: f64,
    /// Chance of such a gain without the effect, times the number of hypotheses tried.
    pub p_value: f64,
    /// Gain on blocks of time that were left out of the fit.
    pub held_out_blocks: Evaluated,
    /// Gain on one half of the periods when fitted to the other.
    pub held_out_periods: Evaluated,
}

/// Another effect that the data do not exclude in a finding's place.
#[derive(Debug, Clone, PartialEq)]
pub struct Rival {
    /// Code of the other effect.
    pub effect: String,
    /// Names of the joints that it acts on.
    pub joints: Vec<String>,
    /// Twice the log of the evidence ratio in favour of the finding; below zero the rival fits better.
    pub evidence: f64,
    /// Of a law.
    pub formula: Option<Formula>,
}

/// The range of a variable over the identification logs.
#[derive(Debug, Clone, PartialEq)]
pub struct Covered {
    /// The variable, such as `q4`.
    pub variable: String,
    /// Least value, in `unit`.
    pub low: f64,
    /// Largest value, in `unit`.
    pub high: f64,
    /// Unit of the variable.
    pub unit: String,
}

/// An effect found.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Code of the effect.
    pub effect: String,
    /// Names of the joints that it acts on.
    pub joints: Vec<String>,
    /// Of a law: what it adds to the torques, in symbols that `parameters` has the values of.
    pub formula: Option<Formula>,
    /// Ranges of the formula's variables over the identification logs.
    pub covered: Vec<Covered>,
    /// Estimated parameters with standard deviations.
    pub parameters: Vec<ReportedParameter>,
    /// Errors without the effect [N·m or N].
    pub rms_before: RmsPair,
    /// Errors with the effect [N·m or N].
    pub rms_after: RmsPair,
    /// Why the effect is believed, from the data that were fitted.
    pub evidence: Evidence,
    /// The same on data that were not fitted.
    pub held_out: FindingHeldOut,
    /// Whether the effect is a part of the model that is handed out.
    pub in_model: bool,
    /// Effects that the data do not exclude in its place.
    pub rivals: Vec<Rival>,
    /// Under which changes of the data the effect is still beyond doubt; those that the data allow.
    pub survivals: Vec<Survival>,
    /// In words, where something should be known about it.
    pub note: Option<String>,
}

/// What no effect explains.
#[derive(Debug, Clone, PartialEq)]
pub struct Remainder {
    /// Names of the joints that it is left on.
    pub joints: Vec<String>,
    /// `q2`, `qd4`, `load3`; `time` for a drift over the log and `period` for another level in every period, whatever the
    /// motion; `time` with speeds for friction that changes over the log: strongest first. Empty where more than noise is left
    /// and no smooth function accounts for it; of logs without periods where such functions explain it and do not predict it.
    pub depends_on: Vec<String>,
    /// Share of what is left above the noise on those joints that smooth functions of these variables predict; of what changes
    /// slowly from period to period where they are `time` and `period`, and of all that is left where the log has no periods.
    pub predicted_share: f64,
    /// RMS of what is left above the noise, per joint of `joints` [N·m or N]; without periods the least that is misfit.
    pub rms: Vec<f64>,
    /// Remark of the test that found it.
    pub note: String,
}

/// An effect that every robot may have and that was not found: what the data say of its size all the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Undetected {
    /// Code of the effect.
    pub effect: String,
    /// Name of the joint.
    pub joint: String,
    /// Beside the final model and alone; not beyond chance, or it would be a finding.
    pub parameter: ReportedParameter,
    /// Whether the final model has it all the same: a nuisance offset, estimated because an offset was found on another joint and
    /// all of them together predict blocks left out better.
    pub in_model: bool,
}

/// A joint that takes no part in the tracing.
#[derive(Debug, Clone, PartialEq)]
pub struct NotTested {
    /// Name of the joint.
    pub joint: String,
    /// Why no effect was looked for on it.
    pub reason: String,
}

/// The `residual` part of an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualReport {
    /// Standard deviation of one measurement, per joint [N·m or N]; of the mean over neighbouring samples where a period has many
    /// more of them than it has turns, here as in the errors. NaN for a joint without rows.
    pub noise_floor: Vec<f64>,
    /// How the floor was found.
    pub noise_source: String,
    /// Lack of fit of the declared model, one entry per joint.
    pub lack_of_fit: Vec<JointFit>,
    /// The conclusion.
    pub verdict: Verdict,
    /// The declared model and the final one on data that fitted neither.
    pub held_out: HeldOut,
    /// Faults of the recording; empty without any.
    pub data_faults: Vec<DataFault>,
    /// Effects that were found, those in the model first.
    pub findings: Vec<Finding>,
    /// What no effect explains; nothing if only noise is left.
    pub remainder: Option<Remainder>,
    /// Offsets and rotor inertias that were tested and not found, with estimate and standard deviation.
    pub undetected: Vec<Undetected>,
    /// Whether the model explains no more of the torques than a constant per joint; no effect is looked for then.
    pub explains_nothing: bool,
    /// Joints that no effect was looked for on.
    pub not_tested: Vec<NotTested>,
    /// Lack of fit with all findings in the model.
    pub lack_of_fit_after: Vec<JointFit>,
    /// RMS of the declared model and of the final one.
    pub rms_before: RmsPair,
    /// Errors of the model with the effects [N·m or N].
    pub rms_after: RmsPair,
    /// The same where joints rest, if any does.
    pub at_rest: Option<AtRest>,
}

impl ResidualReport {
    /// `noise_source` of logs that repeat.
    pub(crate) const FROM_PERIODS: &str = "scatter between periods";

    /// Whether the noise was measured, by logs that repeat.
    pub fn noise_is_measured(&self) -> bool {
        self.noise_source == Self::FROM_PERIODS
    }
}
