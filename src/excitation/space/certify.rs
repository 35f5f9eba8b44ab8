//! Proof that a trajectory keeps its distances at all times, between samples too.
//!
//! A distance changes at most as fast as the points of its bodies move. Joint k moves a point no faster than its largest velocity
//! times the farthest that the point can be from its axis, so a distance has a Lipschitz constant; an interval of time whose
//! middle is far enough is done, and others are halved until their length is worth less than [`FINEST`].

use super::distance::poses;
use super::pairs::{Against, Pair, SpaceSet};
use crate::model::Robot;
use crate::trajectory::{FourierSeries, Trajectory};
use std::f64::consts::PI;

/// How near one link comes to another, or to an obstacle.
#[derive(Debug, Clone, PartialEq)]
pub struct Clearance {
    /// Joint that carries the link, from 0.
    pub joint: usize,
    /// Name of the obstacle, or of the joint that carries the other link.
    pub from: String,
    /// Least distance seen (m), at `at_s` (s).
    pub least: f64,
    /// When the arm is closest (s).
    pub at_s: f64,
    /// Proven bound on the least distance over all time (m).
    pub certified: f64,
    /// What was asked (m).
    pub asked: f64,
}

/// A bound this close (m) to the truth needs no finer look: a hundredth of a tight clearance.
const FINEST: f64 = 1e-4;
/// Intervals that the period is first cut into, per harmonic.
const INTERVALS: usize = 50;

/// Least distance of every pair over one period.
pub(in super::super) fn certified_clearances(robot: &Robot, set: &SpaceSet, series: &FourierSeries) -> Vec<Clearance> {
    let speeds: Vec<f64> = (0..robot.joint_count()).map(|j| largest_velocity(series, j)).collect();
    let of = |pair: &Pair| {
        let mut search = Search {
            robot,
            pair,
            series,
            lipschitz: lipschitz(robot, pair, &speeds, series),
            asked: set.clearance,
            least: f64::INFINITY,
            at_s: 0.0,
            frames: Vec::new(),
        };
        let cuts = INTERVALS * series.order();
        let half = 0.5 * series.duration() / cuts as f64;
        let certified = (0..cuts)
            .map(|i| search.bound((2 * i + 1) as f64 * half, half))
            .fold(f64::INFINITY, f64::min);
        Clearance {
            joint: pair.link,
            from: pair.name.clone(),
            least: search.least,
            at_s: search.at_s,
            certified,
            asked: set.clearance,
        }
    };
    set.pairs.iter().map(of).collect()
}

struct Search<'a> {
    robot: &'a Robot,
    pair: &'a Pair,
    series: &'a FourierSeries,
    /// (m/s)
    lipschitz: f64,
    asked: f64,
    least: f64,
    at_s: f64,
    frames: Vec<crate::spatial::Transform>,
}

impl Search<'_> {
    /// Lower bound on the distance within `half` of `middle` (s).
    fn bound(&mut self, middle: f64, half: f64) -> f64 {
        let mut frames = std::mem::take(&mut self.frames);
        poses(self.robot, &|j| self.series.state(j, middle)[0], &mut frames);
        let distance = self.pair.distance(&frames).value;
        self.frames = frames;
        if distance < self.least {
            (self.least, self.at_s) = (distance, middle);
        }
        let slack = self.lipschitz * half;
        // Good enough: far away, hopeless, or known closely.
        if distance - slack >= self.asked || distance < self.asked || slack < FINEST {
            return distance - slack;
        }
        let quarter = 0.5 * half;
        self.bound(middle - quarter, quarter)
            .min(self.bound(middle + quarter, quarter))
    }
}

/// `max |qd_j|` over all time: the largest of N samples over `cos(π L / N)`.
fn largest_velocity(series: &FourierSeries, joint: usize) -> f64 {
    let points = 20 * series.order();
    let at = |k: usize| series.state(joint, k as f64 * series.duration() / points as f64)[1].abs();
    (0..points).map(at).fold(0.0, f64::max) / (PI * series.order() as f64 / points as f64).cos()
}

/// `Σ_k max|qd_k| reach_k` over the joints that move one body against the other.
fn lipschitz(robot: &Robot, pair: &Pair, speeds: &[f64], series: &FourierSeries) -> f64 {
    let (first, last) = match &pair.against {
        // What both ride on does not change their distance.
        Against::Link { link, .. } => (link.min(&pair.link) + 1, *link.max(&pair.link)),
        _ => (0, pair.link),
    };
    let moved = match &pair.against {
        Against::Link { link, capsule } if *link > pair.link => capsule,
        _ => &pair.capsule,
    };
    let body = moved.ends.iter().map(|p| p.norm()).fold(0.0, f64::max) + moved.radius;
    (first..=last)
        .map(|k| {
            if !robot.joints()[k].is_revolute() {
                return speeds[k];
            }
            let stretched: f64 = (k + 1..=last).map(|m| link_length(robot, m, series)).sum();
            speeds[k] * (stretched + body)
        })
        .sum()
}

/// Farthest that frame m can be from frame m − 1 (m).
fn link_length(robot: &Robot, m: usize, series: &FourierSeries) -> f64 {
    let joint = &robot.joints()[m];
    let fixed = joint.placement.translation.norm();
    if joint.is_revolute() {
        return fixed;
    }
    let amplitude = |l: usize| series.amplitude(m, l) / (series.angular_frequency() * l as f64);
    fixed + series.offset[m].abs() + (1..=series.order()).map(amplitude).sum::<f64>()
}
