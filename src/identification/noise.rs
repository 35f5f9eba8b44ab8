//! How noise that is correlated in time reaches the parameters.
//!
//! Least squares with weights wⱼ gives `θ̂ = A⁻¹ Σ wⱼ Wⱼᵀ τⱼ`, hence the covariance `A⁻¹ (Σ wⱼ² Mⱼ) A⁻¹` with `Mⱼ = Wⱼᵀ Rⱼ Wⱼ` and Rⱼ the
//! covariance of joint j's noise over time. Averaging and filtering leave Rⱼ far from diagonal, and rows that follow each other
//! closely then count for less than their number. Rⱼ is (nearly) circulant, so Mⱼ is a sum over Fourier lines:
//! `Mⱼ = 1/L Σ_l S_l conj(Ŵ_l) Ŵ_lᵀ`, S the noise's spectrum. With white noise this is σ² WᵀW, the textbook's formula.

use super::normal::gram;
use super::preprocess::spectrum::{forward, forward_of, inverse};
use super::{Observation, PreparedLog};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use realfft::num_complex::Complex64;

/// Spectrum of the noise in one joint's rows: variance per line, lines 0 … L/2 of a record of L ≥ R rows. The mean over all L
/// lines is the variance of a row.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseSpectrum {
    pub length: usize,
    pub lines: Vec<f64>,
}

impl NoiseSpectrum {
    /// White noise of `variance` over `rows` rows.
    pub fn white(variance: f64, rows: usize) -> Self {
        Self {
            length: rows,
            lines: vec![variance; rows / 2 + 1],
        }
    }

    /// From the scatter of the periods, passed through the row filter: measured without a model. `None` without periods.
    ///
    /// A single line has few degrees of freedom; it is smoothed over a quarter of an octave on either side, which keeps the rise
    /// towards low frequencies that friction and drift cause.
    pub fn from_scatter(log: &PreparedLog, joint: usize) -> Option<Self> {
        let raw = &log.scatter.as_ref()?.spectrum[joint];
        let mut lines = smoothed_in_octaves(raw);
        if let Some(filter) = &log.row_filter.torque {
            let step = log.rate_hz / log.samples() as f64;
            lines
                .iter_mut()
                .enumerate()
                .for_each(|(l, v)| *v *= filter.power(l as f64 * step).powi(2));
        }
        let rows = log.row_filter.rows(log.samples()).len();
        let d = log.row_filter.decimation;
        let whole = Self {
            length: log.samples(),
            lines,
        };
        Some(if rows * d == log.samples() {
            whole.folded(d)
        } else {
            whole.folded(d).stretched(rows)
        })
    }

    /// From a residual of R rows (zero where a row is not used) that has `freedom` degrees of freedom left:
    /// autocovariance under Bartlett's window up to `2 √R` rows.
    pub fn from_residual(residual: &DVector<f64>, freedom: f64) -> Self {
        let rows = residual.len();
        let reach = (2.0 * (rows as f64).sqrt()).ceil() as usize;
        // Zeros behind the record keep its end from meeting its start.
        let length = rows + reach;
        let padded: Vec<f64> = residual.iter().copied().chain(std::iter::repeat_n(0.0, reach)).collect();
        let power: Vec<Complex64> = forward(&padded).iter().map(|x| Complex64::new(x.norm_sqr(), 0.0)).collect();
        let mut covariance = inverse(power, length);
        let scale = 1.0 / freedom.max(1.0);
        for (lag, v) in covariance.iter_mut().enumerate() {
            let distance = lag.min(length - lag);
            *v *= scale * (1.0 - distance as f64 / reach as f64).max(0.0);
        }
        let lines = forward(&covariance).iter().map(|x| x.re.max(0.0)).collect();
        Self { length, lines }
    }

