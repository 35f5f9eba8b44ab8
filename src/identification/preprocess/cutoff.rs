//! How far up the positions of a log are signal.

use super::spectrum::{forward, median, smoothed};
use crate::identification::Log;

/// A hundred times the noise power: differences taken up to there carry one per cent of noise in power.
const ABOVE_NOISE: f64 = 100.0;
/// The rigid model ends where joints and links begin to swing: first resonances of industrial arms lie between 5 and 30 Hz.
pub(super) const RIGID_LIMIT_HZ: f64 = 20.0;

/// Cut-off of the row filter over the highest frequency of the signal.
pub(super) const ABOVE_SIGNAL: f64 = 1.5;

/// Cut-off [Hz] for a log that does not repeat: one and a half times the highest frequency at which some joint's position stands
/// 20 dB above its own noise floor, so that the filter's roll-off stays clear of it; at most [`RIGID_LIMIT_HZ`] and a fifth of the rate.
pub(super) fn signal_cutoff(log: &Log) -> f64 {
    let highest = log.q.iter().map(|q| highest_signal(q, log.rate_hz)).fold(0.0, f64::max);
    let slowest = 5.0 / log.duration_s();
    (ABOVE_SIGNAL * highest)
        .clamp(slowest, RIGID_LIMIT_HZ.max(slowest))
        .min(0.2 * log.rate_hz)
}

fn highest_signal(q: &[f64], rate_hz: f64) -> f64 {
    let n = q.len();
    let slope = (q[n - 1] - q[0]) / (n - 1) as f64;
    // Without ends of different height, and faded in and out: else the jump from end to start fills all lines.
    let windowed: Vec<f64> = q
        .iter()
        .enumerate()
        .map(|(i, v)| (v - q[0] - slope * i as f64) * 0.5 * (1.0 - (std::f64::consts::TAU * i as f64 / n as f64).cos()))
        .collect();
    let power: Vec<f64> = smoothed(&forward(&windowed).iter().map(|x| x.norm_sqr()).collect::<Vec<_>>(), 2);
    let floor = median(power[power.len() / 2..].to_vec()) / std::f64::consts::LN_2;
    let line = (0..power.len()).rev().find(|&l| power[l] > ABOVE_NOISE * floor).unwrap_or(0);
    line as f64 * rate_hz / n as f64
}
