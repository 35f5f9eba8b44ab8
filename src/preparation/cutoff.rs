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

/// Cut-off of the filter of positions over the highest frequency of the signal: there a filter of [`POSITION_ORDER`] takes
/// 2^-16 off.
const ABOVE_POSITIONS: f64 = 2.0;

/// Order of the filter of positions.
pub(crate) const POSITION_ORDER: usize = 8;

/// What may be left of the padding in positions: it continues values and slopes, so that only curvature is wrong, and that by a
/// hundredth.
pub(crate) const POSITION_SETTLED: f64 = 0.01;

/// Cycles of its cut-off in which the slowest mode of that filter decays to [`POSITION_SETTLED`]: `ln 100 / (2π sin(π/16))`, 16
/// twice the order.
const POSITION_SETTLING_CYCLES: f64 = 3.76;

/// Share of a record that may be lost at either end to what the filter of positions remembers of the padding: a lower cut-off
/// takes noise off what is left, and leaves less of it.
const EDGES: f64 = 0.1;

/// Ten times the frequency below which 99 % of a velocity's power lies: friction reverses in steps, whose harmonics say more of
/// it than the motion's own lines. A filter at the highest line of a slow, clean motion would leave a few dozen rows of a log.
const ABOVE_SPEED: f64 = 10.0;

/// No row filter is lower [Hz]: joints of arms reverse within a second.
const LEAST_HZ: f64 = 2.0;

/// A low-pass before recording is looked for from here on [Hz]: below, controllers and stick-slip move the arm itself.
const LEAST_PLATEAU_HZ: f64 = 4.0;

/// Bands in which a plateau of noise is looked for begin a sixth of an octave apart, and are two sixths wide.
const BANDS_PER_OCTAVE: usize = 6;

/// Bands of a plateau: two thirds of an octave from the middle of the first to that of the last.
const PLATEAU: usize = 5;

/// Lines of the narrowest band: its level is known to about 1 dB then.
const LEAST_LINES: usize = 30;

/// Ratio of the levels over a plateau [2.5 dB]: a second-order low-pass, forwards and backwards, is flat to that up to 0.8 of its
/// cut-off.
const LEVEL: f64 = 1.8;

/// Fall over the octave behind a plateau [10 dB]: that of such a low-pass from 0.62 of its cut-off on, so that one of the bands
/// shows both. Quantised and integrated noise, which measured positions have without any filter, falls by 3 to 8 dB.
const KNEE: f64 = 10.0;

/// Largest standard deviation of what can be noise of positions [rad or m]: encoders of arms have a hundredth of it. A plateau
/// that holds more is a motion, such as a sweep.
const LARGEST_NOISE: f64 = 3e-3;

/// Cut-off (Hz) for a log that does not repeat: one and a half times the highest frequency at which some joint's position stands
/// 20 dB above its own noise floor, so that the filter's roll-off stays clear of it, but no less than ten times that of the
/// speeds (the joint in the middle), which does not go with the number of digits; at most 20 Hz and a fifth of the rate.
pub fn signal_cutoff(log: &Log, cancel: &CancelFlag) -> f64 {
    cutoff_of(&lines_of(log, cancel), log)
}

fn cutoff_of(lines: &[Lines], log: &Log) -> f64 {
    let highest = lines.iter().map(Lines::highest).fold(0.0, f64::max);
    let speed = median(lines.iter().map(Lines::of_speed).collect());
    let slowest = 5.0 / log.duration_s();
    (ABOVE_SIGNAL * highest)
        .max(ABOVE_SPEED * speed)
        .max(LEAST_HZ)
        .clamp(slowest, RIGID_LIMIT_HZ.max(slowest))
        .min(0.2 * log.rate_hz)
}

/// Cut-off (Hz) of the filter of positions of a log that does not repeat: over that of its rows by as much as those leave above
/// the signal, but no higher than twice the frequency up to which the accelerations of some joint gain more signal than noise,
/// nor so low that its ends cost more than [`EDGES`] of the record.
///
/// Below a cut-off `f` accelerations keep the noise `Σ ω⁴ N`, above it they lose the signal `Σ ω⁴ (P − N)`; the sum is least
/// where the power `P` falls below twice the noise `N` for good (Wiener). Errors of accelerations shrink the inertias that are
/// fitted to them, those of speeds round the jumps of friction off.
pub(crate) fn position_cutoff(log: &Log, cancel: &CancelFlag) -> f64 {
    let lines = lines_of(log, cancel);
    let gains = lines.iter().map(Lines::last_gain).fold(0.0, f64::max);
    let settles = POSITION_SETTLING_CYCLES / (EDGES * log.duration_s());
    let beside_rows = cutoff_of(&lines, log) * (ABOVE_POSITIONS / ABOVE_SIGNAL);
    beside_rows.min((ABOVE_POSITIONS * gains).max(settles))
}

