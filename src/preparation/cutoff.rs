//! How far up the positions of a log are signal.

use super::log::Log;
use super::spectrum::{forward, median, smoothed};
use crate::cancel::CancelFlag;

/// A hundred times the noise power: differences taken up to there carry one per cent of noise in power.
const ABOVE_NOISE: f64 = 100.0;

/// The rigid model ends where joints and links begin to swing: first resonances of industrial arms lie between 5 and 30 Hz.
pub(crate) const RIGID_LIMIT_HZ: f64 = 20.0;

/// Cut-off of the row filter over the highest frequency of the signal.
pub(crate) const ABOVE_SIGNAL: f64 = 1.5;

/// Ten times the frequency below which 99 % of a velocity's power lies: friction reverses in steps, whose harmonics say more of
/// it than the motion's own lines. A filter at the highest line of a slow, clean motion would leave a few dozen rows of a log.
const ABOVE_SPEED: f64 = 10.0;

/// No row filter is lower [Hz]: joints of arms reverse within a second.
const LEAST_HZ: f64 = 2.0;

/// Cut-off (Hz) for a log that does not repeat: one and a half times the highest frequency at which some joint's position stands
/// 20 dB above its own noise floor, so that the filter's roll-off stays clear of it, but no less than ten times that of the
/// speeds (the joint in the middle), which does not go with the number of digits; at most 20 Hz and a fifth of the rate.
pub fn signal_cutoff(log: &Log, cancel: &CancelFlag) -> f64 {
    let of = |q: &Vec<f64>| {
        cancel.leave_if_set();
        Lines::from_positions(q, log.rate_hz)
    };
    let lines: Vec<Lines> = log.q.iter().map(of).collect();
    let highest = lines.iter().map(Lines::highest).fold(0.0, f64::max);
    let speed = median(lines.iter().map(Lines::of_speed).collect());
    let slowest = 5.0 / log.duration_s();
    (ABOVE_SIGNAL * highest)
        .max(ABOVE_SPEED * speed)
        .max(LEAST_HZ)
        .clamp(slowest, RIGID_LIMIT_HZ.max(slowest))
        .min(0.2 * log.rate_hz)
}

/// Power of a position, line by line, and its noise floor.
struct Lines {
    power: Vec<f64>,
    floor: f64,
    /// From one line to the next [Hz].
    step_hz: f64,
}

impl Lines {
    fn from_positions(q: &[f64], rate_hz: f64) -> Self {
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
        Self {
            power,
            floor,
            step_hz: rate_hz / n as f64,
        }
    }

    fn highest(&self) -> f64 {
        let signal = |&l: &usize| self.power[l] > ABOVE_NOISE * self.floor;
        (0..self.power.len()).rev().find(signal).unwrap_or(0) as f64 * self.step_hz
    }

    /// Frequency below which 99 % of the speed's power lies, of lines that stand 10 dB above the noise.
    fn of_speed(&self) -> f64 {
        let of = |(l, &p): (usize, &f64)| {
            let signal = if p > 10.0 * self.floor { p - self.floor } else { 0.0 };
            signal * (l as f64).powi(2)
        };
        let speed: Vec<f64> = self.power.iter().enumerate().map(of).collect();
        let mut missing = 0.01 * speed.iter().sum::<f64>();
        let line = (0..speed.len()).rev().find(|&l| {
            missing -= speed[l];
            missing < 0.0
        });
        line.unwrap_or(0) as f64 * self.step_hz
    }
}
