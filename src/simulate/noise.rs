//! Measurement noise.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

/// What the sensors add.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// Standard deviation of every joint's torque [N·m or N].
    pub torque: Vec<f64>,
    /// Correlation of torque noise from one sample to the next, 0 for white.
    #[serde(default)]
    pub torque_correlation: f64,
    /// Standard deviation of the positions [rad or m].
    #[serde(default)]
    pub position: f64,
    /// Steps of the encoder [rad or m]; 0 for none.
    #[serde(default)]
    pub position_step: f64,
    /// Steps of the torque channel [N·m or N]; 0 for none.
    #[serde(default)]
    pub torque_step: f64,
    /// Standard deviation of the sampling instants (s); the log says nominal times.
    #[serde(default)]
    pub jitter: f64,
}

impl Noise {
    /// White torque noise and nothing else.
    pub fn white(torque: Vec<f64>) -> Self {
        Self {
            torque,
            torque_correlation: 0.0,
            position: 0.0,
            position_step: 0.0,
            torque_step: 0.0,
            jitter: 0.0,
        }
    }
}

/// A standard normal number (Box & Muller).
pub(super) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random_range(f64::MIN_POSITIVE..1.0), rng.random_range(0.0..1.0));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// A first-order autoregressive series of the given standard deviation.
pub(super) fn correlated(rng: &mut ChaCha8Rng, samples: usize, std_dev: f64, correlation: f64) -> Vec<f64> {
    let fresh = (1.0 - correlation * correlation).sqrt();
    let mut state = normal(rng);
    (0..samples)
        .map(|_| {
            let value = state * std_dev;
            state = correlation * state + fresh * normal(rng);
            value
        })
        .collect()
}

/// Rounds to whole steps; a step of 0 leaves the value alone.
pub(super) fn quantised(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}
