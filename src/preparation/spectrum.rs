//! Discrete Fourier transforms of real records.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;
use std::collections::BTreeSet;
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

/// A plan holds as many sines as the record has samples: making one takes longer than using it, and a log has few lengths. All
/// threads share them.
static PLANS: LazyLock<Mutex<Plans>> = LazyLock::new(Mutex::default);

/// Samples whose plans are kept at most: those of the longest logs, in some 100 MB. A server that runs for months sees many
/// lengths.
const MOST_PLANNED: usize = 4 << 20;

#[derive(Default)]
struct Plans {
    planner: RealFftPlanner<f64>,
    /// Lengths that the planner has seen, forward and back.
    lengths: BTreeSet<(usize, bool)>,
}

impl Plans {
    /// What `plan` makes for `samples`, forward or back. Plans that are in use live on when the planner forgets them.
    fn plan<T>(&mut self, samples: usize, back: bool, plan: impl FnOnce(&mut RealFftPlanner<f64>, usize) -> T) -> T {
        let made = plan(&mut self.planner, samples);
        self.lengths.insert((samples, back));
        if self.lengths.iter().map(|l| l.0).sum::<usize>() > MOST_PLANNED {
            *self = Self::default();
        }
        made
    }
}

/// A planner that panicked has left no plan half made.
fn plans() -> MutexGuard<'static, Plans> {
    PLANS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Lines 0 … N/2 of `Σ x_i exp(−2πi l i/N)`.
pub(crate) fn forward(x: &[f64]) -> Vec<Complex64> {
    forward_of(x.to_vec())
}

/// The same of a record that nobody else needs.
pub(crate) fn forward_of(mut x: Vec<f64>) -> Vec<Complex64> {
    let plan = plans().plan(x.len(), false, RealFftPlanner::plan_fft_forward);
    let mut lines = plan.make_output_vec();
    plan.process(&mut x, &mut lines).expect("lengths come from the plan");
    lines
}

/// The record of `n` samples whose [`forward`] transform is `lines`.
pub(crate) fn inverse(mut lines: Vec<Complex64>, n: usize) -> Vec<f64> {
    let plan = plans().plan(n, true, RealFftPlanner::plan_fft_inverse);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_plans_of_many_lengths_are_forgotten() {
        let mut plans = Plans::default();
        let kept = |plans: &Plans| plans.lengths.iter().map(|l| l.0).sum::<usize>();
        for n in 0..200 {
            // Plans of short records alone are made: it is their number that counts.
            let plan = plans.plan(100_000 + n, n % 2 == 0, |planner, _| planner.plan_fft_forward(16));
            assert_eq!(plan.len(), 16);
            assert!(kept(&plans) <= MOST_PLANNED);
        }
        assert!(kept(&plans) > 0);
        // One that is longer than all that is kept is used all the same.
        plans.plan(2 * MOST_PLANNED, false, |planner, _| planner.plan_fft_forward(16));
        assert_eq!(kept(&plans), 0);
    }
}
