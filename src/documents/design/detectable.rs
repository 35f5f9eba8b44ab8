//! What a recording of the trajectory would reveal.

use super::finite;
use crate::diagnosis::{Detectable, Hidden, Inseparable, Plan, Visible};
use crate::effects::ParameterInfo;
use crate::excitation::Problem;
use serde::Serialize;

/// What the planned recording would reveal: of every effect on every joint the smallest size that a diagnosis finds, from the
/// information matrix.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = Detectable))]
pub struct DetectableDocument {
    /// Chance that an effect of the size given is found.
    #[cfg_attr(feature = "service", schema(example = 0.9))]
    pub power: f64,
    /// Largest chance of a false finding in one log, that of a diagnosis.
    #[cfg_attr(feature = "service", schema(example = 0.001))]
    pub false_alarm: f64,
    /// Periods recorded: as asked for, and two at least, because one does not measure the noise.
    pub periods: f64,
    /// Standard deviation of the torque noise of every joint, white at the sample rate [N·m or N]. Sizes grow in proportion to
    /// it.
    pub torque_noise: Vec<f64>,
    /// Where that comes from: `request`, `model` (the noise of its data), `effort_limits` (a thousandth of each) or `unit` (1
    /// where a joint has no effort limit).
    #[cfg_attr(feature = "service", schema(example = "request"))]
    pub noise_source: &'static str,
    /// One entry per effect, place and parameter that has a size.
    pub effects: Vec<DetectableEffectDocument>,
    /// Effects that are found, but cannot be distinguished at the sizes given.
    pub pairs: Vec<InseparableDocument>,
}

/// The smallest size of one effect that is found.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = DetectableEffect))]
pub struct DetectableEffectDocument {
    /// Code of the effect, such as `stribeck_friction`.
    #[cfg_attr(feature = "service", schema(example = "joint_spring"))]
    pub effect: String,
    /// None for an effect of the whole robot.
    pub joints: Vec<String>,
    /// The parameter that has the size; of a gain, its deviation from 1.
    #[cfg_attr(feature = "service", schema(example = "stiffness"))]
    pub parameter: String,
    /// Unit of the sizes.
    #[cfg_attr(feature = "service", schema(example = "N m/rad"))]
    pub unit: String,
    /// Smallest size that is found with the power given; null where none is.
    pub size: Option<f64>,
    /// Why there is no size: `absorbed` (base parameters imitate the effect exactly), `no_torque` (this motion makes it change no
    /// torque), `beyond_range` (it would have to be larger than such effects are on robots), `shown_once` (one part of the motion
    /// alone shows it, which the rest could not confirm), `no_values` (it depends on the torques of the robot, which has no prior
    /// parameters), `against_model` (a change that is seen against an existing model only), `between_periods` (looked for
    /// between the periods, from three on).
    #[cfg_attr(feature = "service", schema(example = "absorbed"))]
    pub hidden: Option<&'static str>,
    /// Values that the other parameters are assumed to have: the middle of what a diagnosis tries.
    pub assumed: Vec<AssumedParameterDocument>,
}

/// A shape parameter of an effect and the value that the prediction assumes for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = AssumedParameter))]
pub struct AssumedParameterDocument {
    /// Name of the parameter, such as `phase`.
    pub name: String,
    /// Value that is assumed, in `unit`.
    pub value: f64,
    /// Unit of the value; empty for pure numbers.
    pub unit: String,
}

/// Two effects that cannot be distinguished at the size at which the first is found: a diagnosis names either, and the other as
/// its rival.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "service", schema(as = InseparableEffects))]
pub struct InseparableDocument {
    /// Code of the effect that is present.
    pub effect: String,
    /// Names of the joints that it acts on.
    pub joints: Vec<String>,
    /// The parameter of the effect that has the size.
    pub parameter: String,
    /// Code of the other effect.
    pub rival: String,
    /// Names of the joints that the other effect acts on.
    pub rival_joints: Vec<String>,
    /// Of the two, where base parameters do not imitate them.
    pub correlation: f64,
    /// Size of the effect from which on the log excludes the rival, with the same power; null where no size does.
    pub told_apart_from: Option<f64>,
    /// Unit of the size.
    pub unit: String,
}

/// A recording that was assessed.
pub struct Assessed<'a> {
    /// Length of the recording, its noise and the false-alarm rate.
    pub plan: Plan<'a>,
    /// Where the torque noise comes from, as `noise_source` of the answer.
    pub noise_source: &'static str,
    /// Smallest detectable sizes and pairs that cannot be separated.
    pub found: Detectable,
}

pub(super) fn detectable(problem: &Problem, assessed: &Assessed) -> DetectableDocument {
    let joints = problem.robot().joints();
    let names = |list: &[usize]| -> Vec<String> { list.iter().map(|&j| joints[j].name.clone()).collect() };
    let pair = |p: &Inseparable| InseparableDocument {
        effect: p.effect.clone(),
        joints: names(&p.joints),
        parameter: p.parameter.clone(),
        rival: p.rival.clone(),
        rival_joints: names(&p.rival_joints),
        correlation: p.correlation,
        told_apart_from: p.told_apart_from.and_then(finite),
        unit: p.unit.clone(),
    };
    DetectableDocument {
        power: assessed.found.power,
        false_alarm: assessed.plan.chance,
        periods: assessed.plan.periods,
        torque_noise: assessed.plan.torque_noise.to_vec(),
        noise_source: assessed.noise_source,
        effects: assessed.found.effects.iter().map(|v| effect(v, names(&v.joints))).collect(),
        pairs: assessed.found.pairs.iter().map(pair).collect(),
    }
}

fn effect(visible: &Visible, joints: Vec<String>) -> DetectableEffectDocument {
    let assumed = |(info, value): &(ParameterInfo, f64)| AssumedParameterDocument {
        name: info.name.clone(),
        value: *value,
        unit: info.unit.clone(),
    };
    DetectableEffectDocument {
        effect: visible.effect.clone(),
        joints,
        parameter: visible.parameter.name.clone(),
        unit: visible.parameter.unit.clone(),
        size: visible.size.ok().and_then(finite),
        hidden: visible.size.err().map(why),
        assumed: visible.assumed.iter().map(assumed).collect(),
    }
}

fn why(hidden: Hidden) -> &'static str {
    match hidden {
        Hidden::Absorbed => "absorbed",
        Hidden::NoTorque => "no_torque",
        Hidden::BeyondRange(_) => "beyond_range",
        Hidden::ShownOnce => "shown_once",
        Hidden::NeedsValues => "no_values",
        Hidden::AgainstModel => "against_model",
        Hidden::BetweenPeriods => "between_periods",
    }
}
