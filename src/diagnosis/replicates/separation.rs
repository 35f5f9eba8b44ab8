//! What changes from one period to the next: friction that drifts, and contacts. The average hides both.
//!
//! Deviations of every period from the average need no model of the robot. Drift on a joint is friction columns times the course
//! of warming up; a contact is a level on all joints in an interval of time. Whichever explains more is taken out of the data,
//! and the search goes on until neither is beyond chance. Where a level of one joint that goes with time or period, which no
//! cause is known of, explains clearly more, it is taken out as well, and reported as a remainder.

use super::channel::{Following, best_following};
use super::contact::{best_contact, shortest};
use super::drift::best_drift;
use super::instability::{TakenOut, Unsteady};
use super::level_search::{best_level, without_slow};
use super::period_finding::{BetweenFinding, Explained, Seams, median_period, start_rows};
use crate::diagnosis::settings::SETTINGS;
use crate::model::Robot;
use crate::regression::{NoiseModel, Stretch};

/// What changes between the periods, and the stretches without it.
pub(crate) struct Separated {
    /// Without drift, contacts and levels: what the model is fitted to.
    pub steady: Vec<Stretch>,
    /// Without drift and contacts, which are explained: what errors are reported for.
    pub explained: Vec<Stretch>,
    pub found: Vec<BetweenFinding>,
    /// Levels that nothing explains.
    pub unsteady: Vec<Unsteady>,
    /// Joints whose torque follows a channel. It is still in the data: a law has to explain it.
    pub following: Vec<Following>,
}

impl Separated {
    /// The stretches as they are.
    pub fn nothing(stretches: &[Stretch]) -> Self {
        Self {
            steady: stretches.to_vec(),
            explained: stretches.to_vec(),
            found: Vec::new(),
            unsteady: Vec::new(),
            following: Vec::new(),
        }
    }
}

pub(crate) fn separate(robot: &Robot, stretches: &[Stretch], limit: f64) -> Separated {
    let mut all = Separated {
        steady: Vec::new(),
        explained: Vec::new(),
        found: Vec::new(),
        unsteady: Vec::new(),
        following: Vec::new(),
    };
    for stretch in stretches {
        let mut steady = stretch.clone();
        let mut explained = stretch.clone();
        if stretch.periods.len() >= 3 {
            // One sample of the motion to every row, and no filter.
            let own = steady.unfiltered.take();
            explained.unfiltered = None;
            let mut rows = own
                .as_ref()
                .map_or_else(|| stretch.as_coarse(), |u| Stretch::clone(&u.stretch));
            let first = all.following.len();
            let taken = separated(robot, &mut rows, limit, &mut all.found, &mut all.following);
            if let Some(noise) = robust_noise(&rows).filter(|_| taken.count() > 0) {
                all.unsteady.extend(taken.reported(&rows, &noise));
            }
            put_back(&all.following[first..], &mut rows);
            let whole = taken.put_back(&rows);
            let filtered = |found: Stretch| match &own {
                Some(u) => (found.periods.iter().map(|p| u.rows(p)).collect(), u.rows(&found.torque)),
                None => (found.periods, found.torque),
            };
            (explained.periods, explained.torque) = filtered(whole);
            (steady.periods, steady.torque) = filtered(rows);
        }
        all.steady.push(steady);
        all.explained.push(explained);
    }
    all
}

