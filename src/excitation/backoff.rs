//! A smaller or slower version of a trajectory for a first run, with every limit looked at again.
//!
//! Limits on one joint's motion are convex around where it starts, and hold for every smaller amplitude. Torques and distances
//! need not: an arm that passes over an obstacle at full amplitude may meet it at half. Where a limit does not hold, the motion
//! is drawn in further.

use super::margins::margins;
use super::problem::Problem;
use super::space::certified_clearances;
use crate::trajectory::{FourierSeries, Trajectory};

/// How a first run differs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Backoff {
    /// Factor on the amplitudes around where the motion starts, in (0, 1].
    pub amplitude: f64,
    /// Factor on the time it takes, at least 1.
    pub slowness: f64,
}

/// The trajectory with the factor on the amplitudes that all limits allow: the one asked for, or the largest found below it.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstRun {
    /// Factor of the amplitudes, from 0 to 1.
    pub amplitude: f64,
    /// Factor of the period, from 1.
    pub slowness: f64,
    /// The trajectory that is left.
    pub series: FourierSeries,
}

/// By how much the motion is drawn in where a limit does not hold.
const DRAWN_IN: f64 = 0.9;
/// At a hundredth of the motion nothing is learnt any more.
const LEAST: f64 = 0.01;

/// A smaller, slower `series` within all limits of the problem; `None` where what was asked for is not, nor any part of it down
/// to a hundredth.
pub fn first_run(problem: &Problem, series: &FourierSeries, asked: Backoff) -> Option<FirstRun> {
    let mut amplitude = asked.amplitude;
    loop {
        let smaller = scaled(series, amplitude, asked.slowness);
        if holds(problem, &smaller) {
            return Some(FirstRun {
                amplitude,
                slowness: asked.slowness,
                series: smaller,
            });
        }
        amplitude *= DRAWN_IN;
        if amplitude < LEAST {
            return None;
        }
    }
}

/// `q(t) = q_0 + amplitude (q_full(t/slowness) − q_0)`, q_0 where the motion starts.
pub(super) fn scaled(series: &FourierSeries, amplitude: f64, slowness: f64) -> FourierSeries {
    let rate = amplitude / slowness;
    let offset = |j: usize| {
        let start = series.state(j, 0.0)[0];
        start + amplitude * (series.offset[j] - start)
    };
    FourierSeries {
        fundamental_hz: series.fundamental_hz / slowness,
        a: &series.a * rate,
        b: &series.b * rate,
        offset: (0..series.joints()).map(offset).collect(),
    }
}

/// Whether every limit provably holds.
pub(super) fn holds(problem: &Problem, series: &FourierSeries) -> bool {
    let near = problem
        .space()
        .map_or(Vec::new(), |set| certified_clearances(problem.robot(), set, series));
    margins(problem, series).iter().all(|m| m.margin >= 0.0) && near.iter().all(|c| c.certified >= c.asked)
}