    /// Spectrum of every `decimation`-th row: lines fold onto each other.
    fn folded(self, decimation: usize) -> Self {
        if decimation == 1 {
            return self;
        }
        let length = self.length / decimation;
        let at = |l: usize| self.lines[(l % self.length).min(self.length - l % self.length).min(self.lines.len() - 1)];
        let lines = (0..=length / 2)
            .map(|l| (0..decimation).map(|m| at(l + m * length)).sum::<f64>() / decimation as f64)
            .collect();
        Self { length, lines }
    }

    /// The same density over a record of `length` rows.
    fn stretched(&self, length: usize) -> Self {
        let last = (self.lines.len() - 1) as f64;
        let half = length / 2;
        let lines = (0..=half)
            .map(|l| {
                let place = (l as f64 / half.max(1) as f64 * last).min(last);
                let i = place.floor() as usize;
                let next = self.lines[(i + 1).min(self.lines.len() - 1)];
                self.lines[i] + (place - i as f64) * (next - self.lines[i])
            })
            .collect();
        Self { length, lines }
    }

    /// How often a line of the half spectrum counts in the whole one.
    fn multiplicity(&self, line: usize) -> f64 {
        if line == 0 || 2 * line == self.length { 1.0 } else { 2.0 }
    }

    /// Variance of one row.
    pub fn variance(&self) -> f64 {
        self.lines
            .iter()
            .enumerate()
            .map(|(l, s)| s * self.multiplicity(l))
            .sum::<f64>()
            / self.length as f64
    }

    /// Number of independent values that R rows of this noise are worth: `(tr R)² / tr R² = R (Σ S)² / (L Σ S²)`.
    pub fn effective_rows(&self, rows: usize) -> f64 {
        let sum: f64 = self.lines.iter().enumerate().map(|(l, s)| s * self.multiplicity(l)).sum();
        let squares: f64 = self.lines.iter().enumerate().map(|(l, s)| s * s * self.multiplicity(l)).sum();
        if squares == 0.0 {
            rows as f64
        } else {
            rows as f64 * sum * sum / (squares * self.length as f64)
        }
    }

    /// `Wᵀ R W` for the rows of one joint, w × w.
    pub fn pass(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let half = self.length / 2 + 1;
        let factor = |l: usize| (self.lines[l] * self.multiplicity(l) / self.length as f64).sqrt();
        let factors: Vec<f64> = (0..half).map(factor).collect();
        let mut weighted = DMatrix::zeros(2 * half, matrix.ncols());
        for (column, mut out) in matrix.column_iter().zip(weighted.column_iter_mut()) {
            let mut padded = Vec::with_capacity(self.length);
            padded.extend_from_slice(column.as_slice());
            padded.resize(self.length, 0.0);
            let parts = out.as_mut_slice().chunks_exact_mut(2);
            for ((x, factor), part) in forward_of(padded).iter().zip(&factors).zip(parts) {
                part[0] = factor * x.re;
                part[1] = factor * x.im;
            }
        }
        gram(&weighted)
    }
}

/// Every line averaged over a quarter of its own frequency on either side, at least four lines.
fn smoothed_in_octaves(lines: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0];
    lines.iter().for_each(|v| sums.push(sums[sums.len() - 1] + v));
    (0..lines.len())
        .map(|l| {
            let half = (l / 4).max(4);
            let (from, to) = (l.saturating_sub(half), (l + half + 1).min(lines.len()));
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

/// `Σ` over logs of `WⱼᵀRⱼWⱼ` on the columns of joint j, for spectra per log and joint.
pub(super) fn passed(observations: &[Observation], spectra: &[Vec<NoiseSpectrum>]) -> Vec<DMatrix<f64>> {
    let of = |(o, spectra): (&Observation, &Vec<NoiseSpectrum>)| -> Vec<DMatrix<f64>> {
        let joints = o.matrices.par_iter().zip(spectra);
        joints.map(|(matrix, spectrum)| spectrum.pass(matrix)).collect()
    };
    observations
        .iter()
        .zip(spectra)
        .map(of)
        .reduce(|mut sum, part| {
            sum.iter_mut().zip(part).for_each(|(a, b)| *a += b);
            sum
        })
        .expect("at least one log")
}
