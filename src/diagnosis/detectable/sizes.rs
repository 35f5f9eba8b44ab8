//! The smallest size of every effect that is found.

use super::gains::{Gain, Gains};
use super::generalisation::generalises_from;
use super::physical::{is_physical, is_real};
use super::planned::{Planned, tried};
use super::power::noncentrality;
use super::signals::Signal;
use crate::diagnosis::selection::Candidate;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::{self, EffectKind, ParameterInfo};
use crate::regression::SETTINGS as REGRESSION;
use rayon::prelude::*;
use std::collections::HashMap;

/// Why an effect is not seen, whatever its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hidden {
    /// The base parameters imitate it exactly: an identification takes it up in them.
    Absorbed,
    /// It changes no torque on this motion.
    NoTorque,
    /// It would have to be larger than it is on robots, where the diagnosis takes it for an imitation; the size at which its
    /// columns would be seen.
    BeyondRange(f64),
    /// One part of the motion alone shows it, which the rest could not confirm.
    ShownOnce,
    /// Its torque depends on those of the robot, of which no values are known.
    NeedsValues,
    /// It is a part of the base parameters, and seen only as a change against an existing model.
    AgainstModel,
    /// It is looked for between the periods, from three on.
    BetweenPeriods,
}

/// What is seen of an effect on one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Visible {
    /// Code of the effect.
    pub effect: String,
    /// None for the whole robot.
    pub joints: Vec<usize>,
    /// What has the size.
    pub parameter: ParameterInfo,
    /// Sign of the size, where the effect has both: the one that is harder to see.
    pub sign: f64,
    /// The other parameters, as they are assumed.
    pub assumed: Vec<(ParameterInfo, f64)>,
    /// The smallest that is found.
    pub size: Result<f64, Hidden>,
    /// Place of its signal.
    pub(super) signal: usize,
}

/// Noncentralities that candidates need, by effect, cost and grid.
type Needed = HashMap<(String, usize, usize), f64>;

pub(super) fn sizes(planned: &Planned, signals: &[Signal], gains: &Gains) -> Vec<Visible> {
    let needed = needed(planned, gains);
    let of = |at: usize| visible(planned, signals, gains, &needed, at);
    (0..signals.len()).into_par_iter().map(of).collect()
}

fn key(candidate: &Candidate, gain: &Gain) -> (String, usize, usize) {
    (candidate.effect.code().into(), gain.cost, tried(candidate))
}

fn needed(planned: &Planned, gains: &Gains) -> Needed {
    let mut needed = Needed::new();
    for (candidate, row) in planned.candidates.iter().zip(gains) {
        for gain in row.iter().flatten() {
            let threshold = || planned.threshold(candidate, gain.cost);
            needed
                .entry(key(candidate, gain))
                .or_insert_with(|| noncentrality(threshold(), gain.cost, SETTINGS.detectable.power));
        }
    }
    needed
}

fn visible(planned: &Planned, signals: &[Signal], gains: &Gains, needed: &Needed, at: usize) -> Visible {
    let signal = &signals[at];
    let candidate = &planned.candidates[signal.candidate];
    let infos = candidate
        .effect
        .parameters(candidate.form, &planned.system.model.robot, &candidate.joints);
    let both = !candidate.effect.positive(candidate.form).contains(&signal.parameter);
    let signs: &[f64] = if both { &[1.0, -1.0] } else { &[1.0] };
    let least = least_size(planned, signals, gains, needed, at, signs);
    let (sign, size) = signs
        .iter()
        .zip(least)
        .fold((1.0, 0.0), |a, (sign, size)| if size > a.1 { (*sign, size) } else { a });
    let seen = match () {
        _ if signal.own == 0.0 => Err(Hidden::NoTorque),
        _ if signal.left < REGRESSION.hidden_share * signal.own => Err(Hidden::Absorbed),
        _ if size.is_infinite() && passes_by_gain(planned, gains, needed, at, signs) => Err(Hidden::ShownOnce),
        _ if !is_real(planned, candidate, signal, sign * size) => Err(Hidden::BeyondRange(size)),
        _ => Ok(size),
    };
    Visible {
        effect: candidate.effect.code().into(),
        joints: candidate.joints.clone(),
        assumed: assumed(candidate, signal, &infos),
        parameter: infos[signal.parameter].clone(),
        sign,
        size: seen,
        signal: at,
    }
}