/// Spectra of all positions, with the noise that they have below a filter's edge.
fn lines_of(log: &Log, cancel: &CancelFlag) -> Vec<Lines> {
    let of = |q: &Vec<f64>| {
        cancel.leave_if_set();
        Lines::from_positions(q, log.rate_hz)
    };
    let mut lines: Vec<Lines> = log.q.iter().map(of).collect();
    raise_to_plateau(&mut lines);
    lines
}

/// Power of a position, line by line, and its noise floor.
struct Lines {
    power: Vec<f64>,
    floor: f64,
    /// From one line to the next [Hz].
    step_hz: f64,
    /// Of the record.
    samples: usize,
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
        Self {
            floor: level(&power[power.len() / 2..]),
            power,
            step_hz: rate_hz / n as f64,
            samples: n,
        }
    }

    /// Level of the bands from [`LEAST_PLATEAU_HZ`] on that are wide enough, each with its last line.
    fn bands(&self) -> Vec<(usize, f64)> {
        let edge = |k: usize| LEAST_PLATEAU_HZ * 2f64.powf(k as f64 / BANDS_PER_OCTAVE as f64);
        let line = |k: usize| (edge(k) / self.step_hz) as usize;
        (0..)
            .map(|k| line(k)..line(k + 2))
            .take_while(|band| band.end <= self.power.len())
            .filter(|band| band.len() >= LEAST_LINES)
            .map(|band| (band.end, level(&self.power[band])))
            .collect()
    }

    /// Standard deviation of white noise of this level up to a line.
    fn std_dev(&self, level: f64, last: usize) -> f64 {
        // White noise of variance s² has lines of s² Σw², and the mean square of Hann's window is 3/8.
        (2.0 * level * last as f64 / 0.375).sqrt() / self.samples as f64
    }

    /// Highest frequency at which the signal stands 20 dB above the noise.
    fn highest(&self) -> f64 {
        let signal = |&l: &usize| self.power[l] > ABOVE_NOISE * self.floor;
        (0..self.power.len()).rev().find(signal).unwrap_or(0) as f64 * self.step_hz
    }

    /// Frequency up to which the accelerations gain more signal than noise.
    fn last_gain(&self) -> f64 {
        let (mut sum, mut least) = (0.0, (0.0, 0));
        for (l, p) in self.power.iter().enumerate() {
            sum += (l as f64).powi(4) * (2.0 * self.floor - p);
            if sum < least.0 {
                least = (sum, l);
            }
        }
        least.1 as f64 * self.step_hz
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

/// Takes the lowest plateau that ends in a knee for the noise of all positions: noise that went through a low-pass before it was
/// recorded stands far below at the upper end of the spectrum, and is white where the signal ends. One filter is that of all
/// channels, so that their mean decides, which scatters less than each.
fn raise_to_plateau(lines: &mut [Lines]) {
    let bands: Vec<Vec<(usize, f64)>> = lines.iter().map(Lines::bands).collect();
    let count = bands.iter().map(Vec::len).min().unwrap_or(0);
    let mean = |k: usize| bands.iter().map(|b| b[k].1.max(f64::MIN_POSITIVE).ln()).sum::<f64>() / bands.len() as f64;
    let levels: Vec<f64> = (0..count).map(mean).collect();
    let ends_in_a_knee = |octaves: &[f64]| {
        let (flat, behind) = octaves.split_at(PLATEAU);
        let (low, high) = (
            flat.iter().copied().fold(f64::INFINITY, f64::min),
            flat.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        );
        high - low <= LEVEL.ln() && flat[PLATEAU - 1] - behind[BANDS_PER_OCTAVE - 1] >= KNEE.ln()
    };
    let Some(from) = levels.windows(PLATEAU + BANDS_PER_OCTAVE).position(ends_in_a_knee) else {
        return;
    };
    for (lines, bands) in lines.iter_mut().zip(&bands) {
        let plateau = &bands[from..from + PLATEAU];
        let level = plateau.iter().map(|band| band.1).sum::<f64>() / PLATEAU as f64;
        if lines.std_dev(level, plateau[PLATEAU - 1].0) <= LARGEST_NOISE {
            lines.floor = lines.floor.max(level);
        }
    }
}

/// Mean power of lines, by their median, which single lines of a signal do not raise.
fn level(power: &[f64]) -> f64 {
    median(power.to_vec()) / std::f64::consts::LN_2
}
