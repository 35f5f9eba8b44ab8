//! What is not known of a motion: the noise and rounding of positions that their derivatives keep.

/// Error of one joint's motion, the same in every period that its mean stands for.
///
/// The positions that a motion is made of have noise, and steps where they are recorded coarsely; the Fourier series or the filter keeps the part of it
/// below its highest frequency, and derivatives raise it. A model that is evaluated along this motion is off by as much times its derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionError {
    /// Standard deviation of position, velocity and acceleration [rad, rad/s, rad/s² or m, m/s, m/s²].
    pub std_dev: [f64; 3],
    /// Highest frequency that it has [cycles per sample].
    pub band: f64,
}

impl MotionError {
    /// Of white noise of variance `variance` per sample behind a low-pass filter: `σ² 2/f_s ∫₀^fc (2πf)^2p df = σ² 2 (2π)^2p fc^(2p+1) / ((2p+1) f_s)` of
    /// derivative p.
    pub(crate) fn behind_low_pass(variance: f64, cutoff_hz: f64, rate_hz: f64) -> Self {
        let of = |p: i32| {
            let power = std::f64::consts::TAU.powi(2 * p) * cutoff_hz.powi(2 * p + 1) / f64::from(2 * p + 1);
            (2.0 * variance * power / rate_hz).sqrt()
        };
        Self {
            std_dev: [of(0), of(1), of(2)],
            band: cutoff_hz / rate_hz,
        }
    }

    /// How much denser the spectrum of the error of derivative `order` is than that of white noise of the same variance, where it is densest: at the end of
    /// its band, towards which it grows with the frequency's power `2 order`.
    pub(crate) fn density(&self, order: usize) -> f64 {
        let used = (2.0 * self.band).min(1.0);
        if used > 0.0 { (2 * order + 1) as f64 / used } else { 1.0 }
    }
}
