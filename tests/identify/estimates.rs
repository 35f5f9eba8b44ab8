//! Base parameters of simulated robots.

use crate::simulated::{POSITION_NOISE, TORQUE_NOISE, Virtual, excitation, noisy};
use dynident::preparation::{Log, Period, PreparedLog, PreprocessOptions, prepare};
use dynident::regression::{Estimate, Estimator, Stretch, estimate};

fn fit(robot: &Virtual, log: &Log, estimator: Estimator) -> (PreparedLog, Estimate) {
    let prepared = prepare(log, 7, &PreprocessOptions::default()).unwrap();
    let found = estimate(&robot.robot, &[Stretch::new(&prepared, log)], estimator);
    (prepared, found.estimate)
}

#[test]
fn prop_without_noise_the_parameters_come_back() {
    let robot = Virtual::iiwa14();
    let log = robot.clean(&excitation(1, 10.0), 100.0, 2);
    for estimator in [Estimator::Ordinary, Estimator::Weighted, Estimator::Robust] {
        let (_, found) = fit(&robot, &log, estimator);
        // Derivatives of the sampled series are exact to rounding, 1e-12; the Gram matrix squares the condition number, about 50.
        let worst = (&found.values - robot.truth()).amax();
        assert!(worst < 1e-8, "{estimator:?} {worst:e}");
    }
}

/// Fits the log again under 50 noise seeds: deviations must be honest both ways.
fn check_honest(clean: &Log, options: &PreprocessOptions) {
    let robot = Virtual::iiwa14();
    let truth = robot.truth();
    let mut scores = Vec::new();
    for seed in 0..50 {
        let log = noisy(clean, POSITION_NOISE, &TORQUE_NOISE, seed);
        let prepared = prepare(&log, 7, options).unwrap();
        let found = estimate(&robot.robot, &[Stretch::new(&prepared, &log)], Estimator::Weighted).estimate;
        scores.extend((0..truth.len()).map(|c| (found.values[c] - truth[c]) / found.std_dev(c)));
    }
    let variance = scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64;
    let within = scores.iter().filter(|z| z.abs() < 3.0).count() as f64 / scores.len() as f64;
    assert!((0.8..1.25).contains(&variance), "{variance}");
    assert!(within >= 0.99, "{within}");
}

#[test]
fn prop_standard_deviations_are_honest_over_fifty_noise_seeds() {
    let clean = Virtual::iiwa14().clean(&excitation(2, 10.0), 200.0, 6);
    check_honest(&clean, &PreprocessOptions::default());
}

/// Without periods the rows are filtered and go together in time: the degrees of freedom have to allow for that.
#[test]
fn prop_standard_deviations_are_honest_where_torque_and_regressor_are_filtered() {
    let clean = Virtual::iiwa14().clean(&excitation(2, 10.0), 200.0, 3);
    let options = PreprocessOptions {
        period: Period::None,
        ..PreprocessOptions::default()
    };
    check_honest(&clean, &options);
}

#[test]
fn prop_the_noise_of_every_joint_is_measured_without_a_model() {
    let robot = Virtual::iiwa14();
    let log = noisy(&robot.clean(&excitation(3, 10.0), 200.0, 6), POSITION_NOISE, &TORQUE_NOISE, 5);
    let (prepared, found) = fit(&robot, &log, Estimator::Weighted);
    let scatter = prepared.scatter.as_ref().unwrap();
    for (j, expected) in TORQUE_NOISE.iter().enumerate() {
        // 10,000 degrees of freedom: the standard deviation is known to 0.7 %, four of which are 3 %.
        assert!((scatter.std_dev[j] / expected - 1.0).abs() < 0.03);
        let fit = &found.joints[j];
        // 2000 rows: the mean square scatters by 3 %, four of which are 13 %.
        assert!((fit.misfit.unwrap() - 1.0).abs() < 0.13, "{:?}", fit.misfit);
    }
}

#[test]
fn prop_a_joint_that_stands_still_leaves_directions_open_and_they_are_not_given_numbers() {
    let robot = Virtual::iiwa14();
    let mut series = excitation(4, 10.0);
    for l in 0..5 {
        (series.a[(6, l)], series.b[(6, l)]) = (0.0, 0.0);
    }
    let log = noisy(&robot.clean(&series, 100.0, 4), 0.0, &TORQUE_NOISE, 6);
    let (_, found) = fit(&robot, &log, Estimator::Weighted);
    let at = |name: &str| robot.base.names.iter().position(|n| n == name).unwrap();
    for name in ["FV7", "FS7"] {
        assert!(found.std_dev(at(name)).is_infinite(), "{name}");
    }
    assert!(found.std_dev(at("FV1")).is_finite());
    assert!(found.solution.rank < 57);
    assert_eq!(found.solution.null_directions.len(), 57 - found.solution.rank);
    assert!(found.solution.condition_number().is_infinite());
}

#[test]
fn prop_gross_errors_do_the_robust_estimate_no_harm() {
    let robot = Virtual::iiwa14();
    let mut log = noisy(&robot.clean(&excitation(5, 10.0), 200.0, 1), 0.0, &TORQUE_NOISE, 7);
    for s in (0..log.samples()).step_by(50) {
        log.tau[1][s] += 40.0;
    }
    let error = |estimator| {
        let options = PreprocessOptions {
            period: Period::Known {
                period_s: 10.0,
                order: Some(5),
            },
            ..PreprocessOptions::default()
        };
        let prepared = prepare(&log, 7, &options).unwrap();
        let found = estimate(&robot.robot, &[Stretch::new(&prepared, &log)], estimator).estimate;
        (found.values - robot.truth()).norm()
    };
    let (robust, ordinary) = (error(Estimator::Robust), error(Estimator::Ordinary));
    // One row in fifty is 130 σ off: least squares is wrong by 2.7 σ on average there, Huber by 1.345 σ / 50, which is lost in
    // the noise.
    assert!(robust < 0.3 * ordinary, "{robust} {ordinary}");
}