/// Takes out of a stretch what changes between its periods, the strongest first; levels are handed back.
fn separated(
    robot: &Robot,
    stretch: &mut Stretch,
    limit: f64,
    found: &mut Vec<BetweenFinding>,
    following: &mut Vec<Following>,
) -> TakenOut {
    let mut taken = TakenOut::default();
    let (mut named, most_levels) = (0, 2 * stretch.joints());
    leave_out_start(stretch);
    let mut seams = Seams::of_start(stretch);
    let mut start = start_rows(stretch);
    while named < SETTINGS.replicates.most_findings && taken.count() < most_levels {
        let Some(noise) = robust_noise(stretch) else { break };
        let best = best_named(robot, stretch, &noise, &seams).filter(|(f, _)| f.p_value < limit);
        let least = best
            .as_ref()
            .map_or(f64::NEG_INFINITY, |(f, _)| f.evidence() + SETTINGS.nonparametric.preference);
        // Of a time and a channel that explain alike, the channel is the cause.
        let tied = best.as_ref().map_or(0.0, |(f, _)| f.evidence()) - SETTINGS.alternatives.not_excluded;
        let follows = best_following(stretch, &noise, &seams).filter(|f| f.p_value < limit && f.evidence > tied.max(0.0));
        if let Some(follows) = follows.filter(|_| following.len() < most_levels) {
            take_out(&follows, stretch);
            following.push(follows);
            leave_out_start(stretch);
            continue;
        }
        let level = best_level(stretch, &noise, start_rows(stretch), limit).filter(|l| l.evidence > least);
        match (level, best) {
            (Some(level), _) => taken.take(level, stretch),
            (None, Some((finding, periods))) => {
                stretch.periods = periods;
                named += 1;
                if let Some(filled) = &finding.filled {
                    seams.add(filled, stretch.rows());
                }
                // What continues from the start is still the start, and so is what continues from that: friction builds up over
                // as far as the joint has moved, in more than one piece. It is left out, and is nothing that somebody did to
                // the arm.
                match finding.first_row {
                    Some(first) if first <= start + shortest(stretch) => {
                        start = finding.filled.as_ref().map_or(start, |filled| start.max(filled.end));
                    }
                    _ => found.push(finding),
                }
            }
            (None, None) => break,
        }
        leave_out_start(stretch);
    }
    taken
}

fn take_out(following: &Following, stretch: &mut Stretch) {
    add(following, stretch, -1.0);
}

/// What [`take_out`] took of all of them.
fn put_back(all: &[Following], stretch: &mut Stretch) {
    all.iter().for_each(|f| add(f, stretch, 1.0));
    let periods: Vec<usize> = (0..stretch.periods.len()).collect();
    stretch.torque = stretch.mean_over(&periods);
}

fn add(following: &Following, stretch: &mut Stretch, factor: f64) {
    for (period, own) in stretch.periods.iter_mut().zip(&following.torque) {
        let torque = period[following.joint].iter_mut();
        torque.zip(own).for_each(|(t, v)| *t += factor * v);
    }
}

/// Drift or contact, whichever explains more.
fn best_named(robot: &Robot, stretch: &Stretch, noise: &[NoiseModel], seams: &Seams) -> Option<Explained> {
    let determined = |(finding, _): &Explained| finding.is_determined();
    let drift = best_drift(robot, stretch, noise, seams).filter(determined);
    let contact = best_contact(robot, stretch, noise, seams).filter(determined);
    match (drift, contact) {
        (Some(d), Some(c)) => Some(if d.0.gain > c.0.gain { d } else { c }),
        (d, c) => d.or(c),
    }
}

/// Fills the start with the mean of the other periods, as they are by now, and takes the mean over all.
fn leave_out_start(stretch: &mut Stretch) {
    let count = stretch.periods.len();
    for s in 0..start_rows(stretch) {
        for j in 0..stretch.joints() {
            stretch.periods[0][j][s] = stretch.periods[1..].iter().map(|p| p[j][s]).sum::<f64>() / (count - 1) as f64;
        }
    }
    let all: Vec<usize> = (0..count).collect();
    stretch.torque = stretch.mean_over(&all);
}

/// Noise from the quieter half of the periods of every joint, so that one disturbed period raises neither its level nor its
/// correlation, and levels that differ between the periods do not either.
fn robust_noise(stretch: &Stretch) -> Option<Vec<NoiseModel>> {
    let stretch = &without_slow(stretch);
    (0..stretch.joints())
        .map(|j| {
            let median = median_period(stretch, j);
            let mut periods: Vec<(f64, usize)> = (0..stretch.periods.len())
                .map(|p| {
                    (
                        stretch.periods[p][j]
                            .iter()
                            .zip(&median)
                            .map(|(t, m)| (t - m) * (t - m))
                            .sum(),
                        p,
                    )
                })
                .collect();
            periods.sort_by(|a, b| a.0.total_cmp(&b.0));
            let quiet: Vec<usize> = periods.iter().take(periods.len().div_ceil(2).max(2)).map(|p| p.1).collect();
            let half = Stretch {
                torque: stretch.mean_over(&quiet),
                periods: quiet.iter().map(|&p| stretch.periods[p].clone()).collect(),
                ..stretch.clone()
            };
            NoiseModel::from_periods(&[half], j)
        })
        .collect()
}
