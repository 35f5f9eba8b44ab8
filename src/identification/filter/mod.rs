//! Low-pass filters and differences that do not delay.

mod butterworth;
mod zero_phase;

pub use butterworth::{FilterError, LowPass, Section};
pub use zero_phase::{Padding, zero_phase};

/// Central differences of samples `step` apart; one-sided at the ends.
pub fn central_difference(x: &[f64], step: f64) -> Vec<f64> {
    let n = x.len();
    match n {
        0 => Vec::new(),
        1 => vec![0.0],
        _ => (0..n)
            .map(|i| match i {
                0 => (x[1] - x[0]) / step,
                i if i == n - 1 => (x[i] - x[i - 1]) / step,
                i => (x[i + 1] - x[i - 1]) / (2.0 * step),
            })
            .collect(),
    }
}

/// Central differences of one period of something that repeats.
pub fn central_difference_periodic(x: &[f64], step: f64) -> Vec<f64> {
    let n = x.len();
    (0..n).map(|i| (x[(i + 1) % n] - x[(i + n - 1) % n]) / (2.0 * step)).collect()
}
