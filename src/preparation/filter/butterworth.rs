//! Butterworth low-pass filters as second-order sections.

use std::f64::consts::PI;

/// One second-order section, `H(z) = (b0 + b1 z⁻¹ + b2 z⁻²) / (1 + a1 z⁻¹ + a2 z⁻²)`, of gain one at frequency zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Coefficients of the numerator, of `z⁰`, `z⁻¹`, `z⁻²`.
    pub b: [f64; 3],
    /// `a1, a2`.
    pub a: [f64; 2],
}

/// A digital low-pass filter as a chain of sections.
///
/// High orders at low frequencies (order 20 at 2 Hz and 1 kHz, say) have poles so close together that the coefficients of the
/// whole polynomial cannot hold them in double precision; sections of two poles each can.
#[derive(Debug, Clone, PartialEq)]
pub struct LowPass {
    /// Order: poles of the analogue filter.
    pub order: usize,
    /// Frequency at which half of the power is left (Hz).
    pub cutoff_hz: f64,
    /// Sampling rate (Hz).
    pub rate_hz: f64,
    /// Sections of second order, applied one after the other.
    pub sections: Vec<Section>,
}

/// Why a filter cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FilterError {
    /// The order is out of range.
    #[error("the order is {0}: a low-pass filter has order 1 to {MAX_ORDER}")]
    Order(usize),
    /// The cut-off is not between zero and half the sampling rate.
    #[error("the cut-off is {cutoff_hz} Hz: it must lie between 0 and half the sample rate, {half_rate_hz} Hz")]
    Cutoff {
        /// Cut-off that was asked for (Hz).
        cutoff_hz: f64,
        /// Half the sampling rate (Hz).
        half_rate_hz: f64,
    },
}

/// Filters beyond this ring for longer than they smooth; nothing in use comes near it.
const MAX_ORDER: usize = 64;

impl LowPass {
    /// Butterworth filter of `order` with −3 dB at `cutoff_hz`, for samples at `rate_hz`: the analogue prototype's poles
    /// `exp(iπ(2k + n + 1)/2n)`, k = 0 … n−1, scaled to the warped cut-off `2 f_s tan(π f_c/f_s)` and mapped by the bilinear
    /// transform.
    ///
    /// # Errors
    /// Order zero or beyond 64; a cut-off outside (0, rate/2).
    pub fn butterworth(order: usize, cutoff_hz: f64, rate_hz: f64) -> Result<Self, FilterError> {
        if order == 0 || order > MAX_ORDER {
            return Err(FilterError::Order(order));
        }
        let half_rate_hz = rate_hz / 2.0;
        if !(cutoff_hz > 0.0 && cutoff_hz < half_rate_hz) {
            return Err(FilterError::Cutoff { cutoff_hz, half_rate_hz });
        }
        // With t = tan(π fc/fs) the pole p = t exp(iφ) maps to z = (1 + p)/(1 − p).
        let t = (PI * cutoff_hz / rate_hz).tan();
        let mut sections = Vec::new();
        if order % 2 == 1 {
            let z = (1.0 - t) / (1.0 + t);
            let gain = (1.0 - z) / 2.0;
            sections.push(Section {
                b: [gain, gain, 0.0],
                a: [-z, 0.0],
            });
        }
        // From the most damped pair to the least: the resonant sections come last, where the signal is already smooth.
        for k in (0..order / 2).rev() {
            let phase = PI * (2 * k + order + 1) as f64 / (2 * order) as f64;
            let (re, im) = (t * phase.cos(), t * phase.sin());
            let scale = (1.0 - re) * (1.0 - re) + im * im;
            let real = (1.0 - re * re - im * im) / scale;
            let square = ((1.0 + re) * (1.0 + re) + im * im) / scale;
            // 1 − 2 Re z + |z|² in a form without cancellation: 4 t² / scale.
            let gain = t * t / scale;
            sections.push(Section {
                b: [gain, 2.0 * gain, gain],
                a: [-2.0 * real, square],
            });
        }
        Ok(Self {
            order,
            cutoff_hz,
            rate_hz,
            sections,
        })
    }

    /// `|H|²` at `frequency_hz`: `1 / (1 + (tan(π f/fs)/tan(π fc/fs))^2n)`.
    pub fn power(&self, frequency_hz: f64) -> f64 {
        let ratio = (PI * frequency_hz / self.rate_hz).tan() / (PI * self.cutoff_hz / self.rate_hz).tan();
        1.0 / (1.0 + ratio.abs().powi(2 * self.order as i32))
    }

    /// Samples after which the slowest mode has decayed to 1e-3 of where it began: what the ends of a record remember of the
    /// padding.
    pub fn settling_samples(&self) -> usize {
        self.samples_to_decay(1e-3)
    }

    /// Samples after which the slowest mode has decayed to this part of where it began.
    pub(crate) fn samples_to_decay(&self, part: f64) -> usize {
        let slowest = self
            .sections
            .iter()
            .map(|s| if s.b[2] == 0.0 { s.a[0].abs() } else { s.a[1].sqrt() })
            .fold(0.0, f64::max);
        (part.ln() / slowest.ln()).ceil() as usize
    }
}
