use super::power::{noncentrality, power, quantile};

/// The noncentral χ² of SciPy 1.x (`ncx2.sf`) and of textbooks.
#[test]
fn val_powers_and_quantiles_are_those_of_tables() {
    // One degree of freedom: the two tails of a normal deviate of mean √λ.
    let normal = |x: f64| 0.5 * statrs::function::erf::erfc(x / 2f64.sqrt());
    for (threshold, lambda) in [(3.84f64, 7.85f64), (20.0, 33.0), (30.0, 0.5), (25.0, 1600.0)] {
        let (t, m) = (threshold.sqrt(), lambda.sqrt());
        let wanted = normal(t - m) + normal(t + m);
        assert!((power(threshold, 1, lambda) - wanted).abs() < 1e-10, "{threshold} {lambda}");
    }
    for (threshold, freedom, lambda, wanted) in [(30.0, 3, 45.0, 0.9187123475625145), (60.0, 7, 20.0, 0.0028097784323100933)] {
        assert!(
            (power(threshold, freedom, lambda) - wanted).abs() < 1e-10,
            "{threshold} {freedom} {lambda}"
        );
    }
    // Power 0.9 of a test at 5 %: the noncentralities of every textbook (Cohen 1988, table 12.3.2).
    for (freedom, wanted) in [(1, 10.507), (2, 12.654), (3, 14.171), (10, 20.532)] {
        let found = noncentrality(quantile(0.05, freedom), freedom, 0.9);
        assert!((found - wanted).abs() < 2e-3, "{freedom}: {found}");
    }
}
