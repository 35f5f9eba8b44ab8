//! Low-passes that torques have been through before they were recorded.

use crate::preparation::filter::LowPass;
use crate::preparation::spectrum::{forward_of, inverse};
use realfft::num_complex::Complex64;
use std::f64::consts::TAU;

/// Whether a filter delays what goes through it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Run forwards and backwards, as in a log that was smoothed afterwards: gain `|H|²`.
    Zero,
    /// Run while the arm moved: gain `|H|`. Positions are as late as torques by what slow signals are delayed; only what the
    /// filter does beside that is left in the torques. A delay of the torques alone is an effect, and found as one.
    Causal,
}

/// A Butterworth low-pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedFilter {
    /// Number of poles.
    pub order: usize,
    /// Frequency at which half of the power is left by one run (Hz).
    pub cutoff_hz: f64,
    /// Samples per second that it ran on.
    pub rate_hz: f64,
    /// Whether it delays.
    pub phase: Phase,
}

/// Share of the power behind a filter below which it is said to have none left: rows that show more of it show noise that no
/// model of a few terms describes.
const NOTHING_LEFT: f64 = 0.01;

impl RecordedFilter {
    /// Frequency beyond which the density of what was white is less than a hundredth (Hz): `(f/f_c)^2n` is then 9 after two runs,
    /// 99 after one.
    pub fn edge_hz(&self) -> f64 {
        let ratio = match self.phase {
            Phase::Zero => NOTHING_LEFT.powf(-0.5) - 1.0,
            Phase::Causal => 1.0 / NOTHING_LEFT - 1.0,
        };
        self.cutoff_hz * ratio.powf(0.5 / self.order as f64)
    }

    /// The filter at work; `None` where the cut-off is beyond half of the rate.
    pub fn made(&self) -> Option<SampledFilter> {
        let low_pass = LowPass::butterworth(self.order, self.cutoff_hz, self.rate_hz).ok()?;
        Some(SampledFilter {
            // Slow signals are late by the slope of the phase at zero.
            delay: -response(&low_pass, 1e-4).arg() / 1e-4,
            phase: self.phase,
            low_pass,
        })
    }
}

/// A [`RecordedFilter`] at work.
#[derive(Debug, Clone)]
pub struct SampledFilter {
    low_pass: LowPass,
    phase: Phase,
    /// By which slow signals are late (samples).
    delay: f64,
}

/// `H(exp(iω))`, ω in radians per sample.
fn response(filter: &LowPass, omega: f64) -> Complex64 {
    let z = Complex64::from_polar(1.0, -omega);
    let one = Complex64::new(1.0, 0.0);
    let section = |b: [f64; 3], a: [f64; 2]| (one * b[0] + z * b[1] + z * z * b[2]) / (one + z * a[0] + z * z * a[1]);
    filter.sections.iter().map(|s| section(s.b, s.a)).product()
}

impl SampledFilter {
    /// Power density behind it of what was white before, at `frequency_hz`.
    pub fn density(&self, frequency_hz: f64) -> f64 {
        let power = self.low_pass.power(frequency_hz);
        match self.phase {
            Phase::Zero => power * power,
            Phase::Causal => power,
        }
    }

    /// Factor of a wave at `frequency_hz`, without the delay of slow signals.
    pub fn gain(&self, frequency_hz: f64) -> Complex64 {
        let omega = TAU * frequency_hz / self.low_pass.rate_hz;
        let once = response(&self.low_pass, omega);
        match self.phase {
            Phase::Zero => Complex64::new(once.norm_sqr(), 0.0),
            Phase::Causal => once * Complex64::from_polar(1.0, omega * self.delay),
        }
    }

    /// Records of one length, at `rate_hz`, behind the filter: their Fourier lines times the gain, up to half of either rate.
    /// Those that do not repeat are continued at both ends, `2 x(0) − x(−t)`, as far as the filter remembers.
    pub fn through(&self, records: &[&[f64]], rate_hz: f64, periodic: bool) -> Vec<Vec<f64>> {
        let samples = records.first().map_or(0, |x| x.len());
        let most = if periodic { 0 } else { samples.saturating_sub(1) };
        let remembered = self.low_pass.settling_samples() as f64 * rate_hz / self.low_pass.rate_hz;
        let pad = (2 * remembered.ceil() as usize).min(most);
        let highest = 0.5 * self.low_pass.rate_hz;
        let n = samples + 2 * pad;
        let gains: Vec<Complex64> = (0..=n / 2)
            .map(|l| self.gain((rate_hz * l as f64 / n as f64).min(highest)))
            .collect();
        let one = |x: &&[f64]| {
            let mut lines = forward_of(continued(x, pad));
            lines.iter_mut().zip(&gains).for_each(|(line, gain)| *line *= gain);
            inverse(lines, n)[pad..pad + samples].to_vec()
        };
        records.iter().map(one).collect()
    }
}

fn continued(x: &[f64], pad: usize) -> Vec<f64> {
    let (first, last) = (x[0], x[x.len() - 1]);
    let before = (1..=pad).rev().map(|s| 2.0 * first - x[s]);
    let after = (1..=pad).map(|s| 2.0 * last - x[x.len() - 1 - s]);
    before.chain(x.iter().copied()).chain(after).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave comes out with the gain of its frequency, late by the phase less that of slow signals.
    #[test]
    fn prop_a_wave_keeps_its_shape() {
        for phase in [Phase::Zero, Phase::Causal] {
            let filter = RecordedFilter {
                order: 2,
                cutoff_hz: 10.0,
                rate_hz: 200.0,
                phase,
            };
            let sampled = filter.made().unwrap();
            for hz in [1.0, 10.0] {
                let wave = |s: usize, turn: f64| (TAU * hz * s as f64 / 200.0 + turn).sin();
                let x: Vec<f64> = (0..400).map(|s| wave(s, 0.3)).collect();
                let y = &sampled.through(&[&x], 200.0, true)[0];
                let gain = sampled.gain(hz);
                for (s, y) in y.iter().enumerate() {
                    assert!((y - gain.norm() * wave(s, 0.3 + gain.arg())).abs() < 1e-12);
                }
                assert!((gain.norm_sqr() - sampled.density(hz)).abs() < 1e-12);
            }
            // Half of the power after one run, a quarter after two.
            let at_cutoff = if phase == Phase::Zero { 0.25 } else { 0.5 };
            assert!((sampled.density(10.0) - at_cutoff).abs() < 1e-12);
            // A straight line does not notice either.
            let line: Vec<f64> = (0..400).map(|s| 0.01 * s as f64).collect();
            let behind = &sampled.through(&[&line], 200.0, false)[0];
            assert!((behind[200] - line[200]).abs() < 1e-5, "{}", behind[200] - line[200]);
        }
    }
}
