//! How effects, their parameters and variables are spoken of.

use crate::diagnosis::Finding;
use crate::effects::own::FOUND_LAW;
use crate::effects::{Effect, Formula, PlotVariable, by_code};
use crate::formats::{listed, measured, unit};

/// What the effect of a finding is drawn against: `q`, `qd`, `qdd`, `tau` or `time`.
pub(super) fn variable(effect: &dyn Effect) -> &'static str {
    match effect.about().over {
        PlotVariable::Position => "q",
        PlotVariable::Speed => "qd",
        PlotVariable::Acceleration => "qdd",
        PlotVariable::Torque => "tau",
        PlotVariable::Time => "time",
    }
}

/// An effect as the subject of a sentence: own ones by their names.
pub(super) fn phrase(code: &str) -> &str {
    by_code(code).map_or(code, |effect| effect.about().phrase)
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

/// Whether a remainder goes with time and speeds alone.
pub(super) fn is_friction_over_time(depends_on: &[String]) -> bool {
    let is_speed = |name: &String| name.starts_with("qd") && !name.starts_with("qdd");
    depends_on.len() > 1 && depends_on[0] == "time" && depends_on[1..].iter().all(is_speed)
}

/// A variable of a remainder as it is said: states of joints by their symbols.
pub(super) fn variable_in_words(name: &str) -> &str {
    match name {
        "time" => "the time of the log, whatever the motion",
        "period" => "which period of the log it is",
        symbol => symbol,
    }
}
