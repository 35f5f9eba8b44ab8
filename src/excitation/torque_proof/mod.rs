//! Proof that torques stay within limits at all times, between samples too.
//!
//! Between two moments Δ apart a function differs from its chord by at most `sup|f''| Δ²/8`. The second derivative of every
//! joint's torque is bounded by the recursion of Newton and Euler carried out on bounds: a quantity is a list of bounds on the
//! norms of its first few derivatives in time, products follow Leibniz, and a vector fixed in a link has `ṙ = ω × r`. Intervals
//! whose bound matters are halved until it does not.

mod bounds;

use self::bounds::{second_derivatives, speed_bounds};
use super::problem::Problem;
use crate::dynamics::{Coulomb, Motion, inverse_dynamics_batch};
use crate::parameters::ParameterKind;
use crate::trajectory::{FourierSeries, Trajectory};

/// Samples per harmonic that a proof begins with.
const SAMPLES: usize = 1000;
/// What a certified peak may lie above the largest sample, as part of what is allowed; a tenth of the 0.1 % that a proof may
/// cost.
const FINE: f64 = 1e-4;
/// Intervals are halved at most so often: a two-thousandth of a millisecond in a period of 10 s at order 5.
const HALVINGS: usize = 12;

/// Extremes of one joint's torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TorqueExtremes {
    /// Lowest and highest torque seen [N·m or N], and when (s).
    pub lowest: (f64, f64),
    pub highest: (f64, f64),
    /// Proven bounds over all time.
    pub certified: [f64; 2],
    pub allowed: f64,
}

/// One side of one joint's torque, looked at as a maximum.
struct Side<'a> {
    proof: &'a Proof<'a>,
    joint: usize,
    sign: f64,
    /// Bounds up to here need no finer look.
    enough: f64,
    best: (f64, f64),
}

/// A state of the arm at a moment: smooth part of all torques, and velocities.
#[derive(Clone)]
struct Moment {
    t: f64,
    torque: Vec<f64>,
    speed: Vec<f64>,
}

struct Proof<'a> {
    problem: &'a Problem,
    series: &'a FourierSeries,
    smooth: Vec<f64>,
    coulomb: Vec<f64>,
    curvature: Vec<f64>,
    /// `sup |qdd|`
    acceleration: Vec<f64>,
    grid: Vec<Moment>,
}

impl<'a> Proof<'a> {
    /// `None` without torque limits.
    fn new(problem: &'a Problem, series: &'a FourierSeries) -> Option<Self> {
        problem.torque()?;
        let (robot, layout) = (problem.robot(), problem.layout());
        let mut smooth = layout.prior(robot)?.as_slice().to_vec();
        let mut coulomb = vec![0.0; robot.joint_count()];
        for (at, parameter) in layout.parameters().iter().enumerate() {
            if parameter.kind == ParameterKind::Coulomb {
                coulomb[parameter.link] = std::mem::take(&mut smooth[at]);
            }
        }
        let mut proof = Self {
            problem,
            series,
            curvature: second_derivatives(robot, layout, &smooth, series),
            acceleration: (0..robot.joint_count()).map(|j| speed_bounds(series, j)[1]).collect(),
            smooth,
            coulomb,
            grid: Vec::new(),
        };
        let count = SAMPLES * series.order();
        let times: Vec<f64> = (0..=count).map(|k| k as f64 * series.duration() / count as f64).collect();
        proof.grid = proof.moments(&times);
        Some(proof)
    }

    fn moments(&self, times: &[f64]) -> Vec<Moment> {
        let n = self.series.joints();
        let motion = Motion::from_fn(n, times.len(), |j, s| self.series.state(j, times[s]));
        let (chain, layout) = (self.problem.chain(), self.problem.layout());
        let torque = inverse_dynamics_batch(chain, layout, &self.smooth, &motion, Coulomb::Sign);
        let of = |(s, &t): (usize, &f64)| Moment {
            t,
            torque: (0..n).map(|j| torque[j * motion.stride() + s]).collect(),
            speed: (0..n).map(|j| motion.velocities(j)[s]).collect(),
        };
        times.iter().enumerate().map(of).collect()
    }
}

