//! Discrete Fourier transforms of real records.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;
use std::cell::RefCell;

thread_local! {
    /// A plan holds as many sines as the record has samples: making one takes longer than using it, and a log has few lengths.
    static PLANS: RefCell<RealFftPlanner<f64>> = RefCell::new(RealFftPlanner::new());
}

/// Lines 0 … N/2 of `Σ x_i exp(−2πi l i/N)`.
pub(crate) fn forward(x: &[f64]) -> Vec<Complex64> {
    let plan = PLANS.with_borrow_mut(|plans| plans.plan_fft_forward(x.len()));
    let mut input = x.to_vec();
    let mut lines = plan.make_output_vec();
    plan.process(&mut input, &mut lines).expect("lengths come from the plan");
    lines
}

/// The record of `n` samples whose [`forward`] transform is `lines`.
pub(crate) fn inverse(mut lines: Vec<Complex64>, n: usize) -> Vec<f64> {
    let plan = PLANS.with_borrow_mut(|plans| plans.plan_fft_inverse(n));
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
    let mut sums = Vec::with_capacity(x.len() + 1);
    sums.push(0.0);
    for v in x {
        sums.push(sums[sums.len() - 1] + v);
    }
    (0..x.len())
        .map(|i| {
            let (from, to) = (i.saturating_sub(half), (i + half + 1).min(x.len()));
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

/// The middle value; NaN for none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
