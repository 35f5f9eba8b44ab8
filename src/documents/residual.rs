//! The `residual` part of an answer: what the declared model leaves, and the effects that explain it.

use crate::diagnosis::{Covered, FaultKind};
use crate::effects::Formula;
use crate::formats::mathml;
use serde::{Deserialize, Serialize};

/// The residual diagnosis of a log.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Residual))]
#[serde(default)]
pub struct ResidualDocument {
    /// The verdict and its scope in sentences.
    pub summary: String,
    /// The conclusion as a code.
    pub verdict: VerdictCode,
    /// Per joint: standard deviation of one measurement [N m or N]; null for a joint without rows.
    pub noise_floor: Vec<Option<f64>>,
    /// How the floor was found.
    pub noise_source: String,
    /// Of the declared model.
    pub lack_of_fit: Vec<LackOfFit>,
    /// Of the model with the effects.
    pub lack_of_fit_after: Vec<LackOfFit>,
    /// The declared model and the final one on data that fitted neither.
    pub held_out: HeldOutDocument,
    /// Faults of the recording, such as a wrong sign of a torque; empty without any.
    pub data_faults: Vec<DataFaultDocument>,
    /// Those in the model first.
    pub findings: Vec<EffectFinding>,
    /// What no effect explains; null if nothing is left above the noise.
    pub remainder: Option<RemainderDocument>,
    /// Offsets and rotor inertias that were tested and not found, with estimate and standard deviation.
    pub undetected: Vec<UndetectedEffect>,
    /// Whether the model explains no more of the torques than a constant per joint; no effect is looked for then.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub explains_nothing: bool,
    /// Joints that no effect was looked for on.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_tested: Vec<UntestedJoint>,
    /// Errors of the declared model.
    pub rms_before: RmsPerJoint,
    /// Errors of the model with the effects.
    pub rms_after: RmsPerJoint,
    /// Errors where joints rest, if any does: those rows take no part in fits and other errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_rest: Option<RestErrors>,
}

/// What the diagnosis concludes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = ResidualVerdict))]
#[serde(rename_all = "snake_case")]
pub enum VerdictCode {
    /// The declared model leaves nothing above the noise.
    NothingMissing,
    /// The findings explain what it leaves, down to the noise.
    Explained,
    /// The findings explain a part.
    PartlyExplained,
    /// Something is left that no effect explains.
    #[default]
    Unexplained,
}

impl VerdictCode {
    /// As documents have it.
    pub fn code(self) -> &'static str {
        match self {
            Self::NothingMissing => "nothing_missing",
            Self::Explained => "explained",
            Self::PartlyExplained => "partly_explained",
            Self::Unexplained => "unexplained",
        }
    }
}

/// A figure, or `not_evaluated` where it was not computed. Null where it is no finite number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = EvaluatedFigure))]
#[serde(untagged)]
pub enum EvaluatedFigure {
    /// The figure; null if it is not finite.
    Value(Option<f64>),
    /// The figure was not computed.
    NotEvaluated(NotEvaluated),
}

/// In the place of a figure that was not computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum NotEvaluated {
    /// The text `not_evaluated`.
    NotEvaluated,
}

impl EvaluatedFigure {
    /// The number, where there is one.
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Value(value) => value,
            Self::NotEvaluated(_) => None,
        }
    }
}

impl Default for EvaluatedFigure {
    fn default() -> Self {
        Self::NotEvaluated(NotEvaluated::NotEvaluated)
    }
}

/// Lack of fit of one joint.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct LackOfFit {
    /// Name of the joint.
    pub joint: String,
    /// Mean square of the whitened residual over its expectation under noise alone; F distributed with `degrees_of_freedom` where
    /// only noise is left.
    pub statistic: Option<f64>,
    /// Probability of a statistic at least as large if only noise is left, from 0 to 1.
    pub p_value: Option<f64>,
    /// Degrees of freedom of numerator and denominator; null if infinite.
    pub degrees_of_freedom: [Option<f64>; 2],
    /// RMS of the residual of the mean over the periods [N m or N].
    pub residual_rms: Option<f64>,
    /// What noise alone would leave there [N m or N].
    pub expected_rms: Option<f64>,
}

