//! What the gain of a candidate is worth: held against what is left, what it costs, and chance.

use super::candidate::{Candidate, reach};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::{self, Effect};
use crate::regression::{System, Term, chi_square_tail, misfit_from};

/// A candidate at its best shape on the grid.
#[derive(Clone)]
pub(crate) struct Scored {
    pub candidate: Candidate,
    pub term: Term,
    /// Decrease of the weighted sum of squares.
    pub gain: f64,
    /// Parameters that pay for it: rank of the columns plus shapes.
    pub cost: usize,
    /// Shapes tried.
    pub tried: usize,
    /// Gain divided by what is left after it per degree of freedom, where that is more than noise.
    pub fair_gain: f64,
    /// BIC difference: fair gain less what the parameters and the shapes tried cost.
    pub evidence: f64,
    /// What the gain was divided by; none without measured noise.
    dispersion: Option<f64>,
    /// Joints reached.
    joints: Vec<usize>,
}

impl Scored {
    /// Fair gain and evidence where what is left after a gain is taken as the least that any of `others` leaves, of those on the
    /// same joints and those that are [decided](Self::is_decided_with) beside this one: one yardstick for all that are held
    /// against each other. What each leaves is an estimate, and a large gain divided by two that differ by a thousandth is two
    /// gains that differ by more than any parameter costs.
    pub fn held_against<'a>(&self, others: impl Iterator<Item = &'a Scored>) -> (f64, f64) {
        let Some(own) = self.dispersion else {
            return (self.fair_gain, self.evidence);
        };
        let common = others.filter(|o| o.joints == self.joints || self.is_decided_with(o));
        let least = common.filter_map(|o| o.dispersion).fold(own, f64::min);
        let fair_gain = self.gain / least;
        (fair_gain, self.evidence - self.fair_gain + fair_gain)
    }

    /// Whether one of the two is the better account whatever is taken for noise: on joints in common it gains more and costs no
    /// more. What few joints keep is next to nothing when it is taken over all of them, which must not put an effect on all
    /// joints before one on a single joint that gains more.
    fn is_decided_with(&self, other: &Scored) -> bool {
        let meets = self.joints.iter().any(|j| other.joints.contains(j));
        let price = |s: &Scored| s.fair_gain - s.evidence;
        let better = |a: &Scored, b: &Scored| a.gain >= b.gain && price(a) <= price(b);
        meets && (better(self, other) || better(other, self))
    }
}

impl Scored {
    /// Whether it may leave nothing but noise on `joints` of `system`, beside which it has been scored and not yet fitted: the
    /// linearised gain is a fraction of the true one.
    pub fn could_settle(&self, system: &System, joints: &[usize]) -> bool {
        let rows: usize = joints.iter().map(|&j| system.rows(j)).sum();
        let gain = self.gain / SETTINGS.selection.linear_gain;
        system.mean_square(joints) - gain / rows.max(1) as f64 <= misfit_from(rows)
    }
}

/// Of the forms of one effect on the same joints the first.
pub(crate) fn one_form_each(list: &mut Vec<&Scored>) {
    let mut seen: Vec<(&str, &[usize])> = Vec::new();
    list.retain(|s| {
        let own = (s.candidate.effect.code(), &s.candidate.joints[..]);
        let new = !seen.contains(&own);
        seen.push(own);
        new
    });
}

/// Weighs a gain against what it costs.
pub(crate) fn appraise(
    system: &System,
    candidate: &Candidate,
    term: Term,
    gain: f64,
    rank: usize,
    tried: usize,
    after: Option<&System>,
) -> Scored {
    let cost = rank
        + if candidate.is_distortion() {
            0
        } else {
            candidate.free_shapes()
        };
    let joints = reach(candidate, system.model.robot.joint_count());
    let Weighed {
        fair_gain,
        evidence,
        dispersion,
    } = weigh(system, &joints, gain, cost, tried as f64, after);
    Scored {
        candidate: candidate.clone(),
        term,
        gain,
        cost,
        tried,
        fair_gain,
        evidence,
        dispersion,
        joints,
    }
}

/// A gain in units of what is left, and the evidence that it makes.
pub(crate) struct Weighed {
    pub fair_gain: f64,
    pub evidence: f64,
    /// What the gain was divided by; none without measured noise.
    dispersion: Option<f64>,
}

/// Weighs a gain on `joints` against the `cost` in parameters, with `tried` choices made.
pub(crate) fn weigh(system: &System, joints: &[usize], gain: f64, cost: usize, tried: f64, after: Option<&System>) -> Weighed {
    let dispersion = system.noise_is_measured.then(|| dispersion(system, joints, gain, after));
    let (fair_gain, rows) = match dispersion {
        Some(dispersion) => {
            let rows = (0..system.model.robot.joint_count()).map(|j| system.rows(j)).sum::<usize>() as f64;
            (gain / dispersion, rows)
        }
        None => likelihood_gain(system, joints, gain, after),
    };
    Weighed {
        fair_gain,
        evidence: fair_gain - cost as f64 * rows.ln() - 2.0 * tried.ln(),
        dispersion,
    }
}

/// What a gain is measured against, on the joints reached: the mean square of the whitened residual once the gain is taken off,
/// where the part that is not noise counts for as many rows as go together in it, because a misfit is smooth and its rows are no
/// independent witnesses. `after` is the model with the candidate, where it has been fitted.
fn dispersion(system: &System, joints: &[usize], gain: f64, after: Option<&System>) -> f64 {
    let rows: usize = joints.iter().map(|&j| system.rows(j)).sum();
    let left = system.mean_square(joints) - gain / rows.max(1) as f64;
    if left <= 1.0 {
        1.0
    } else {
        1.0 + (left - 1.0) * after.unwrap_or(system).persistence(joints)
    }
}

/// Without measured noise: `n ln(χ₀²/χ²)`, twice the log of the likelihood ratio with unknown variance, n the rows that are worth
/// something of their own; and n.
fn likelihood_gain(system: &System, joints: &[usize], gain: f64, after: Option<&System>) -> (f64, f64) {
    let before: f64 = joints.iter().map(|&j| system.joint_chi_square(j)).sum();
    let rows: f64 = joints.iter().map(|&j| after.unwrap_or(system).effective_rows(j)).sum();
    let share = (gain / before.max(f64::MIN_POSITIVE)).min(1.0 - 1e-12);
    (-rows * (-share).ln_1p(), rows.max(2.0))
}

/// How likely a gain as large as this is without the effect: χ² of as many degrees of freedom as parameters.
pub(crate) fn chance(fair_gain: f64, parameters: usize) -> f64 {
    chi_square_tail(fair_gain, parameters.max(1))
}

/// What the chance of a gain is multiplied with: number of effects, own ones among them, times the places, forms and shapes that
/// this one was tried with. Every effect has the same share of false findings (weighted Bonferroni); a fine grid of one does not
/// make the others harder to find.
pub(crate) fn hypotheses(candidates: &[Candidate], code: &str) -> f64 {
    let own: usize = candidates
        .iter()
        .filter(|c| c.effect.code() == code)
        .map(|c| c.grid().len())
        .sum();
    let mut defined: Vec<&str> = candidates
        .iter()
        .filter_map(|c| c.effect.own())
        .map(|own| own.code())
        .collect();
    defined.dedup();
    (own.max(1) * (effects::all().len() + defined.len())) as f64
}
