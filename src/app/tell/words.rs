//! How effects, their parameters and variables are spoken of.

use crate::diagnosis::Finding;
use crate::effects::Formula;
use crate::effects::own::FOUND_LAW;
use crate::formats::{listed, measured, unit};

/// How an effect is spoken of.
pub(super) struct Known {
    code: &'static str,
    /// As the subject of a sentence.
    phrase: &'static str,
    /// What of its joint it is a function of, for pictures: `q`, `qd`, `qdd`, `tau` or `time`.
    pub(super) variable: &'static str,
}

const fn effect(code: &'static str, phrase: &'static str, variable: &'static str) -> Known {
    Known { code, phrase, variable }
}

const KNOWN: &[Known] = &[
    effect("torque_offset", "a constant torque offset", "time"),
    effect("stribeck_friction", "Stribeck friction", "qd"),
    effect("nonlinear_viscous_friction", "nonlinear viscous friction", "qd"),
    effect("asymmetric_viscous_friction", "direction-dependent viscous friction", "qd"),
    effect("load_dependent_friction", "load-dependent friction", "tau"),
    effect("presliding_hysteresis", "presliding friction hysteresis", "q"),
    effect("smooth_coulomb_friction", "Coulomb friction smooth around zero speed", "qd"),
    effect("rotor_inertia", "rotor inertia", "qdd"),
    effect("transmission_coupling", "transmission coupling", "qd"),
    effect("joint_spring", "a joint spring", "q"),
    effect("position_ripple", "position ripple", "q"),
    effect("joint_elasticity", "elasticity between motor and link", "tau"),
    effect("encoder_offset", "an encoder offset", "q"),
    effect("base_tilt", "a base tilt", "q"),
    effect("payload", "a payload at the last link", "tau"),
    effect("torque_delay", "a torque delay", "qd"),
    effect("torque_gain", "a torque scale error", "tau"),
    effect("torque_crosstalk", "torque crosstalk", "tau"),
    effect("law", "a law", "q"),
    effect("friction_drift", "friction that changes over time", "time"),
    effect("external_contact", "an external contact", "time"),
];

pub(super) fn known(code: &str) -> Option<&'static Known> {
    KNOWN.iter().find(|k| k.code == code)
}

pub(super) fn phrase(code: &str) -> &str {
    known(code).map_or(code, |k| k.phrase)
}

/// A finding, or a rival, as the subject of a sentence; laws and own effects with their formula.
pub(super) fn subject(code: &str, formula: Option<&Formula>, joints: &[String]) -> String {
    let Some(formula) = formula else {
        return phrase(code).to_string();
    };
    let each: Vec<String> = formula
        .torques
        .iter()
        .zip(joints)
        .map(|((_, text), joint)| format!("{text} on {joint}"))
        .collect();
    let energy = formula.energy.as_ref().map(|e| format!(" (energy {e})"));
    let what = match code {
        law if law == "law" || law.starts_with(FOUND_LAW) => "the law".to_string(),
        own => format!("the own effect {own},"),
    };
    format!("{what} {}{}", listed(&each, "and"), energy.unwrap_or_default())
}

pub(super) fn parameters(f: &Finding) -> String {
    let one = |p: &crate::diagnosis::ReportedParameter| {
        let value = format!(
            "{} {} {}",
            p.name.replace('_', " "),
            measured(p.value, p.std_dev),
            unit(&p.unit)
        );
        value.trim_end().to_string()
    };
    listed(&f.parameters.iter().map(one).collect::<Vec<_>>(), "and")
}

/// With a capital and a full stop.
pub(super) fn sentence(text: &str) -> String {
    let mut letters = text.trim_end_matches('.').chars();
    let first: String = letters.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

/// A variable of a remainder as it is said: states of joints by their symbols.
pub(super) fn variable_in_words(name: &str) -> &str {
    match name {
        "time" => "the time of the log, whatever the motion",
        "period" => "which period of the log it is",
        symbol => symbol,
    }
}