/// RMS of single measurements per joint [N m or N]; null for a joint without rows.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct RmsPerJoint {
    /// Over all identification logs together, one entry per joint.
    pub identification: Vec<Option<f64>>,
    /// Over all held-out logs together; empty where there is none.
    pub held_out: Vec<Option<f64>>,
}

/// Errors where a joint stands still for half a second and more.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct RestErrors {
    /// Time at rest in the identification logs, per joint (s).
    pub seconds: Vec<Option<f64>>,
    /// Errors of the declared model.
    pub rms_before: RmsPerJoint,
    /// Errors of the model with the effects.
    pub rms_after: RmsPerJoint,
}

/// Whether an error on data that fitted nothing changed beyond chance.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum ChangeCode {
    /// The error fell beyond chance.
    Better,
    /// No change beyond chance.
    Same,
    /// The error rose beyond chance.
    Worse,
    /// There are no held-out data for a test.
    #[default]
    NotTested,
}

impl ChangeCode {
    /// As documents have it.
    pub fn code(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Same => "same",
            Self::Worse => "worse",
            Self::NotTested => "not_tested",
        }
    }
}

/// What held-out data say of all effects in the model together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum HeldOutCode {
    /// The error fell beyond chance.
    Confirmed,
    /// The error did not fall beyond chance.
    NotConfirmed,
    /// No effect is in the model.
    #[default]
    NotTested,
}

impl HeldOutCode {
    /// As documents have it.
    pub fn code(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::NotConfirmed => "not_confirmed",
            Self::NotTested => "not_tested",
        }
    }
}

/// The declared model and the final one on held-out data.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = HeldOut))]
#[serde(default)]
pub struct HeldOutDocument {
    /// The conclusion over all joints.
    pub verdict: HeldOutCode,
    /// Which data were held out, and how far that can be trusted.
    pub source: String,
    /// Chance of a change as large of the error over all joints.
    pub p_value: EvaluatedFigure,
    /// One entry per joint.
    pub joints: Vec<HeldOutJoint>,
}

/// One joint on held-out data: RMS of single measurements [N m or N].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct HeldOutJoint {
    /// Name of the joint.
    pub joint: String,
    /// Of the declared model.
    pub before: Option<f64>,
    /// Of the final model.
    pub after: Option<f64>,
    /// Of the noise alone.
    pub floor: Option<f64>,
    /// Whether the error changed beyond chance.
    pub change: ChangeCode,
    /// Probability of a change at least as large by chance, from 0 to 1; null if not tested.
    pub p_value: Option<f64>,
}

/// A fault of the data, by name.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = DataFault))]
#[serde(default)]
pub struct DataFaultDocument {
    /// `gravity_direction`, `torque_sign`, `joint_order`, `unit_mismatch`, `bad_samples`, `gravity_compensated_torque`,
    /// `unit_unknown` or `filtered_torque`.
    pub code: String,
    /// Joints whose columns are concerned.
    pub joints: Vec<String>,
    /// What was seen, and what to do.
    pub detail: String,
    /// What was done about it.
    pub remedy: String,
    /// Numbers that put it right, where there are any.
    pub parameters: Vec<EffectParameter>,
}

impl DataFaultDocument {
    /// Whether the model allows for it: then the answer is as good as without.
    pub fn is_allowed_for(&self) -> bool {
        self.code == FaultKind::FilteredTorque.code()
    }
}

/// A parameter with one standard deviation, null where the data do not determine it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct EffectParameter {
    /// Name of the parameter.
    #[cfg_attr(feature = "service", schema(example = "amplitude"))]
    pub name: String,
    /// Estimate, in `unit`; null if the data do not determine it.
    pub value: Option<f64>,
    /// Unit of the value; empty for pure numbers.
    pub unit: String,
    /// Standard deviation of the estimate, in `unit`; 0 for what is given and not estimated, as the end of the log from which a
    /// soft stop is counted.
    pub std_dev: Option<f64>,
}

