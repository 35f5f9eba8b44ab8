//! Tail probabilities that have an answer for every argument: exact fits make F infinite, empty joints leave no degrees of
//! freedom.

use crate::regression::settings::SETTINGS;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

/// Chance of a mean square `statistic` times that of noise, F with `freedom` degrees of freedom above and below. Without degrees
/// of freedom, or where the statistic is no number, nothing was tested: 1.
pub(crate) fn f_tail(statistic: f64, freedom: [f64; 2]) -> f64 {
    if statistic.is_nan() || freedom.iter().any(|d| d.is_nan() || *d < SETTINGS.least_freedom) {
        return 1.0;
    }
    if statistic > SETTINGS.largest_statistic {
        return 0.0;
    }
    if statistic < f64::MIN_POSITIVE {
        return 1.0;
    }
    let [above, below] = freedom.map(|d| d.min(SETTINGS.most_freedom));
    let tail = FisherSnedecor::new(above, below).map_or(1.0, |f| f.sf(statistic.max(0.0)));
    if tail.is_finite() { tail.clamp(0.0, 1.0) } else { 1.0 }
}

/// Chance of a sum of squares of `freedom` normal deviates beyond `statistic`; 1 where nothing was tested.
pub(crate) fn chi_square_tail(statistic: f64, freedom: usize) -> f64 {
    if statistic.is_nan() || freedom == 0 {
        return 1.0;
    }
    if statistic > SETTINGS.largest_statistic {
        return 0.0;
    }
    // Half of less than the least normal number is zero, which the gamma function refuses.
    if statistic < f64::MIN_POSITIVE {
        return 1.0;
    }
    let tail = ChiSquared::new(freedom as f64).map_or(1.0, |c| c.sf(statistic.max(0.0)));
    if tail.is_finite() { tail.clamp(0.0, 1.0) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_argument_has_a_probability() {
        let values = [
            f64::NAN,
            f64::NEG_INFINITY,
            -1.0,
            0.0,
            5e-324,
            1e-300,
            1.0,
            3.7,
            1e30,
            1e150,
            1e308,
            f64::INFINITY,
        ];
        for statistic in values {
            for above in values {
                for below in values {
                    let p = f_tail(statistic, [above, below]);
                    assert!((0.0..=1.0).contains(&p), "F {statistic} {above} {below}: {p}");
                }
            }
            for freedom in [0, 1, 2, 1000, 1 << 40] {
                let p = chi_square_tail(statistic, freedom);
                assert!((0.0..=1.0).contains(&p), "chi² {statistic} {freedom}: {p}");
            }
        }
    }

    /// Tables of the F and chi² distributions at 5 %.
    #[test]
    fn val_tails_are_those_of_tables() {
        for (statistic, freedom) in [(4.965, [1.0, 10.0]), (2.711, [5.0, 20.0])] {
            assert!((f_tail(statistic, freedom) - 0.05).abs() < 1e-4);
        }
        for (statistic, freedom) in [(3.841, 1), (18.307, 10)] {
            assert!((chi_square_tail(statistic, freedom) - 0.05).abs() < 1e-4);
        }
    }
}
