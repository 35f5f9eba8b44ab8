//! What is not known of a motion: the noise and rounding of positions that their derivatives keep.

/// Error of one joint's motion, the same in every period that its mean stands for.
///
/// The positions that a motion is made of have noise, and steps where they are recorded coarsely; the Fourier series or the
/// filter keeps the part of it below its highest frequency, and derivatives raise it. A model that is evaluated along this motion
/// is off by as much times its derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionError {
    /// Standard deviation of position, velocity and acceleration [rad, rad/s, rad/s² or m, m/s, m/s²].
    pub std_dev: [f64; 3],
    /// How much denser the spectrum of the errors of position, velocity and acceleration is, where the motion's own acceleration
    /// has its power, than that of white noise of the same variance; no column of the rigid body has its power at higher
    /// frequencies than the acceleration.
    pub density: [f64; 3],
}

impl MotionError {
    /// Of white noise of variance `variance` per sample behind a low-pass filter:
    /// `σ² 2/f_s ∫₀^fc (2πf)^2p df = σ² 2 (2π)^2p fc^(2p+1) / ((2p+1) f_s)` of derivative p. The filter's cut-off is where the
    /// motion ends: the density counts there, where it is highest.
    pub(crate) fn behind_low_pass(variance: f64, cutoff_hz: f64, rate_hz: f64) -> Self {
        let of = |p: i32| {
            let power = std::f64::consts::TAU.powi(2 * p) * cutoff_hz.powi(2 * p + 1) / f64::from(2 * p + 1);
            (2.0 * variance * power / rate_hz).sqrt()
        };
        let used = (2.0 * cutoff_hz / rate_hz).min(1.0);
        let density = |p: i32| if used > 0.0 { f64::from(2 * p + 1) / used } else { 1.0 };
        Self {
            std_dev: [of(0), of(1), of(2)],
            density: [density(0), density(1), density(2)],
        }
    }
}