/// An effect found.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct EffectFinding {
    /// Code of the effect, `law` for a formula, or the name of an own effect.
    #[cfg_attr(feature = "service", schema(example = "stribeck_friction"))]
    pub effect: String,
    /// Names of the joints that it acts on.
    pub joints: Vec<String>,
    /// The formula of a law or own effect, whose constants are in `parameters`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<LawDocument>,
    /// Estimated parameters with units and standard deviations.
    pub parameters: Vec<EffectParameter>,
    /// What was found, with its figures.
    pub sentence: String,
    /// What to draw the residual against.
    pub against: Against,
    /// Errors without the effect, with those accepted before it.
    pub rms_before: RmsPerJoint,
    /// Errors with the effect.
    pub rms_after: RmsPerJoint,
    /// Why the effect is believed, from the data that were fitted.
    pub evidence: FindingEvidence,
    /// The same on data that were not fitted.
    pub held_out: FindingHeldOut,
    /// Whether the effect is a part of the model that is handed out.
    pub in_model: bool,
    /// Effects that the data do not exclude in its place.
    pub rivals: Vec<RivalDocument>,
    /// Under which changes of the data the effect is still there; those that the data allow.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub survivals: Vec<SurvivalDocument>,
    /// A caution about the finding; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// The joint and variable that a finding is a function of.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct Against {
    /// Name of the joint whose variable it is; null for time.
    pub joint: Option<String>,
    /// `q`, `qd`, `qdd`, `tau` or `time`.
    pub variable: String,
}

/// Why an effect is believed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct FindingEvidence {
    /// Decrease of the weighted sum of squares when the effect is added, divided by what is left per degree of freedom.
    pub gain: Option<f64>,
    /// BIC difference against leaving it out, parameters and shapes tried paid for.
    pub log_evidence_ratio: Option<f64>,
    /// Chance of such a gain without the effect, times the number of hypotheses tried.
    pub p_value: Option<f64>,
    /// Gain on blocks of time that were left out of the fit.
    pub held_out_blocks: EvaluatedFigure,
    /// Gain on one half of the periods when fitted to the other.
    pub held_out_periods: EvaluatedFigure,
}

/// The model without an effect and with it on held-out data: RMS over its joints [N m or N].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct FindingHeldOut {
    /// Root mean square error without the effect.
    pub before: EvaluatedFigure,
    /// Root mean square error with the effect.
    pub after: EvaluatedFigure,
    /// Whether the error changed beyond chance.
    pub change: ChangeCode,
    /// Probability of a change at least as large by chance, from 0 to 1.
    pub p_value: EvaluatedFigure,
}

/// Another effect that the data do not exclude in a finding's place.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Rival))]
#[serde(default)]
pub struct RivalDocument {
    /// Code of the other effect.
    pub effect: String,
    /// Names of the joints that it acts on.
    pub joints: Vec<String>,
    /// BIC difference in favour of the finding; below zero the rival fits better.
    pub evidence: Option<f64>,
    /// Of a law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<LawDocument>,
}

/// A law in symbols: `q4` and `qd4` are position and speed of the fourth joint, in SI units.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Law))]
#[serde(default)]
pub struct LawDocument {
    /// What is added to the torque of the first of the finding's joints.
    #[cfg_attr(feature = "service", schema(example = "k*(q1 + r*q3)"))]
    pub expression: String,
    /// The same of every joint that it acts on.
    pub torques: Vec<LawTorque>,
    /// The energy that the torques are the gradient of (J); null for friction and where no energy is known.
    pub energy: Option<String>,
    /// Positions and speeds in it.
    pub variables: Vec<String>,
    /// Where the log has them: the law holds there, and nothing is known of it elsewhere.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub covered: Vec<CoveredRange>,
    /// The torque of every joint, then the energy, as MathML.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mathml: Vec<String>,
}

