//! Trajectories with analytic velocities and accelerations.
//!
//! The finite Fourier series (12) excites; sums of sines and fifth-order way-point polynomials validate (the paper's section
//! 4.6).

mod fourier;
mod quintic;
mod sine;

pub use fourier::FourierSeries;
pub(crate) use fourier::harmonic;
pub use quintic::QuinticWayPoints;
pub use sine::SineSeries;

use crate::dynamics::Motion;

/// A motion of n joints in time.
pub trait Trajectory {
    /// Number of joints n.
    fn joints(&self) -> usize;

    /// Length (s); periodic trajectories repeat after it.
    fn duration(&self) -> f64;

    /// `[q, qd, qdd]` of `joint` at time `t` (s).
    fn state(&self, joint: usize, t: f64) -> [f64; 3];

    /// Samples at `t = k / rate_hz`, k = 0 … N−1, all before [`Self::duration`]: the end of a periodic trajectory is its start.
    fn sample(&self, rate_hz: f64) -> Motion {
        let samples = sample_count(self.duration(), rate_hz);
        Motion::from_fn(self.joints(), samples, |j, s| self.state(j, s as f64 / rate_hz))
    }
}

/// Number of samples `k / rate_hz` before `duration`; a duration that is a whole number of samples up to rounding counts as that.
pub fn sample_count(duration: f64, rate_hz: f64) -> usize {
    let samples = duration * rate_hz;
    let whole = samples.round();
    // 1e-9 of the length is far above the rounding of a product and far below one sample.
    if (samples - whole).abs() <= 1e-9 * whole {
        whole as usize
    } else {
        samples.ceil() as usize
    }
}
