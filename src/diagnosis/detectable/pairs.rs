//! Effects that a recording does not tell apart.

use super::gains::{Gain, Gains};
use super::planned::Planned;
use super::signals::Signal;
use super::sizes::Visible;
use crate::diagnosis::selection::{Candidate, reach};
use crate::diagnosis::settings::SETTINGS;
use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF, Normal};

/// An effect, and one that is named beside it or in its place at the size at which it is found.
#[derive(Debug, Clone, PartialEq)]
pub struct Inseparable {
    /// Place of the effect in the list of effects.
    pub effect: String,
    /// Joints of the effect, from 0.
    pub joints: Vec<usize>,
    /// The parameter that has the size.
    pub parameter: String,
    /// Unit of the size.
    pub unit: String,
    /// Code of the other effect.
    pub rival: String,
    /// Joints of the other effect, from 0.
    pub rival_joints: Vec<usize>,
    /// Of the effect with what the rival's columns imitate of it, both orthogonal to those of the base parameters.
    pub correlation: f64,
    /// The size from which the log tells them apart with the power asked for; `None` where no size does.
    pub told_apart_from: Option<f64>,
}

/// What one effect on one place makes of a signal: its best form.
struct Account<'a> {
    candidate: &'a Candidate,
    gain: &'a Gain,
    price: f64,
}

pub(super) fn pairs(planned: &Planned, signals: &[Signal], gains: &Gains, effects: &[Visible]) -> Vec<Inseparable> {
    let of = |visible: &Visible| match visible.size {
        Ok(size) => of_effect(planned, signals, gains, visible, size),
        Err(_) => Vec::new(),
    };
    effects.iter().flat_map(of).collect()
}

fn of_effect(planned: &Planned, signals: &[Signal], gains: &Gains, visible: &Visible, size: f64) -> Vec<Inseparable> {
    let accounts = accounts(planned, gains, visible.signal, size);
    let candidate = &planned.candidates[signals[visible.signal].candidate];
    let is_own = |a: &&Account| a.candidate.effect.code() == candidate.effect.code() && a.candidate.joints == candidate.joints;
    let Some(own) = accounts.iter().find(is_own) else {
        return Vec::new();
    };
    let joints = planned.system.model.robot.joint_count();
    let reached = reach(candidate, joints);
    let meets = |a: &&Account| reach(a.candidate, joints).iter().any(|j| reached.contains(j));
    let others = accounts.iter().filter(|a| !is_own(a)).filter(meets);
    others.filter_map(|rival| between(own, rival, visible, size)).collect()
}

/// The best form of every effect on every place that gains anything.
fn accounts<'a>(planned: &'a Planned, gains: &'a Gains, signal: usize, size: f64) -> Vec<Account<'a>> {
    let mut list: Vec<Account> = Vec::new();
    let evidence = |a: &Account| a.gain.gain * size * size - a.price;
    for (candidate, row) in planned.candidates.iter().zip(gains) {
        let Some(gain) = row[signal].as_ref() else { continue };
        let price = planned.price(candidate, gain.cost);
        let new = Account { candidate, gain, price };
        let same = |a: &Account| a.candidate.effect.code() == candidate.effect.code() && a.candidate.joints == candidate.joints;
        match list.iter().position(same) {
            Some(at) if evidence(&list[at]) < evidence(&new) => list[at] = new,
            Some(_) => {}
            None => list.push(new),
        }
    }
    list
}

/// The two are rivals where the contest of a diagnosis does not exclude the other one: as expected at this size, it gains a share
/// of what the effect gains, and the evidence against it is less than excludes.
fn between(own: &Account, rival: &Account, visible: &Visible, size: f64) -> Option<Inseparable> {
    let share = rival.gain.gain / own.gain.gain;
    if share < SETTINGS.selection.linear_gain {
        return None;
    }
    let squared = size * size;
    let apart = (own.gain.gain - rival.gain.gain).max(0.0);
    let ahead = own.price - rival.price;
    let nested = contains(own, rival, visible.sign * size);
    let evidence = apart * squared - ahead;
    let excluded = evidence >= SETTINGS.alternatives.not_excluded && !nested;
    (!excluded).then(|| Inseparable {
        effect: visible.effect.clone(),
        joints: visible.joints.clone(),
        parameter: visible.parameter.name.clone(),
        unit: visible.parameter.unit.clone(),
        rival: rival.candidate.effect.code().into(),
        rival_joints: rival.candidate.joints.clone(),
        correlation: share.clamp(0.0, 1.0).sqrt(),
        told_apart_from: told_apart(own.gain.gain, apart, ahead, size).filter(|_| !nested),
    })
}

/// Whether the rival becomes the effect at a limit of its parameters that the data do not exclude at this size.
fn contains(own: &Account, rival: &Account, size: f64) -> bool {
    let (effect, code) = (&rival.candidate.effect, own.candidate.effect.code());
    let values: Vec<f64> = rival.gain.coefficients.iter().map(|c| c * size).collect();
    let covariance: &DMatrix<f64> = &rival.gain.covariance;
    effect.contains().contains(&code)
        && rival.candidate.joints == own.candidate.joints
        && effect.is_within_reach(&values, covariance)
}

/// Size with which the evidence excludes the rival with the power asked for. What the effect gains more is normal with the mean
/// `apart s²` and twice the root of that for its standard deviation: from `x² − 2 z x = excluded + ahead`, x the root.
fn told_apart(gain: f64, apart: f64, ahead: f64, size: f64) -> Option<f64> {
    // Rounding of a difference of squares: below it the two are the same.
    if apart < crate::regression::SETTINGS.hidden_share * gain {
        return None;
    }
    let z = Normal::standard().inverse_cdf(SETTINGS.detectable.power);
    let wanted = (SETTINGS.alternatives.not_excluded + ahead).max(0.0);
    let root = z + (z * z + wanted).sqrt();
    Some((root / apart.sqrt()).max(size))
}
