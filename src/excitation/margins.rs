//! How far a trajectory stays from every limit, between the samples too.

use super::problem::{Form, Problem};
use super::torque_proof::{TorqueExtremes, certified_torques};
use crate::trajectory::{FourierSeries, Trajectory};
use std::f64::consts::{PI, TAU};

/// What a limit is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Position [rad or m].
    Position,
    /// Velocity [rad/s or m/s].
    Velocity,
    /// Acceleration [rad/s² or m/s²].
    Acceleration,
    /// Jerk [rad/s³ or m/s³].
    Jerk,
    /// Predicted by the prior link parameters; its limit is over the safety factor.
    Torque,
}

impl Quantity {
    /// Those of one joint's motion.
    pub const MOTION: [Quantity; 4] = [Quantity::Position, Quantity::Velocity, Quantity::Acceleration, Quantity::Jerk];

    /// Name in documents.
    pub fn name(self) -> &'static str {
        ["position", "velocity", "acceleration", "jerk", "torque"][self as usize]
    }
}

/// One side of one limit of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Margin {
    /// From 0.
    pub joint: usize,
    /// What the limit is of.
    pub quantity: Quantity,
    /// The limit: lower limits and those on negative velocities are below `peak`.
    pub limit: f64,
    /// Extreme value reached, at `at_s`.
    pub peak: f64,
    /// Proven bound on the extreme over all time: of motions `middle ± half range / cos(π L / N)` of N equispaced values, of
    /// torques by bounds on their second derivative.
    pub certified_peak: f64,
    /// Time of the extreme (s).
    pub at_s: f64,
    /// `1 −` (how much of the way from the middle of the allowed range to the limit the certified peak takes); never negative.
    pub margin: f64,
    /// Left side over right side of the triangle-inequality bound (14d), (14e); only with the paper's constraints.
    pub bound_used: Option<f64>,
}

/// Margins of every stated limit, both sides.
pub fn margins(problem: &Problem, series: &FourierSeries) -> Vec<Margin> {
    let mut all = Vec::new();
    for (joint, limits) in problem.robot().joints().iter().map(|j| j.limits).enumerate() {
        let symmetric = |v: Option<f64>| v.map(|v| [-v, v]);
        let ranges = [
            limits.position,
            symmetric(limits.velocity),
            symmetric(limits.acceleration),
            symmetric(limits.jerk),
        ];
        for (quantity, range) in Quantity::MOTION.into_iter().zip(ranges) {
            let Some(range) = range else { continue };
            let bound = (problem.spec().form == Form::Paper).then(|| triangle_bound(problem, series, joint, quantity, range));
            all.extend(both_sides(series, joint, quantity, range, bound));
        }
    }
    all.extend(torque_margins(problem, series));
    all
}

fn torque_margins(problem: &Problem, series: &FourierSeries) -> Vec<Margin> {
    let of = |(joint, extremes): (usize, TorqueExtremes)| {
        let side = |sign: f64, (peak, at_s): (f64, f64), certified_peak: f64| {
            let limit = sign * extremes.allowed;
            Margin {
                joint,
                quantity: Quantity::Torque,
                limit,
                peak,
                certified_peak,
                at_s,
                margin: 1.0 - certified_peak / limit,
                bound_used: None,
            }
        };
        let [low, high] = extremes.certified;
        [side(-1.0, extremes.lowest, low), side(1.0, extremes.highest, high)]
    };
    let all = certified_torques(problem, series).into_iter().enumerate();
    all.filter(|(_, e)| e.allowed.is_finite()).flat_map(of).collect()
}

/// Value of the derivative that `quantity` stands for.
fn value(series: &FourierSeries, joint: usize, quantity: Quantity, t: f64) -> f64 {
    match quantity {
        Quantity::Jerk => {
            let frequency = |l: usize| series.angular_frequency() * l as f64;
            (1..=series.order())
                .map(|l| {
                    let (w, (s, c)) = (frequency(l), (frequency(l) * t).sin_cos());
                    -w * w * (series.a[(joint, l - 1)] * c + series.b[(joint, l - 1)] * s)
                })
                .sum()
        }
        other => series.state(joint, t)[other as usize],
    }
}

fn both_sides(
    series: &FourierSeries,
    joint: usize,
    quantity: Quantity,
    [low, high]: [f64; 2],
    bound_used: Option<f64>,
) -> [Margin; 2] {
    let order = series.order();
    // 1/cos(πL/N) − 1 < 1e-5: a tenth of a permille of the 0.1 % that a proof may cost.
    let points = 710 * order;
    let time = |k: usize| k as f64 * series.duration() / points as f64;
    let mut extremes = [(f64::INFINITY, 0.0), (f64::NEG_INFINITY, 0.0)];
    for k in 0..points {
        let v = value(series, joint, quantity, time(k));
        if v < extremes[0].0 {
            extremes[0] = (v, time(k));
        }
        if v > extremes[1].0 {
            extremes[1] = (v, time(k));
        }
    }
    let middle = 0.5 * (extremes[0].0 + extremes[1].0);
    let half = 0.5 * (extremes[1].0 - extremes[0].0) / (PI * order as f64 / points as f64).cos();
    let center = 0.5 * (low + high);
    let side = |limit: f64, (peak, at_s): (f64, f64), certified_peak: f64| Margin {
        joint,
        quantity,
        limit,
        peak,
        certified_peak,
        at_s,
        margin: 1.0 - (certified_peak - center) / (limit - center),
        bound_used,
    };
    [side(low, extremes[0], middle - half), side(high, extremes[1], middle + half)]
}

/// `(|offset − rest| + Σ w_l sqrt(a_l² + b_l²)) / limit`, w = 1/(ω l), 1, ω l, (ω l)².
fn triangle_bound(problem: &Problem, series: &FourierSeries, joint: usize, quantity: Quantity, [low, high]: [f64; 2]) -> f64 {
    let power = quantity as i32 - 1;
    let sum: f64 = (1..=series.order())
        .map(|l| (TAU * series.fundamental_hz * l as f64).powi(power) * series.amplitude(joint, l))
        .sum();
    match quantity {
        Quantity::Position => {
            let rest = problem.rest_position(joint);
            (sum + (series.offset[joint] - rest).abs()) / (rest - low).min(high - rest)
        }
        _ => sum / high,
    }
}