impl Side<'_> {
    fn value(&self, at: &Moment) -> f64 {
        let friction = self.proof.coulomb[self.joint] * Coulomb::Sign.value(at.speed[self.joint]);
        self.sign * (at.torque[self.joint] + friction)
    }

    fn see(&mut self, at: &Moment) {
        let value = self.value(at);
        if value > self.best.0 {
            self.best = (value, at.t);
        }
    }

    /// Bound over the interval: chord, curvature, and whatever sign the velocity may have in between.
    fn bound(&self, from: &Moment, to: &Moment) -> f64 {
        let (j, length) = (self.joint, to.t - from.t);
        let chord = (self.sign * from.torque[j]).max(self.sign * to.torque[j]);
        let slack = 0.5 * length * self.proof.acceleration[j];
        let fastest = from.speed[j].max(to.speed[j]) + slack;
        let slowest = from.speed[j].min(to.speed[j]) - slack;
        let friction = self.sign * self.proof.coulomb[j];
        let of_friction = if slowest > 0.0 {
            friction
        } else if fastest < 0.0 {
            -friction
        } else {
            friction.abs()
        };
        chord + of_friction + 0.125 * self.proof.curvature[j] * length * length
    }

    /// The bound over the interval after as many halvings as matter.
    fn refined(&mut self, from: &Moment, to: &Moment, halvings: usize) -> f64 {
        let bound = self.bound(from, to);
        if bound <= self.enough.max(self.best.0) || halvings == 0 {
            return bound;
        }
        let middle = self.proof.moments(&[0.5 * (from.t + to.t)]).remove(0);
        self.see(&middle);
        self.refined(from, &middle, halvings - 1)
            .max(self.refined(&middle, to, halvings - 1))
    }
}

/// Extremes of every joint's torque along a series, proven; empty without torque limits.
pub(super) fn certified_torques(problem: &Problem, series: &FourierSeries) -> Vec<TorqueExtremes> {
    let Some(proof) = Proof::new(problem, series) else {
        return Vec::new();
    };
    let allowed = &problem.torque().expect("there is a proof").allowed;
    let of = |joint: usize| {
        let side = |sign: f64| {
            let mut side = Side {
                proof: &proof,
                joint,
                sign,
                enough: f64::NEG_INFINITY,
                best: (f64::NEG_INFINITY, 0.0),
            };
            proof.grid.iter().for_each(|m| side.see(m));
            let fine = if allowed[joint].is_finite() {
                FINE * allowed[joint]
            } else {
                f64::INFINITY
            };
            // Where less than that is left, the proof goes on until the limit itself holds, as it did for the design.
            side.enough = (side.best.0 + fine).min(allowed[joint].max(side.best.0));
            let pairs = proof.grid.windows(2);
            let certified = pairs.fold(f64::NEG_INFINITY, |most, p| most.max(side.refined(&p[0], &p[1], HALVINGS)));
            (sign * side.best.0, side.best.1, sign * certified.max(side.best.0))
        };
        let (low, high) = (side(-1.0), side(1.0));
        TorqueExtremes {
            lowest: (low.0, low.1),
            highest: (high.0, high.1),
            certified: [low.2, high.2],
            allowed: allowed[joint],
        }
    };
    (0..problem.robot().joint_count()).map(of).collect()
}

/// Whether all torques provably stay within what is allowed, `room` of it left; true without torque limits.
pub(super) fn torques_hold(problem: &Problem, series: &FourierSeries, room: f64) -> bool {
    let Some(proof) = Proof::new(problem, series) else {
        return true;
    };
    let allowed = &problem.torque().expect("there is a proof").allowed;
    let holds = |joint: usize, sign: f64| {
        let mut side = Side {
            proof: &proof,
            joint,
            sign,
            enough: allowed[joint] * (1.0 - room),
            best: (f64::NEG_INFINITY, 0.0),
        };
        let seen = proof.grid.iter().map(|m| side.value(m)).fold(f64::NEG_INFINITY, f64::max);
        let enough = side.enough;
        seen <= enough && proof.grid.windows(2).all(|p| side.refined(&p[0], &p[1], HALVINGS) <= enough)
    };
    (0..allowed.len())
        .filter(|&j| allowed[j].is_finite())
        .all(|j| holds(j, 1.0) && holds(j, -1.0))
}
