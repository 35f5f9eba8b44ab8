//! The best level of one joint between the periods of a log.

use super::deviations::{Deviations, TRIES};
use super::level::Level;
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{NoiseModel, Stretch, deviation};

/// The stretch without a parabola in what every period deviates from the mean. Its noise is that from row to row: levels and
/// drifts that are in the periods would pass for noise that is slow, and hide themselves in it.
pub(crate) fn without_slow(stretch: &Stretch) -> Stretch {
    let rows = stretch.rows();
    let x = |s: usize| (2.0 * s as f64 + 1.0) / rows as f64 - 1.0;
    let square = (0..rows).map(|s| x(s) * x(s)).sum::<f64>() / rows as f64;
    // Orthogonal to each other on rows that lie evenly to both sides.
    let basis: [&dyn Fn(usize) -> f64; 3] = [&|_: usize| 1.0, &x, &|s: usize| x(s) * x(s) - square];
    let mut periods = stretch.periods.clone();
    for period in &mut periods {
        for j in 0..stretch.joints() {
            let off = deviation(stretch, period, j);
            for b in basis {
                let (along, norm) = (0..rows).fold((0.0, 0.0), |(a, n), s| (a + b(s) * off[s], n + b(s) * b(s)));
                let size = along / norm.max(f64::MIN_POSITIVE);
                period[j].iter_mut().enumerate().for_each(|(s, t)| *t -= size * b(s));
            }
        }
    }
    Stretch {
        periods,
        ..stretch.clone()
    }
}

/// The level with the best evidence over all joints, where it is beyond chance and large enough to act on.
///
/// `first` are the rows of the first period that do not count.
pub(crate) fn best_level(stretch: &Stretch, noise: &[NoiseModel], first: usize, limit: f64) -> Option<Level> {
    let of_joint = |j: usize| {
        let deviations = Deviations::of(stretch, &noise[j], j, first);
        let tries = (TRIES * stretch.joints()) as f64;
        deviations.levels(tries).into_iter()
    };
    let is_worth_telling = |level: &Level| {
        level.p_value < limit
            && level.evidence > SETTINGS.nonparametric.preference
            && level.rms() > SETTINGS.nonparametric.least_size * noise[level.joint].std_dev
    };
    let all = (0..stretch.joints()).flat_map(of_joint).filter(is_worth_telling);
    all.max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::replicates::level::Along;
    use crate::dynamics::Motion;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::f64::consts::TAU;

    const PERIODS: usize = 5;
    const ROWS: usize = 400;

    /// Box and Muller.
    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        let (u, v): (f64, f64) = (rng.random_range(f64::MIN_POSITIVE..1.0), rng.random_range(0.0..1.0));
        (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
    }

    /// Five periods of 4 s of two joints with unit noise, correlated from row to row, and a level on the second joint.
    fn stretch(seed: u64, correlation: f64, level: impl Fn(usize, f64) -> f64) -> Stretch {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let wave = |j: usize, s: usize| (TAU * (j + 1) as f64 * s as f64 / ROWS as f64 + 0.3).sin_cos();
        let motion = Motion::from_fn(2, ROWS, |j, s| {
            let ((sin, cos), w) = (wave(j, s), 0.5 * TAU * (j + 1) as f64 / 2.0);
            [sin, w * cos, -w * w * sin]
        });
        let mut last = [0.0; 2];
        let mut periods = vec![vec![vec![0.0; ROWS]; 2]; PERIODS];
        for at in 0..PERIODS * ROWS {
            let (p, s) = (at / ROWS, at % ROWS);
            for j in 0..2 {
                last[j] = correlation * last[j] + (1.0 - correlation * correlation).sqrt() * normal(&mut rng);
                periods[p][j][s] = last[j]
                    + if j == 1 {
                        level(p, at as f64 / (PERIODS * ROWS) as f64)
                    } else {
                        0.0
                    };
            }
        }
        let mut whole = Stretch {
            periods,
            starts: (0..PERIODS).map(|p| 4.0 * p as f64).collect(),
            ..Stretch::of_motion(motion, 0.01, true)
        };
        whole.torque = whole.mean_over(&[0, 1, 2, 3, 4]);
        whole
    }

    fn noise(stretch: &Stretch) -> Vec<NoiseModel> {
        let own = without_slow(stretch);
        (0..2)
            .map(|j| NoiseModel::from_periods(std::slice::from_ref(&own), j).unwrap())
            .collect()
    }

    /// Reported p-values are no smaller than they are: of 200 logs, 100 of them with correlated noise, one in twenty falls below
    /// one in twenty. And none has a level.
    #[test]
    fn prop_noise_has_no_level() {
        let mut below = 0;
        for seed in 0..200 {
            let whole = stretch(seed, if seed % 2 == 0 { 0.0 } else { 0.7 }, |_, _| 0.0);
            let noise = noise(&whole);
            assert!(best_level(&whole, &noise, 20, 1e-3).is_none(), "seed {seed}");
            let of = |j: usize| Deviations::of(&whole, &noise[j], j, 20).levels((2 * TRIES) as f64);
            let least = (0..2).flat_map(of).map(|l| l.p_value).fold(1.0, f64::min);
            below += usize::from(least < 0.05);
        }
        // Ten are expected; more than 22 come once in ten thousand times.
        assert!(below <= 22, "{below} of 200");
    }

    #[test]
    fn prop_a_drift_goes_with_time_and_levels_with_periods() {
        // A line, warming up, and levels in no order, of about the size of the noise.
        let levels = [0.9, -0.8, 0.7, -0.9, 0.1];
        let line = stretch(1, 0.0, |_, x| 2.0 * x);
        let warm = stretch(2, 0.7, |_, x| 3.0 * (-x / 0.25).exp());
        let steps = stretch(3, 0.0, |p, _| levels[p]);
        for (whole, along, rms) in [
            // 2/√12; 3 times the deviation of e^(−4x) from its mean over the log; the root of the mean square.
            (line, Along::Time, 0.577),
            (warm, Along::Time, 0.762),
            (steps, Along::Period, 0.743),
        ] {
            let level = best_level(&whole, &noise(&whole), 20, 1e-3).unwrap();
            assert_eq!((level.joint, level.along), (1, along));
            assert!((level.rms() - rms).abs() < 0.1 * rms, "{} for {rms}", level.rms());
            // With it taken out there is nothing left.
            let mut rest = whole.clone();
            level.take_out(&mut rest.periods);
            rest.torque = rest.mean_over(&[0, 1, 2, 3, 4]);
            assert!(best_level(&rest, &noise(&rest), 20, 1e-3).is_none());
        }
    }
}