/// The least and largest value of a variable over the identification logs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct CoveredRange {
    /// The variable, such as `q4`.
    pub variable: String,
    /// Least value, in `unit`.
    pub low: f64,
    /// Largest value, in `unit`.
    pub high: f64,
    /// Unit of the variable.
    pub unit: String,
}

/// What a law adds to the torque of one joint [N m or N].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct LawTorque {
    /// Name of the joint.
    pub joint: String,
    /// The formula in symbols, in SI units.
    pub expression: String,
}

impl LawDocument {
    /// `joints` are the names of the joints that the formula acts on, in its order.
    pub(crate) fn new(formula: &Formula, joints: &[String]) -> Self {
        let torque = |((_, expression), joint): (&(usize, String), &String)| LawTorque {
            joint: joint.clone(),
            expression: expression.clone(),
        };
        let torques: Vec<LawTorque> = formula.torques.iter().zip(joints).map(torque).collect();
        Self {
            expression: torques.first().map(|t| t.expression.clone()).unwrap_or_default(),
            torques,
            energy: formula.energy.clone(),
            variables: formula.variables.clone(),
            covered: Vec::new(),
            mathml: formula
                .torques
                .iter()
                .map(|t| &t.1)
                .chain(&formula.energy)
                .filter_map(|text| mathml(text))
                .collect(),
        }
    }

    pub(super) fn with_covered(mut self, covered: &[Covered]) -> Self {
        let range = |c: &Covered| CoveredRange {
            variable: c.variable.clone(),
            low: c.low,
            high: c.high,
            unit: c.unit.clone(),
        };
        self.covered = covered.iter().map(range).collect();
        self
    }
}

/// Whether a finding survives a change of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Survival))]
pub struct SurvivalDocument {
    /// The change of the data.
    pub perturbation: PerturbationCode,
    /// Whether the effect is still found after it.
    pub survives: bool,
}

/// A change of the data that should not matter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Perturbation))]
#[serde(rename_all = "snake_case")]
pub enum PerturbationCode {
    /// Torques are rounded to six digits.
    SixDigits,
    /// Every second row is left out.
    EverySecondRow,
    /// Only the first half of the rows, or of the periods, is used.
    FirstHalf,
    /// Only the second half of the rows, or of the periods, is used.
    SecondHalf,
    /// The cut-off frequency of the row filter is a quarter lower.
    LowerCutoff,
    /// The cut-off frequency of the row filter is a quarter higher.
    HigherCutoff,
}

/// What no effect explains.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = Remainder))]
#[serde(default)]
pub struct RemainderDocument {
    /// Names of the joints that it is left on.
    pub joints: Vec<String>,
    /// `q2`, `qd4`, `load3`, `time` for a drift over the log (with speeds: of friction), `period` for another level in every
    /// period; strongest first.
    pub depends_on: Vec<String>,
    /// Share of it that smooth functions of these variables predict.
    pub predicted_share: Option<f64>,
    /// RMS above the noise, per joint of `joints` [N m or N]; of logs without periods the least that is misfit.
    pub rms: Vec<Option<f64>>,
    /// Remark of the test that found it; `sentence` is what people read.
    pub note: String,
    /// What is left, with its figures.
    pub sentence: String,
}

/// An effect that every robot may have and that was not found: what the data say of its size.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct UndetectedEffect {
    /// Code of the effect.
    pub effect: String,
    /// Name of the joint.
    pub joint: String,
    /// Estimate and standard deviation of its size.
    pub parameter: EffectParameter,
    /// Whether the model has it all the same, as a nuisance offset.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub in_model: bool,
}

/// A joint that takes no part in the diagnosis.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(default)]
pub struct UntestedJoint {
    /// Name of the joint.
    pub joint: String,
    /// Why no effect was looked for on it.
    pub reason: String,
}
