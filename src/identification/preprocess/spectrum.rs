//! Discrete Fourier transforms of real records.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

/// A plan holds as many sines as the record has samples: making one takes longer than using it, and a log has few lengths.
static PLANS: LazyLock<Mutex<RealFftPlanner<f64>>> = LazyLock::new(|| Mutex::new(RealFftPlanner::new()));

/// The planner that all threads share. One that panicked has left no plan half made.
fn plans() -> MutexGuard<'static, RealFftPlanner<f64>> {
    PLANS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Lines 0 … N/2 of `Σ x_i exp(−2πi l i/N)`.
pub(crate) fn forward(x: &[f64]) -> Vec<Complex64> {
    forward_of(x.to_vec())
}

/// The same of a record that nobody else needs.
pub(crate) fn forward_of(mut x: Vec<f64>) -> Vec<Complex64> {
    let plan = plans().plan_fft_forward(x.len());
    let mut lines = plan.make_output_vec();
    plan.process(&mut x, &mut lines).expect("lengths come from the plan");
    lines
}

/// The record of `n` samples whose [`forward`] transform is `lines`.
pub(crate) fn inverse(mut lines: Vec<Complex64>, n: usize) -> Vec<f64> {
    let plan = plans().plan_fft_inverse(n);
    // A real record has a real mean and, with an even count, a real last line.
    lines[0].im = 0.0;
    if n.is_multiple_of(2) {
        lines[n / 2].im = 0.0;
    }
    let mut x = plan.make_output_vec();
    plan.process(&mut lines, &mut x).expect("lengths come from the plan");
    x.iter_mut().for_each(|v| *v /= n as f64);
    x
}

/// Centred moving mean over `2 half + 1` lines, shorter at the ends.
pub(crate) fn smoothed(x: &[f64], half: usize) -> Vec<f64> {
    let n = x.len();
    let mut sum = 0.0;
    let mut sums = Vec::with_capacity(n + 1);
    sums.push(sum);
    sums.extend(x.iter().map(|v| {
        sum += v;
        sum
    }));
    let mean = |i: usize| {
        let (from, to) = (i.saturating_sub(half), (i + half + 1).min(n));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    let (start, end) = (half.min(n), n.saturating_sub(half).max(half.min(n)));
    // All of the middle has neighbours on both sides.
    let width = (2 * half + 1) as f64;
    let middle = sums.get(2 * half + 1..).unwrap_or(&[]).iter().zip(&sums);
    let mut means = Vec::with_capacity(n);
    means.extend((0..start).map(mean));
    means.extend(middle.map(|(to, from)| (to - from) / width));
    means.extend((end..n).map(mean));
    means
}

/// The middle value; NaN for none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