/// The size at which some candidate passes with the power asked for, by its gain and on folds left out.
fn least_size(planned: &Planned, signals: &[Signal], gains: &Gains, needed: &Needed, at: usize, signs: &[f64]) -> Vec<f64> {
    let mut least = vec![f64::INFINITY; signs.len()];
    for (by_gain, candidate, gain) in by_gain(planned, gains, needed, at) {
        if least.iter().all(|known| by_gain >= *known) {
            break;
        }
        let size = by_gain.max(generalises_from(planned, candidate, &gain.shape, &signals[at]));
        for (known, sign) in least.iter_mut().zip(signs) {
            if size < *known && is_physical(planned, candidate, gain, sign * size) {
                *known = size;
            }
        }
    }
    least
}

/// The sizes at which candidates gain enough, the smallest first.
fn by_gain<'a>(planned: &'a Planned, gains: &'a Gains, needed: &Needed, at: usize) -> Vec<(f64, &'a Candidate, &'a Gain)> {
    let of = |(candidate, row): (&'a Candidate, &'a Vec<Option<Gain>>)| {
        let gain = row[at].as_ref().filter(|g| g.gain > 0.0 && !g.at_an_end)?;
        Some(((needed[&key(candidate, gain)] / gain.gain).sqrt(), candidate, gain))
    };
    let mut open: Vec<_> = planned.candidates.iter().zip(gains).filter_map(of).collect();
    open.sort_by(|a, b| a.0.total_cmp(&b.0));
    open
}

/// Whether it is for the folds left out alone that no candidate passes.
fn passes_by_gain(planned: &Planned, gains: &Gains, needed: &Needed, at: usize, signs: &[f64]) -> bool {
    let physical = |(size, candidate, gain): &(f64, &Candidate, &Gain)| {
        signs.iter().any(|sign| is_physical(planned, candidate, gain, sign * size))
    };
    by_gain(planned, gains, needed, at).iter().any(physical)
}

/// Values of the other parameters that an effect is assumed to have.
fn assumed(candidate: &Candidate, signal: &Signal, infos: &[ParameterInfo]) -> Vec<(ParameterInfo, f64)> {
    let values = match candidate.is_distortion() {
        true => signal.unit.clone(),
        false => candidate.effect.reported(candidate.form, &signal.unit, &signal.shape),
    };
    let other = |i: &usize| *i != signal.parameter;
    let listed = (0..infos.len().min(values.len())).filter(other);
    listed
        .filter(|&i| !is_function_of_size(candidate, i))
        .map(|i| (infos[i].clone(), values[i]))
        .collect()
}

/// The stiffness of a gear is its compliance in another unit.
fn is_function_of_size(candidate: &Candidate, parameter: usize) -> bool {
    candidate.is_distortion() && parameter >= candidate.effect.steps().len()
}

/// Beside the effects that have a size, those that no identification log shows.
pub(super) fn with_the_others(planned: &Planned, mut list: Vec<Visible>) -> Vec<Visible> {
    let robot = &planned.system.model.robot;
    for effect in effects::all() {
        let why = match effect.kind() {
            // Over a log it is seen between the periods.
            EffectKind::AgainstModel if effect.code() != "friction_drift" => Hidden::AgainstModel,
            EffectKind::AgainstModel | EffectKind::BetweenPeriods => Hidden::BetweenPeriods,
            kind if !planned.has_values && (kind == EffectKind::Distortion || effect.reads_torques()) => Hidden::NeedsValues,
            // None of its shapes lies where robots have them and this motion shows them.
            _ => Hidden::BeyondRange(f64::INFINITY),
        };
        for joints in effect.places(robot) {
            let known = planned
                .system
                .model
                .terms
                .iter()
                .any(|t| t.effect.code() == effect.code() && t.joints == joints);
            let listed = list.iter().any(|v| v.effect == effect.code() && v.joints == joints);
            if known || listed {
                continue;
            }
            let Some(parameter) = effect.parameters(0, robot, &joints).into_iter().next() else {
                continue;
            };
            list.push(Visible {
                effect: effect.code().into(),
                joints,
                parameter,
                sign: 1.0,
                assumed: Vec::new(),
                size: Err(why),
                signal: usize::MAX,
            });
        }
    }
    let order = |code: &str| effects::all().iter().position(|e| e.code() == code);
    list.sort_by_key(|v| (order(&v.effect), v.joints.clone()));
    list
}
