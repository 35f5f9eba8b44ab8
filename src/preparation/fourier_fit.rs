//! Derivatives of one period by its own Fourier series, cut where the positions stop being signal.

use super::motion_error::MotionError;
use super::spectrum::{forward, inverse, median, smoothed};
use realfft::num_complex::Complex64;
use std::f64::consts::TAU;

/// One joint's position, velocity and acceleration over a period.
pub(crate) struct FourierFit {
    pub q: Vec<f64>,
    pub qd: Vec<f64>,
    pub qdd: Vec<f64>,
    /// Harmonics kept.
    pub kept: usize,
    /// Highest harmonic kept.
    pub highest: usize,
    /// What the noise leaves in position, velocity and acceleration.
    pub error: MotionError,
}

/// Noise of the mean of periods, by their scatter about it.
pub(crate) struct PositionNoise {
    /// Of a sample about the truth [rad² or m²].
    pub variance: f64,
    /// What every Fourier line 0 … N/2 has of it, `E|X_l|²/N`.
    pub spectrum: Vec<f64>,
}

/// Half the width, in lines, over which a line is judged together with its neighbours.
const NEIGHBOURS: usize = 2;

/// A line of pure noise has a power beyond 13.8 times its expectation once in a million. Its neighbours do not make that rarer:
/// noise that comes and goes with the motion (time stamps that jitter move positions by speed times jitter) has lines that go
/// together, and one false line near half the sampling rate, differentiated twice, is an acceleration of its own.
const ABOVE_NOISE: f64 = 13.8;

/// A spectrum whose last line that stands out is within 30 dB of the noise has faded into it; one that a trajectory ends by
/// itself stops far above.
const FADING: f64 = 1e3;

/// Fits the period `q` of `period_s` seconds. `scatter` is the noise of `q`, where periods show it; `order` the excitation's
/// highest harmonic, where known: those harmonics are kept in any case.
///
/// A line is kept when it and its neighbours together stand above the noise. With `q = Σ_l c_l exp(iωlt)` the derivatives are
/// exact: `iωl c_l` and `−(ωl)² c_l`, and the noise in them is what the kept lines carry and no more.
///
/// Motions with steps in their jerk (polynomials through way-points) have no last harmonic: theirs fall as `l⁻⁴` and sink into
/// the noise. There the lines beyond the last that stands out are weighted by `S/(S + N)`, Wiener's filter, with S falling on as
/// it must: cutting them would cut the corners of the acceleration.
pub(crate) fn fourier_fit(q: &[f64], period_s: f64, scatter: Option<&PositionNoise>, order: Option<usize>) -> FourierFit {
    let n = q.len();
    let lines = forward(q);
    let power: Vec<f64> = lines.iter().map(|x| x.norm_sqr()).collect();
    // The upper half of the band holds noise alone, or less; an exponential variable's median is ln 2 of its mean.
    let floor = median(power[power.len() / 2..].to_vec()) / std::f64::consts::LN_2;
    // Transforms round to a few units in the last place of the largest value.
    let rounding = 8.0 * f64::EPSILON * q.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let noise = floor
        .max(scatter.map_or(0.0, |s| s.variance) * n as f64)
        .max(rounding * rounding * n as f64);
    // The mean (line 0) would lend its power to the first harmonics' judgement; their own power decides.
    let mut judged = power.clone();
    judged[0] = 0.0;
    let joined = smoothed(&judged, NEIGHBOURS);
    let keep = |l: usize| l == 0 || order.is_some_and(|o| l <= o) || joined[l] > ABOVE_NOISE * noise;
    // The last line of an even count has no derivative of its own.
    let last = (n - 1) / 2;
    let top = (1..=last).rev().find(|&l| keep(l)).unwrap_or(0);
    let above = joined[top] / noise;
    let gain = |l: usize| {
        if keep(l) {
            1.0
        } else if l > top && above < FADING && top > 0 {
            let signal = (above - 1.0).max(0.0) * (top as f64 / l as f64).powi(8);
            signal / (signal + 1.0)
        } else {
            0.0
        }
    };
    let omega = TAU / period_s;
    let series = |derivative: i32| {
        let factor = |l: usize| (Complex64::i() * omega * l as f64).powi(derivative);
        let kept = lines
            .iter()
            .enumerate()
            .map(|(l, &x)| if l <= last { x * factor(l) * gain(l) } else { Complex64::ZERO });
        inverse(kept.collect(), n)
    };
    let kept: Vec<usize> = (1..=last).filter(|&l| keep(l)).collect();
    // Periods of a real arm also differ in their motion, slowly: the line's own scatter counts, not its share of the whole.
    let noise_of = |l: usize| {
        scatter.map_or(noise, |s| {
            (s.spectrum[l] * n as f64).max(floor).max(rounding * rounding * n as f64)
        })
    };
    let error = motion_error(n, omega, |l| gain(l).powi(2) * noise_of(l), |l| gain(l).powi(2) * power[l]);
    FourierFit {
        q: series(0),
        qd: series(1),
        qdd: series(2),
        kept: kept.len(),
        highest: kept.last().copied().unwrap_or(0),
        error,
    }
}

/// Errors of a record of `n` samples whose lines `l ω` have the power `noise` of errors and `signal` of motion.
fn motion_error(n: usize, omega: f64, noise: impl Fn(usize) -> f64, signal: impl Fn(usize) -> f64) -> MotionError {
    let lines = 1..=(n - 1) / 2;
    let raised = |l: usize, derivative: i32| (omega * l as f64).powi(2 * derivative);
    let acceleration: f64 = lines.clone().map(|l| raised(l, 2) * signal(l)).sum();
    let of = |derivative: i32| {
        let errors = |l: usize| raised(l, derivative) * noise(l);
        let whole: f64 = lines.clone().map(errors).sum();
        let met: f64 = lines.clone().map(|l| raised(l, 2) * signal(l) * errors(l)).sum();
        let density = met / acceleration / (whole / (n as f64 / 2.0));
        (
            (2.0 * whole).sqrt() / n as f64,
            if density.is_finite() { density } else { 1.0 },
        )
    };
    let [position, velocity, acceleration] = [of(0), of(1), of(2)];
    MotionError {
        std_dev: [position.0, velocity.0, acceleration.0],
        density: [position.1, velocity.1, acceleration.1],
    }
}
