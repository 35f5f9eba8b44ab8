//! The paper's finite Fourier series (12).

use super::Trajectory;
use nalgebra::{DMatrix, Vector3};
use std::f64::consts::TAU;

/// `q_i(t) = offset_i + Σ_l a_il/(ω l) sin(ω l t) − b_il/(ω l) cos(ω l t)`, l = 1 … L, ω = 2π · fundamental.
///
/// So `qd_i = Σ a cos + b sin`: coefficients are velocity amplitudes [rad/s or m/s].
#[derive(Debug, Clone, PartialEq)]
pub struct FourierSeries {
    /// Fundamental frequency ω_f/2π (Hz).
    pub fundamental_hz: f64,
    /// n × L.
    pub a: DMatrix<f64>,
    /// n × L.
    pub b: DMatrix<f64>,
    /// n; rad or m.
    pub offset: Vec<f64>,
}

impl FourierSeries {
    /// A series at rest at `offset`.
    pub fn at_rest(offset: Vec<f64>, order: usize, fundamental_hz: f64) -> Self {
        let zeros = DMatrix::zeros(offset.len(), order);
        Self {
            fundamental_hz,
            a: zeros.clone(),
            b: zeros,
            offset,
        }
    }

    /// Harmonics N_f.
    pub fn order(&self) -> usize {
        self.a.ncols()
    }

    /// ω = 2π · fundamental [rad/s].
    pub fn angular_frequency(&self) -> f64 {
        TAU * self.fundamental_hz
    }

    /// `sqrt(a² + b²)` of harmonic `l` (from 1) of `joint`: its velocity amplitude.
    pub fn amplitude(&self, joint: usize, l: usize) -> f64 {
        self.a[(joint, l - 1)].hypot(self.b[(joint, l - 1)])
    }
}

/// What one harmonic with `a = 1` (first) or `b = 1` (second) adds to `[q, qd, qdd]` at phase `ω l t`.
pub(crate) fn harmonic(omega: f64, l: usize, t: f64) -> [Vector3<f64>; 2] {
    let frequency = omega * l as f64;
    let (s, c) = (frequency * t).sin_cos();
    [
        Vector3::new(s / frequency, c, -frequency * s),
        Vector3::new(-c / frequency, s, frequency * c),
    ]
}

impl Trajectory for FourierSeries {
    fn joints(&self) -> usize {
        self.offset.len()
    }

    fn duration(&self) -> f64 {
        1.0 / self.fundamental_hz
    }

    fn state(&self, joint: usize, t: f64) -> [f64; 3] {
        let mut state = Vector3::new(self.offset[joint], 0.0, 0.0);
        for l in 1..=self.order() {
            let [sine, cosine] = harmonic(self.angular_frequency(), l, t);
            state += sine * self.a[(joint, l - 1)] + cosine * self.b[(joint, l - 1)];
        }
        state.into()
    }
}
