//! Power of a χ² test.

use crate::regression::chi_square_tail;

/// Chance that a noncentral χ² of `freedom` degrees of freedom and noncentrality `lambda` exceeds `threshold`: the Poisson
/// mixture of central ones (Johnson, Kotz & Balakrishnan 1995, chapter 29).
pub(super) fn power(threshold: f64, freedom: usize, lambda: f64) -> f64 {
    let half = 0.5 * lambda;
    // Ten standard deviations of a Poisson number to either side hold all of it.
    let reach = 10.0 * half.sqrt() + 10.0;
    let first = (half - reach).max(0.0).floor() as usize;
    let last = (half + reach).ceil() as usize;
    let mut log_weight = -half + (1..=first).map(|i| (half / i as f64).ln()).sum::<f64>();
    let mut sum = 0.0;
    for i in first..=last {
        sum += log_weight.exp() * chi_square_tail(threshold, freedom + 2 * i);
        log_weight += (half / (i + 1) as f64).ln();
    }
    sum.min(1.0)
}

/// The noncentrality with which the test has this power.
pub(super) fn noncentrality(threshold: f64, freedom: usize, wanted: f64) -> f64 {
    // The power grows with the noncentrality; at (√threshold + 6)² a normal deviate of six standard deviations is missing to
    // fail.
    let root = bisected(0.0, threshold.max(0.0).sqrt() + 6.0, |x| {
        power(threshold, freedom, x * x) >= wanted
    });
    root * root
}

/// The χ² that chance exceeds with probability `chance`.
pub(super) fn quantile(chance: f64, freedom: usize) -> f64 {
    // A chance of 1e-300 is exceeded at 1400 with one degree of freedom, and at a few more for each of the others.
    bisected(0.0, 2000.0 + 10.0 * freedom as f64, |x| chi_square_tail(x, freedom) < chance)
}

/// Where a condition that holds from some value on begins to hold: forty halvings leave 1e-12 of the interval.
fn bisected(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if holds(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}
